"""Errors of the sensors in a flight: what is refused, what the history shows, and what the controllers make of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flying import flown
from uavftc.analysis.metrics import metrics_of
from uavftc.config.shipped import scenario_names
from uavftc.core.signals import AXES, attitude_error, column
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.checks import warnings
from uavftc.scenario.load import load_scenario

BIAS = ("sensors.gyro_bias_degps=0.3",)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_the_observer_takes_out_the_bias_of_a_gyro(plant):
    # scenario 2, 0.3 deg/s on each axis: without the observer 0.3 / D = 0.6 deg remain, up to the coupling of the axes
    for controller in ("nndondi-l1", "ndi-l1"):
        _, records, outcome = flown("scenario2", plant, controller, BIAS)
        assert outcome.completed
        found = np.array([metrics_of(records)[axis]["steady_state_error_deg"] for axis in AXES], dtype=float)
        if controller == "nndondi-l1":
            assert (found < 0.05).all(), found
        else:
            assert (found > 0.4).all(), found


def test_the_history_shows_what_the_controller_is_shown():
    # attitude and rates, next to the true ones; the heading within half a turn of its reference
    overrides = ("sensors.attitude_bias_deg=[1, 0, 350]", "sensors.gyro_bias_degps=[0, 2, 0]")
    _, records, _ = flown("scenario1", "analytic", None, overrides)
    np.testing.assert_allclose(column(records, "phi_meas_rad"), column(records, "phi_rad") + np.radians(1), rtol=1e-14)
    np.testing.assert_array_equal(column(records, "theta_meas_rad"), column(records, "theta_rad"))
    np.testing.assert_allclose(column(records, "q_meas_radps"), records["x2"][:, 1] + np.radians(2), rtol=1e-14)
    heading = column(records, "psi_meas_rad") - column(records, "psi_ref_rad")
    assert np.abs(heading).max() <= np.pi
    turns = (column(records, "psi_meas_rad") - records["x1"][:, 2] - np.radians(350)) / (2 * np.pi)
    np.testing.assert_allclose(turns, -1.0, atol=1e-12)


def test_the_measured_attitude_is_flown_to_the_reference():
    # nothing can see the bias of an attitude: the aircraft ends as far off as the sensor is
    _, records, _ = flown("scenario1", "jsbsim", None, ("sensors.attitude_bias_deg=[1, -0.5, 0.7]",))
    np.testing.assert_allclose(np.degrees(attitude_error(records)[-1]), [1, -0.5, 0.7], atol=0.02)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("gyro_noise_density_degps_per_rthz", "-0.1", ["at least 0", "deg/s/sqrt(Hz)"]),
        ("attitude_noise_density_deg_per_rthz", "[1, 2]", ["list of three"]),
        ("attitude_random_walk_deg_per_rts", "[1, x, 1]", ["deg/sqrt(s)"]),
        ("gyro_quantisation_degps", "[0, -1, 0]", ["at least 0", "deg/s"]),
        ("gyro_delay_s", "601", ["at most 600 s"]),
        ("gyro_dropout", "[{mean_lost_s: 1}]", ["gyro_dropout[0].mean_between_s", "or neither"]),
        ("gyro_dropout", "[{mode: last}]", ["gyro_dropout[0].mode", "one of hold, zero"]),
        ("attitude_dropout", "[{start_s: 3, end_s: 2}]", ["after start_s, 3 s"]),
        ("attitude_stuck", "[{axis: pitsch}]", ["did you mean pitch?"]),
        ("attitude_stuck", "[{at_degps: 1}]", ["at_degps", "did you mean at_deg?"]),
        ("gyro_stuck", "{axis: roll}", ["a list"]),
    ],
)
def test_what_is_wrong_is_refused_with_what_is_expected(key, value, words):
    with pytest.raises(InputError) as told:
        load_scenario("scenario1", overrides=[f"sensors.{key}={value}"])
    for word in (f"key sensors.{key}", *words):
        assert word in str(told.value)


def test_a_window_after_the_end_of_the_flight_is_warned_of():
    scenario = load_scenario("scenario1", overrides=["sensors.gyro_stuck=[{start_s: 30}]"])
    (line,) = warnings(scenario)
    assert line.startswith("sensors.gyro_stuck[0]: starts at 30 s, after the end of the flight at 20 s")


SHIPPED = [name for name in scenario_names("beyond") if Path(name).name.startswith("sensor-")]


def test_each_error_has_its_scenarios():
    errors = {name.split("sensor-")[1].removesuffix("-c172p") for name in SHIPPED}
    assert errors == {
        "bias", "delay", "dropout", "misalignment", "noise", "quantisation", "random-walk", "scale-factor", "stuck",
    }  # fmt: skip
    assert len(SHIPPED) == 2 * len(errors)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_error_is_flown_and_does_something(name):
    # the vehicle stays within 2 deg of its reference in the end, and was shown something else than the truth
    scenario = load_scenario(name)
    assert scenario.description
    assert "\n" not in scenario.description
    assert name.endswith(scenario.name)
    records, outcome = fly_to_memory(build_flight(scenario))
    assert outcome.completed
    wrong = [not np.array_equal(records[f"{x}_meas"], records[x]) for x in ("x1", "x2")]
    assert any(wrong)
    assert np.abs(np.degrees(attitude_error(records)[-1])).max() < 2.0
