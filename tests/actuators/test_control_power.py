"""Control power: a share of the moment of the total deflection, trim included, of what the stops let through."""

from __future__ import annotations

import numpy as np
import pytest

from flying import flown, given_of
from tails import with_servo
from uavftc.actuators import control_power
from uavftc.core.layout import Layout
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.plants.interface import Timing
from uavftc.scenario.damage import Damage
from uavftc.scenario.load import load_scenario

STOPS = np.array([[-0.3, 0.2], [-0.5, 0.5], [-1.0, 1.0]])
TRIM = np.array([0.05, -0.1, 0.0])


def passed(deflection: np.ndarray, *entries: Damage) -> np.ndarray:
    """Return what is left of deflections, shape (n, 3), at t = 0, 0.1, ..."""
    layout = Layout(trim_rad=TRIM)
    given = given_of(Timing(0.1, 1), len(deflection), STOPS, layout)._replace(damage=entries)
    rows = empty_rows(len(deflection), 3)
    records = as_records(rows)
    records["t"] = np.arange(len(deflection)) * 0.1
    records["effectors"]["deflection"] = deflection
    assert Program([], control_power.blocks(None, given)).run(rows, 0, len(rows)) == len(rows)
    return records["effectors"]["deflection"]


def test_the_total_deflection_is_scaled_inside_the_window_only():
    u = np.tile([0.1, 0.2, 0.3], (6, 1))
    found = passed(u, Damage(start_s=0.2, end_s=0.4, control_power={"aileron": 0.5, "elevator": 0.0}))
    expected = u.copy()
    expected[2:4, 0] = 0.5 * (0.05 + 0.1) - 0.05
    expected[2:4, 1] = 0.1  # total deflection zero
    np.testing.assert_allclose(found[2:4], expected[2:4], rtol=1e-15)
    np.testing.assert_array_equal(found[[0, 1, 4, 5]], u[[0, 1, 4, 5]])  # the identity, to the bit
    np.testing.assert_array_equal(found[:, 2], u[:, 2])


def test_a_surface_at_its_stop_has_its_share_of_the_stop():
    found = passed(np.array([[3.0, -3.0, 0.0]]), Damage(control_power={"aileron": 0.5, "elevator": 0.25}))
    np.testing.assert_allclose(found[0], [0.5 * (0.05 + 0.2) - 0.05, 0.25 * (-0.1 - 0.5) + 0.1, 0.0], rtol=1e-15)


def test_the_shares_of_two_damages_multiply():
    two = [Damage(control_power={"rudder": 0.5}), Damage(start_s=0.1, control_power={"rudder": 0.4})]
    np.testing.assert_allclose(passed(np.full((2, 3), 0.3), *two)[:, 2], [0.15, 0.06], rtol=1e-15)


def test_damage_without_control_power_costs_nothing():
    given = given_of(Timing(0.1, 1), 1)._replace(damage=(Damage(mass_kg=-1.0),))
    assert control_power.blocks(None, given) == []


def test_a_gang_is_each_of_its_members():
    over = "duration_s=2"
    gang, members = (
        flown("scenario1", "jsbsim", None, (over, f"damage=[{{start_s: 0.5, control_power: {{{power}}}}}]"))[1]
        for power in ("aileron: 0.5", "left_aileron: 0.5, right_aileron: 0.5")
    )
    for name in ("x1", "x2", "u2"):
        np.testing.assert_array_equal(gang[name], members[name])


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_where_the_trim_is_zero_it_is_a_loss_of_effectiveness(plant):
    # eq. (6), of a surface that is at zero at trim, without a limit that binds: the same flight to rounding
    over = ("duration_s=3", "saturation=null")
    lost = flown("scenario1", plant, None, (*over, "damage=[{start_s: 1, control_power: {left_aileron: 0.25}}]"))[1]
    fault = "faults=[{surface: left_aileron, start_s: 1, effectiveness: 0.25}]"
    expected = flown("scenario1", plant, None, (*over, fault))[1]
    for name in ("x1", "x2", "u2"):
        np.testing.assert_allclose(lost[name], expected[name], rtol=0, atol=1e-12)


def test_a_servo_of_the_aircraft_goes_to_the_share(tmp_path):
    # the rudder lags at 20 rad/s: its position follows the share of the command, not the command
    folder = with_servo(tmp_path / "servo")
    over = ["saturation=null", "duration_s=3", "damage=[{start_s: 1, control_power: {rudder: 0.5}}]"]
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=over))
    records, _ = fly_to_memory(flight)
    effectors = records["effectors"]
    trim = flight.layout.trim_rad[3]
    settled = records["t"] > 1.5
    asked = trim + effectors["command"][settled, 3]
    moved = np.abs(effectors["position"][settled, 3] - 0.5 * asked)
    assert np.max(np.abs(asked)) > 5e-3
    assert np.max(moved) < 0.2 * np.max(np.abs(asked))
