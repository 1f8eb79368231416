"""What a scenario prescribes, sampled into rows: windows, sums, units, the trim that references count from."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.aircraft.effectors import mixing_of
from uavftc.core.layout import Layout
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight.build import build_flight
from uavftc.flight.inputs import Inputs
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

RATE = 200.0
DEG = np.pi / 180.0


def scenario(**sections):
    return Scenario.model_validate({"name": "inputs", "duration_s": 20, "plant": "analytic", **sections})


def filled(n=4001, x1_trim=(0.0, 0.0, 0.0), first=0, **sections):
    """Return the records of n rows from sample `first` on."""
    records = as_records(empty_rows(n))
    Inputs(scenario(**sections), np.array(x1_trim)).fill(records, first)
    return records


def acceleration(start=0.0, end=None, **parts):
    return {"kind": "angular-acceleration", "start_s": start, "end_s": end, **parts}


def test_time_is_the_sample_number_over_the_rate():
    # t_k = k / rate to the bit, not a sum of steps: after an hour the clock has not drifted.
    t = filled(3, first=720_000, duration_s=3700)["t"]
    np.testing.assert_array_equal(t, [3600.0, 3600.005, 3600.01])


def test_without_faults_the_surfaces_are_whole():
    # Effectiveness is 1, everything else 0: a quiet scenario prescribes a healthy aircraft in still air.
    records = filled(10)
    np.testing.assert_array_equal(records["effectiveness"], 1.0)
    for field in ("bias", "d1", "d2", "wind_n", "x1_c"):
        np.testing.assert_array_equal(records[field], 0.0, err_msg=field)


def test_references_count_from_the_trim_in_degrees():
    # 5 deg from a trim pitch of 0.03 rad is 0.03 + 0.0873 rad: absolute, in the row's unit, on the right axis.
    records = filled(3, x1_trim=(0.0, 0.03, 1.0), reference={"phi_deg": 5, "theta_deg": 5, "psi_deg": "-2 * t"})
    np.testing.assert_allclose(records["x1_c"][:, 0], 5 * DEG)
    np.testing.assert_allclose(records["x1_c"][:, 1], 0.03 + 5 * DEG)
    np.testing.assert_allclose(records["x1_c"][:, 2], 1.0 - 2 * DEG * np.array([0.0, 0.005, 0.01]))


def test_reference_of_a_flight_counts_from_its_own_trim():
    # At 25 m/s the trim pitches up by 0.45 deg; the command of 2 deg is 2 deg above that, not above the horizon.
    flight = build_flight(
        Scenario.model_validate(
            {"name": "t", "duration_s": 1, "initial": {"airspeed_mps": 25}, "reference": {"theta_deg": 2}}
        )
    )
    records = as_records(empty_rows(1))
    flight.inputs.fill(records, 0)
    assert flight.plant.x1_trim[1] > 0.005
    assert records["x1_c"][0, 1] == pytest.approx(flight.plant.x1_trim[1] + 2 * DEG, abs=1e-15)


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.005), (8.0, 12.0), (0.1, 0.3), (0.0025, 0.0125)])
def test_windows_hold_their_start_and_not_their_end(start, end):
    # [start, end): the sample at the start acts, the one at the end does not, for faults and disturbances alike.
    records = filled(
        disturbances=[acceleration(start, end, q_degps2=3)],
        faults=[{"surface": "elevator", "start_s": start, "end_s": end, "effectiveness": 0.5, "bias_deg": 1}],
    )
    k = np.arange(4001)
    inside = (k >= np.ceil(start * RATE - 1e-9)) & (k < np.ceil(end * RATE - 1e-9))
    assert inside.any()
    np.testing.assert_array_equal(records["d2"][:, 1] != 0.0, inside)
    np.testing.assert_array_equal(records["effectiveness"][:, 1], np.where(inside, 0.5, 1.0))
    np.testing.assert_array_equal(records["bias"][:, 1] != 0.0, inside)


def test_an_open_window_lasts_to_the_end():
    # end_s null: the last row of the flight still has the disturbance.
    records = filled(disturbances=[acceleration(19.0, p_degps2=1)])
    assert np.count_nonzero(records["d2"][:, 0]) == 201


def test_every_quantity_lands_in_its_field_with_its_unit():
    # deg/s^2, deg/s and deg become rad; m/s stays; axes in the order of the row; each on no other field.
    records = filled(
        5,
        plant="jsbsim",
        disturbances=[
            acceleration(p_degps2=1, q_degps2=2, r_degps2=3),
            {"kind": "wind", "north_mps": 7, "east_mps": 8, "down_mps": 9},
        ],
        faults=[{"surface": "rudder", "bias_deg": 3, "effectiveness": 0.2}],
    )
    np.testing.assert_allclose(records["d2"], np.broadcast_to(np.array([1, 2, 3]) * DEG, (5, 3)), rtol=1e-15)
    np.testing.assert_array_equal(records["wind_n"], np.broadcast_to([7.0, 8.0, 9.0], (5, 3)))
    np.testing.assert_allclose(records["bias"], np.broadcast_to([0.0, 0.0, 3 * DEG], (5, 3)), rtol=1e-15)
    np.testing.assert_array_equal(records["effectiveness"], np.broadcast_to([1.0, 1.0, 0.2], (5, 3)))
    np.testing.assert_array_equal(records["d1"], 0.0)
    rate = filled(5, disturbances=[{"kind": "attitude-rate", "phi_degps": 4, "theta_degps": 5, "psi_degps": 6}])
    np.testing.assert_allclose(rate["d1"], np.broadcast_to(np.array([4, 5, 6]) * DEG, (5, 3)), rtol=1e-15)
    np.testing.assert_array_equal(rate["d2"], 0.0)


def test_overlapping_disturbances_add_up():
    # Two pushes on the same axis, overlapping from 2 s to 3 s, sum there; wind and gust sum as well.
    records = filled(
        plant="jsbsim",
        disturbances=[
            acceleration(1.0, 3.0, p_degps2=1),
            acceleration(2.0, 4.0, p_degps2="10 * t"),
            {"kind": "wind", "north_mps": 2},
            {"kind": "gust", "start_s": 5, "ramp_s": 1, "hold_s": 1, "north_mps": 3},
        ],
    )
    t = np.arange(4001) / RATE
    expected = DEG * (1.0 * ((t >= 1) & (t < 3)) + 10.0 * t * ((t >= 2) & (t < 4)))
    np.testing.assert_allclose(records["d2"][:, 0], expected, atol=1e-15)
    assert records["wind_n"][1300, 0] == pytest.approx(5.0, abs=1e-12)  # 6.5 s: the gust holds
    assert records["wind_n"][0, 0] == 2.0
    assert records["wind_n"][4000, 0] == pytest.approx(2.0, abs=1e-12)


def test_scenario_3_is_the_papers_table():
    # The faults of section 4 written here once more, from 8 to 12 s; the rudder's 0.2 t is taken literally.
    records = as_records(empty_rows(4001))
    Inputs(load_scenario("scenario3", plant="analytic"), np.zeros(3)).fill(records, 0)
    t = np.arange(4001) / RATE
    on = (t >= 8.0) & (t < 12.0)
    assert records["effectiveness"][on][:, 2] == pytest.approx(0.2 * t[on], rel=1e-14)
    assert records["effectiveness"][on][0, 2] == pytest.approx(1.6)
    assert np.degrees(records["bias"][on][:, 2]) == pytest.approx(3.0 * np.cos(0.1 * t[on]), rel=1e-12)


@pytest.mark.parametrize("text", ["1 / (t - 8)", "sqrt(t - 8.001)", "1 / sqrt(t - 8.001)"])
def test_expressions_are_evaluated_inside_their_window_only(text):
    # An expression that is not a number before 8 s does not matter to the flight before 8 s.
    window = acceleration(8.005, 12.0, p_degps2=text)
    records = filled(disturbances=[window])
    assert np.all(np.isfinite(records["d2"]))
    np.testing.assert_array_equal(records["d2"][:1601], 0.0)
    t = np.arange(1601, 2400) / RATE
    root = np.sqrt(t - 8.001)
    by_hand = {"1 / (t - 8)": 1 / (t - 8), "sqrt(t - 8.001)": root, "1 / sqrt(t - 8.001)": 1 / root}[text]
    np.testing.assert_allclose(records["d2"][1601:2400, 0], DEG * by_hand, rtol=1e-12, atol=1e-15)


def test_a_fault_lands_on_the_effectors_that_belong_to_its_surface():
    # A row holds the fault per axis, which is published, and per effector, which is flown; the order is the aircraft's.
    fault = {"surface": "rudder", "start_s": 0.01, "bias_deg": 3, "effectiveness": 0.2}
    effectors = ("upper", "aileron", "lower", "elevator")
    gangs = {"aileron": {"aileron": 1.0}, "elevator": {"elevator": 1.0}, "rudder": {"upper": 1.0, "lower": 1.0}}
    layout = Layout(effectors, mixing_of(effectors, gangs), gangs)
    records = as_records(empty_rows(4, len(effectors)))
    Inputs(scenario(faults=[fault]), np.zeros(3), layout).fill(records, 0)
    omega, bias = np.where(np.arange(4) < 2, 1.0, 0.2), np.where(np.arange(4) < 2, 0.0, 3 * DEG)
    np.testing.assert_array_equal(records["effectiveness"][:, 2], omega)
    np.testing.assert_allclose(records["bias"][:, 2], bias, rtol=1e-15)
    for j, name in enumerate(effectors):
        hit = name in gangs["rudder"]
        np.testing.assert_array_equal(records["effectors"]["effectiveness"][:, j], omega if hit else 1.0)
        np.testing.assert_allclose(records["effectors"]["bias"][:, j], bias if hit else 0.0, rtol=1e-15)


def test_chunks_are_the_whole_to_the_bit():
    # The loop fills rows in chunks; where they are cut must not show, or a long flight would differ from a short one.
    sections = {
        "plant": "jsbsim",
        "reference": {"phi_deg": "5 * sin(0.3 * t)", "psi_deg": "t"},
        "disturbances": [
            acceleration(1.0, 9.0, p_degps2="sin(t)", q_degps2="sin(2 * t)"),
            {"kind": "gust", "start_s": 2, "ramp_s": 1.3, "hold_s": 2, "east_mps": 4, "down_mps": -1},
            {"kind": "wind", "start_s": 3, "north_mps": "2 * cos(t)"},
        ],
        "faults": [{"surface": "rudder", "start_s": 8, "end_s": 12, "effectiveness": "0.2 * t", "bias_deg": "t"}],
    }
    whole = filled(**sections)
    rows = empty_rows(4001)
    inputs = Inputs(scenario(**sections), np.zeros(3))
    for first, last in ((0, 1), (1, 800), (800, 1601), (1601, 1602), (1602, 4001)):
        inputs.fill(as_records(rows)[first:last], first)
    assert rows.tobytes() == whole.tobytes()
    for field in ("x1_c", "d2", "wind_n", "effectiveness", "bias"):
        assert np.ptp(whole[field]) > 0.1 * DEG, field


def test_wind_at_the_start_is_that_of_the_first_sample():
    # The flight starts in the air of t = 0: all of it, and nothing of what comes later.
    inputs = Inputs(
        scenario(
            plant="jsbsim",
            disturbances=[
                {"kind": "wind", "north_mps": "3 + t", "east_mps": 1},
                {"kind": "wind", "start_s": 5, "down_mps": 9},
            ],
        ),
        np.zeros(3),
    )
    np.testing.assert_array_equal(inputs.wind_at_start(), [3.0, 1.0, 0.0])
    assert inputs.acts_on("wind_n")
    assert not inputs.acts_on("d2")


def test_what_is_absent_is_known_to_be_absent():
    # The plant never writes wind or moment that no scenario asks for.
    quiet = Inputs(scenario(), np.zeros(3))
    pushed = Inputs(scenario(disturbances=[acceleration(p_degps2=1)]), np.zeros(3))
    assert [quiet.acts_on(field) for field in ("wind_n", "d1", "d2")] == [False, False, False]
    assert [pushed.acts_on(field) for field in ("wind_n", "d1", "d2")] == [False, False, True]
