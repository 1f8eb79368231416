"""Severe faults against their closed forms: on the total deflection, inside the window, and the identity after it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from uavftc import actuators
from uavftc.control import allocation
from uavftc.core.given import Given
from uavftc.core.program import Program
from uavftc.core.signals import SURFACES, as_records, empty_rows
from uavftc.errors import InputError
from uavftc.flight.build import chain_blocks
from uavftc.flight.named import refuse_impossible, remarks
from uavftc.scenario.schema import Scenario

H, N = 0.005, 400
T = np.arange(N) * H
TRIM = np.array([0.0, -0.1, 0.05])  # rad, as the laws count
SENSE = np.array([1.0, -1.0, 1.0])  # a stock elevator: positive is trailing edge down, and pitches down
STOPS = np.column_stack([-0.4 - TRIM, 0.4 - TRIM])  # 0.4 rad either side of neutral
MIXING = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
GANGS = {"aileron": {"left": 1.0, "right": -1.0}, "elevator": {"elevator": 1.0}, "rudder": {"rudder": 1.0}}


def flown(fault, *, substeps=1, seed=0, gangs=False, stops=None, alpha=0.0, beta=0.0):
    """The commands v2 and the records after the chain, of a fault on 0.5 to 1.5 s of a flight of 2 s."""
    entry = {"start_s": 0.5, "end_s": 1.5, **fault}
    scenario = Scenario.model_validate({"name": "c", "duration_s": 2, "seed": seed, "faults": [entry]})
    layout = {"effectors": SURFACES, "mixing": np.eye(3), "trim_rad": TRIM, "sense": SENSE}
    if gangs:
        layout = {"effectors": ("left", "right", "elevator", "rudder"), "mixing": MIXING, "gangs": GANGS}
    n = len(layout["effectors"])
    limits = STOPS if stops is None else np.array([stops] * 3)
    given = Given(
        h=H,
        plant_step=H / substeps,
        steps=N,
        seed=seed,
        stops_rad=np.array([[-0.4, 0.4]] * n) if gangs else limits,
        design=SimpleNamespace(),
        faults=tuple(scenario.faults),
        **layout,
    )
    refuse_impossible(scenario, given)
    allocate, gather = allocation.blocks(given)
    program = Program([], [allocate, *chain_blocks(actuators.CHAIN, scenario, given), gather], substeps=substeps)
    rows = empty_rows(N, n)
    records = as_records(rows)
    v2 = 0.1 * np.column_stack([np.sin(3.0 * T), np.cos(2.0 * T), np.sin(5.0 * T + 1.0)])
    records["t"], records["v2"], records["effectors"]["effectiveness"] = T, v2, 1.0
    records["alpha"], records["beta"] = alpha, beta
    assert program.run(rows, 0, N) == N
    return v2, records, remarks(scenario, given)


INSIDE = (T >= 0.5) & (T < 1.5)
FIRST, AFTER = np.flatnonzero(INSIDE)[0], np.flatnonzero(INSIDE)[-1] + 1
KINDS = [
    {"kind": "stuck"},
    {"kind": "stuck", "at_deg": 3},
    {"kind": "hardover", "rate_degps": 20},
    {"kind": "hardover"},
    {"kind": "hardover", "rate_degps": 5, "to_deg": -2},
    {"kind": "oscillatory", "amplitude_deg": 1, "frequency_hz": 2},
    {"kind": "oscillatory", "amplitude_deg": 1, "frequency_hz": 2, "mode": "solid"},
    {"kind": "drift", "rate_degps": -3},
    {"kind": "float", "ratio": 0.4},
    {"kind": "intermittent", "on_s": 0.1, "off_s": 0.1, "bias_deg": 1},
    {"kind": "total-loss"},
]


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("fault", KINDS, ids=lambda f: "-".join(map(str, f.values())))
def test_outside_its_window_a_fault_is_the_identity_bit_for_bit(fault, surface):
    # also after it, and on every other surface all along
    v2, records, _ = flown({**fault, "surface": surface})
    i = SURFACES.index(surface)
    same = np.ones((N, 3), bool)
    same[INSIDE, i] = False
    np.testing.assert_array_equal(records["u2"][same], v2[same])
    assert not np.array_equal(records["u2"][INSIDE, i], v2[INSIDE, i])


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_stuck_surface_stays_where_it_was_at_the_plant_step_before(substeps):
    v2, records, _ = flown({"kind": "stuck", "surface": "rudder"}, substeps=substeps)
    np.testing.assert_allclose(records["u2"][INSIDE, 2], v2[FIRST - 1, 2], rtol=0, atol=1e-16)


@pytest.mark.parametrize(("surface", "i"), [("aileron", 0), ("elevator", 1), ("rudder", 2)])
def test_a_given_place_is_the_total_deflection_as_the_aircraft_counts_it(surface, i):
    # 3 deg of position, the trim included: a stock elevator counts the other way than the axis
    _, records, _ = flown({"kind": "stuck", "surface": surface, "at_deg": 3})
    position = SENSE[i] * (TRIM[i] + records["u2"][INSIDE, i])
    np.testing.assert_allclose(position, np.radians(3.0), rtol=0, atol=1e-15)


def test_a_place_of_a_gang_counts_as_its_axis():
    # 3 deg of aileron: the left one 3 deg, the right one -3 deg
    _, records, _ = flown({"kind": "stuck", "surface": "aileron", "at_deg": 3}, gangs=True)
    np.testing.assert_allclose(records["effectors"]["position"][INSIDE, 0], np.radians(3.0), atol=1e-15)
    np.testing.assert_allclose(records["effectors"]["position"][INSIDE, 1], np.radians(-3.0), atol=1e-15)
    np.testing.assert_allclose(records["u2"][INSIDE, 0], np.radians(3.0), atol=1e-15)


def test_half_of_a_gang_stuck_leaves_the_other_half():
    v2, records, _ = flown({"kind": "stuck", "surface": "left", "at_deg": 3}, gangs=True)
    np.testing.assert_allclose(records["u2"][INSIDE, 0], (np.radians(3.0) + v2[INSIDE, 0]) / 2, atol=1e-15)


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("rate", [40.0, -40.0])
def test_a_hardover_reaches_the_stop_in_the_way_over_the_rate(rate, substeps):
    # closed form at each row; at the stop after (stop - start) / rate to one plant step
    v2, records, _ = flown({"kind": "hardover", "surface": "rudder", "rate_degps": rate}, substeps=substeps)
    start, stop = v2[FIRST - 1, 2], STOPS[2, 1 if rate > 0 else 0]
    expected = start + np.radians(rate) * (T[INSIDE] - T[FIRST])
    expected = np.minimum(expected, stop) if rate > 0 else np.maximum(expected, stop)
    np.testing.assert_allclose(records["u2"][INSIDE, 2], expected, rtol=0, atol=1e-14)
    there = T[np.argmax(records["u2"][:, 2] == stop)] - T[FIRST]
    way = (stop - start) / np.radians(rate)
    assert way - 1e-9 <= there <= way + H


def test_a_hardover_without_a_rate_is_at_the_stop_at_once():
    _, records, _ = flown({"kind": "hardover", "surface": "rudder"})
    np.testing.assert_array_equal(records["u2"][INSIDE, 2], STOPS[2, 1])


def test_a_hardover_of_a_stock_elevator_runs_down_where_its_position_counts_down():
    _, records, _ = flown({"kind": "hardover", "surface": "elevator", "rate_degps": 90, "to_deg": 10})
    position = SENSE[1] * (TRIM[1] + records["u2"][:, 1])
    assert abs(position[AFTER - 1] - np.radians(10.0)) < 1e-15


@pytest.mark.parametrize("mode", ["liquid", "solid"])
def test_an_oscillation_has_its_amplitude_and_frequency_in_the_spectrum(mode):
    fault = {"kind": "oscillatory", "surface": "aileron", "amplitude_deg": 1.5, "frequency_hz": 4, "mode": mode}
    v2, records, _ = flown(fault)
    u2 = records["u2"][INSIDE, 0]
    expected = np.radians(1.5) * np.sin(2 * np.pi * 4.0 * (T[INSIDE] - T[FIRST]))
    np.testing.assert_allclose(u2, expected + (v2[INSIDE, 0] if mode == "liquid" else 0.0), rtol=0, atol=1e-14)
    added = u2 - (v2[INSIDE, 0] if mode == "liquid" else 0.0)
    lines = 2.0 * np.abs(np.fft.rfft(added)) / INSIDE.sum()  # a window of 1 s: 1 Hz a line
    assert np.argmax(lines) == 4
    assert abs(lines[4] - np.radians(1.5)) < 1e-12
    assert np.delete(lines, 4).max() < 1e-12


def test_a_drift_grows_with_time_from_the_beginning_of_its_window_to_the_stop():
    v2, records, _ = flown({"kind": "drift", "surface": "rudder", "rate_degps": -40})
    expected = v2[INSIDE, 2] - np.radians(40.0) * (T[INSIDE] - T[FIRST])
    np.testing.assert_allclose(records["u2"][INSIDE, 2], np.maximum(expected, STOPS[2, 0]), rtol=0, atol=1e-14)
    assert (expected < STOPS[2, 0]).any()


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize(("surface", "i", "flow"), [("aileron", 0, 0.2), ("elevator", 1, 0.2), ("rudder", 2, -0.1)])
def test_a_floating_surface_tends_to_its_ratio_of_the_flow(surface, i, flow, substeps):
    # y = k flow + (y0 - k flow) exp(-t / T); the elevator by alpha and the rudder by beta, as their positions count
    fault = {"kind": "float", "surface": surface, "ratio": 0.4, "time_constant_s": 0.15}
    v2, records, _ = flown(fault, substeps=substeps, alpha=0.2, beta=-0.1)
    start = SENSE[i] * (TRIM[i] + v2[FIRST - 1, i])
    elapsed = T[INSIDE] - T[FIRST] + H / substeps  # at the end of the first plant step of each row
    expected = 0.4 * flow + (start - 0.4 * flow) * np.exp(-elapsed / 0.15)
    np.testing.assert_allclose(SENSE[i] * (TRIM[i] + records["u2"][INSIDE, i]), expected, rtol=0, atol=1e-14)
    assert abs(expected[-1] / (0.4 * flow) - 1.0) < 0.01


def test_a_gang_floats_surface_by_surface():
    # both ailerons go up with the angle of attack, and give no roll
    _, records, _ = flown({"kind": "float", "surface": "aileron", "ratio": 0.5}, gangs=True, alpha=0.2)
    assert abs(records["u2"][AFTER - 1, 0]) < 1e-5
    np.testing.assert_allclose(records["effectors"]["position"][AFTER - 1, :2], 0.1, rtol=1e-3)


def test_a_lost_surface_has_no_total_deflection():
    _, records, _ = flown({"kind": "total-loss", "surface": "elevator"})
    np.testing.assert_array_equal(TRIM[1] + records["u2"][INSIDE, 1], 0.0)


def test_an_intermittent_fault_comes_and_goes_with_its_mean_times():
    # eq. (6) or nothing at each row; the same seed draws the same times, another seed others
    fault = {"kind": "intermittent", "surface": "aileron", "on_s": 0.02, "off_s": 0.06, "effectiveness": 0.5}
    fault |= {"bias_deg": 1, "start_s": 0, "end_s": None}
    v2, records, _ = flown(fault)
    acted = records["u2"][:, 0] != v2[:, 0]
    np.testing.assert_allclose(records["u2"][acted, 0], 0.5 * v2[acted, 0] + np.radians(1.0), rtol=0, atol=1e-16)
    assert acted[0]
    again, other = flown(fault)[1], flown(fault, seed=1)[1]
    np.testing.assert_array_equal(again["u2"], records["u2"])
    assert not np.array_equal(other["u2"], records["u2"])


def test_the_times_of_an_intermittent_fault_have_the_stated_means():
    from uavftc.actuators.intermittent import Config, changes_of

    entry = Config(surface="aileron", on_s=0.4, off_s=1.5)
    given = SimpleNamespace(steps=4_000_000, h=H, seed=3)
    times = np.diff(np.concatenate([[0.0], changes_of(entry, given, 0)]))
    for part, mean in ((times[0::2], 0.4), (times[1::2], 1.5)):
        assert abs(part.mean() / mean - 1.0) < 4.0 / np.sqrt(len(part))  # the error of the mean is mean / sqrt(n)
        assert abs(part.std() / mean - 1.0) < 0.05  # exponential: as wide as its mean
    assert len(times) > 19_000


@pytest.mark.parametrize(
    ("fault", "key", "said"),
    [
        ({"kind": "hardover", "rate_degps": 0}, "rate_degps", "a rate other than 0"),
        ({"kind": "oscillatory", "amplitude_deg": 1, "frequency_hz": 100}, "frequency_hz", "below 100 Hz"),
    ],
)
def test_what_cannot_be_flown_is_refused(fault, key, said):
    with pytest.raises(InputError) as told:
        flown({**fault, "surface": "rudder"})
    assert f"faults[0].{key}" in str(told.value)
    assert said in str(told.value)


def test_a_hardover_needs_a_stop_or_a_place():
    with pytest.raises(InputError, match="no mechanical stop"):
        flown({"kind": "hardover", "surface": "rudder", "rate_degps": 5}, stops=(-np.inf, np.inf))


def test_a_place_beyond_the_stop_is_worth_a_remark():
    _, records, said = flown({"kind": "stuck", "surface": "elevator", "at_deg": 30})
    assert said == [
        "faults[0].at_deg: 30 is beyond a stop: elevator has its stops at -22.92 and 22.92 deg, where it stays"
    ]
    np.testing.assert_allclose(records["u2"][INSIDE, 1], STOPS[1, 0], rtol=0, atol=1e-15)
