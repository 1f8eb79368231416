"""One list says what happens in a flight and when: of each kind of window exactly what the scenario says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uavftc.core.layout import Layout
from uavftc.results.windows import ENGINE, VEHICLE, FlightWindow, windows_of
from uavftc.scenario.schema import Scenario

HALE = Layout(
    names=("left_aileron", "right_aileron", "elevator", "rudder"),
    mixing=np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]),
    gangs={
        "aileron": {"left_aileron": 0.5, "right_aileron": -0.5},
        "elevator": {"elevator": 1.0},
        "rudder": {"rudder": 1.0},
    },
    trim_rad=np.zeros(4),
    position_sign=np.ones(4),
)
OF_ROLL = {"aileron", "phi", "p", "f_p"}


def windows(**sections: Any) -> tuple[FlightWindow, ...]:
    scenario = Scenario.model_validate({"name": "x", "duration_s": 20, "plant": "jsbsim", **sections})
    return windows_of(scenario, HALE)


def only(**sections: Any) -> FlightWindow:
    (found,) = windows(**sections)
    return found


def test_a_fault_of_a_gang_concerns_its_members_and_its_axis():
    entry = {"surface": "aileron", "start_s": 8, "end_s": 12, "effectiveness": 0.8, "bias_deg": "0.1*t"}
    found = only(faults=[entry])
    members = {"left_aileron", "right_aileron"}
    assert found == FlightWindow("fault", "aileron", "ω = 0.8\nbias 0.1*t deg", 8.0, 12.0, frozenset(OF_ROLL | members))
    assert found.name == "aileron: ω = 0.8, bias 0.1*t deg"


def test_a_fault_of_one_effector_concerns_no_other_one():
    found = only(faults=[{"kind": "hardover", "surface": "left_aileron", "rate_degps": 20, "start_s": 3}])
    assert (found.what, found.label, found.start_s) == ("left aileron", "hardover", 3.0)
    assert found.end_s == 20.0  # an end that is left out is that of the flight
    assert found.concerns == OF_ROLL | {"left_aileron"}


@pytest.mark.parametrize(
    ("known", "expected"),
    [
        ({}, (None, None)),
        ({"known": True}, (8.0, 12.0)),
        ({"known": True, "known_after_s": 0.7}, (8.7, 12.7)),
        ({"known": True, "known_after_s": 0.7, "end_s": None}, (8.7, 20.0)),
    ],
)
def test_when_the_controller_is_told_is_that_of_the_fault(known, expected):
    found = only(faults=[{"surface": "rudder", "start_s": 8, "end_s": 12, "effectiveness": 0.5} | known])
    assert (found.known_from_s, found.known_until_s) == expected


def test_an_engine_is_named_and_concerns_thrust_and_energy():
    by_number, by_name = windows(
        faults=[
            {"kind": "reduced", "engine": 1, "start_s": 2, "end_s": 4, "power": 0.6},
            {"kind": "loss", "engine": "left_motor", "start_s": 5},
        ]
    )
    assert by_number == FlightWindow("engine", "engine 1", "throttle times 0.6", 2.0, 4.0, ENGINE)
    assert (by_name.name, by_name.end_s) == ("left motor: lost", 20.0)


def test_damage_concerns_the_vehicle_and_only_the_effectors_it_takes():
    mass, power = windows(
        damage=[
            {"name": "bird strike", "mass_kg": -3, "start_s": 5},
            {"control_power": {"rudder": 0.5}, "start_s": 6, "end_s": 7},
        ]
    )
    assert mass == FlightWindow("damage", "damage", "bird strike", 5.0, 20.0, VEHICLE)
    assert (power.label, power.concerns) == ("rudder 50 %", {"rudder", "psi", "r", "f_r"})


AIR = [
    ({"kind": "wind", "north_mps": 3, "down_mps": "2*sin(t)"}, "wind, north 3, down 2*sin(t) m/s", 20.0),
    ({"kind": "gust", "ramp_s": 0.7, "hold_s": 1, "down_mps": -15}, "gust, down -15 m/s", 3.4),
    ({"kind": "gust-train", "count": 3, "ramp_s": 0.5, "east_mps": 2}, "3 gusts, east 2 m/s", 4.0),
    ({"kind": "shear", "north_mps": 4}, "power shear, north 4 m/s at 10 m", 20.0),
    ({"kind": "turbulence", "severity": "moderate"}, "moderate Dryden turbulence", 20.0),
    (
        {"kind": "turbulence", "model": "von-karman", "sigma_mps": [1, 1, 1], "length_m": [9, 9, 9]},
        "von Karman turbulence, 1 m/s rms",
        20.0,
    ),
]


@pytest.mark.parametrize(("entry", "label", "end"), AIR, ids=[label for _, label, _ in AIR])
def test_moving_air_is_named_with_its_strength_and_ends_with_the_last_gust(entry, label, end):
    # a gust of 0.7 s up, 1 s held and 0.7 s down from 1 s on ends at 3.4 s; three of 1 s, back to back, at 4 s
    assert only(disturbances=[{"start_s": 1, **entry}]) == FlightWindow("air", "", label, 1.0, end, VEHICLE | {"wind"})


def test_a_disturbance_concerns_the_estimates_of_the_axes_it_acts_on():
    found = only(disturbances=[{"kind": "angular-acceleration", "p_degps2": 1, "r_degps2": "sin(t)", "end_s": 9}])
    assert (found.kind, found.label, found.end_s) == ("disturbance", "p 1, r sin(t) deg/s^2", 9.0)
    assert found.concerns == {"f_p", "f_r"}
    found = only(plant="analytic", disturbances=[{"kind": "attitude-rate", "theta_degps": 0.2}])
    assert (found.label, found.concerns) == ("pitch 0.2 deg/s", {"d1_theta"})


def test_the_window_of_a_sensor_concerns_its_axis():
    stuck, lost, random = windows(
        sensors={
            "attitude_stuck": [{"start_s": 2, "end_s": 3, "axis": "yaw", "at_deg": 4}],
            "gyro_dropout": [
                {"start_s": 4, "axis": "roll", "mode": "zero"},
                {"start_s": 5, "mean_lost_s": 0.1, "mean_between_s": 1},
            ],
        }
    )
    assert stuck == FlightWindow("sensor", "yaw attitude", "stuck at 4 deg", 2.0, 3.0, frozenset({"psi"}))
    assert (lost.name, lost.concerns) == ("roll gyro: lost, shows 0", {"p", "d1_phi"})
    assert random.name == "gyro: lost at times, holds"
    assert random.concerns == {"p", "q", "r", "d1_phi", "d1_theta", "d1_psi"}


def test_an_error_of_a_sensor_that_lasts_is_listed_and_shades_nothing():
    found = windows(
        sensors={
            "gyro_bias_degps": [0.3, 0, -0.1],
            "attitude_noise_density_deg_per_rthz": 0.002,
            "attitude_scale_factor_error": 0.01,
        }
    )
    assert {w.name for w in found} == {
        "gyro: bias 0.3, 0, -0.1 deg/s",
        "attitude: noise density 0.002 deg/sqrt(Hz)",
        "attitude: scale factor error 0.01",
    }
    assert {(w.kind, w.start_s, w.end_s, w.concerns) for w in found} == {("sensor", 0.0, 20.0, frozenset())}


def test_the_order_is_that_of_their_beginnings_and_what_begins_after_the_flight_is_none():
    found = windows(
        faults=[
            {"surface": "rudder", "start_s": 6, "effectiveness": 0.5},
            {"surface": "elevator", "start_s": 20, "effectiveness": 0.5},
        ],
        damage=[{"mass_kg": -1, "start_s": 3}],
        disturbances=[{"kind": "gust", "start_s": 3, "ramp_s": 1, "down_mps": 1}],
    )
    assert [(w.kind, w.start_s) for w in found] == [("air", 3.0), ("damage", 3.0), ("fault", 6.0)]


def test_nothing_happens_in_a_flight_of_which_nothing_is_said():
    assert windows() == ()
