"""What the chain leaves of an effector at rest is where constant commands take it, by the chain itself."""

from __future__ import annotations

import numpy as np
import pytest
from moved import H, given, moved, scenario

from flying import HALE
from uavftc.actuators import CHAIN
from uavftc.actuators.at_rest import Rest, everywhere, reaches
from uavftc.scenario.damage import Damage
from uavftc.scenario.schema import Scenario

STOPS = np.radians([[-25.0, 20.0]] * 4)
ROWS = 81
COMMANDS = np.radians([-60.0, -25.0, -7.0, 0.0, 3.0, 20.0, 60.0])
FAULTS = {
    "stuck": {"kind": "stuck", "at_deg": 4},
    "hardover": {"kind": "hardover"},
    "hardover down": {"kind": "hardover", "rate_degps": -400},
    "hardover on its way": {"kind": "hardover", "rate_degps": 30, "to_deg": 15},
    "drift": {"kind": "drift", "rate_degps": 6},
    "liquid": {"kind": "oscillatory", "amplitude_deg": 2, "frequency_hz": 3},
    "solid": {"kind": "oscillatory", "amplitude_deg": 2, "frequency_hz": 3, "mode": "solid"},
    "total loss": {"kind": "total-loss"},
    "intermittent": {"kind": "intermittent", "on_s": 0.05, "off_s": 0.05, "effectiveness": 0.25, "bias_deg": 1},
}
SURFACES = ("left_aileron", "right_aileron", "aileron", "elevator")
SERVO = {"min_deg": -9, "max_deg": 8, "elevator": {"min_deg": -12}}


def at_the_end(command: float, actuators=None, faults=(), **more) -> tuple[np.ndarray, np.ndarray]:
    """Return the deflections at the last row of a constant command, and those before any fault began."""
    every = moved(np.full(ROWS, command), actuators, faults, stops_rad=STOPS, **more).every
    return every[-1], every[0]


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_constant_commands_take_it_to_what_is_reached_and_no_further(surface, fault):
    # on the chain itself, a fault from the 20th sample on, within stops and the limits of a servo
    faults = [{**fault, "surface": surface, "start_s": 20 * H}]
    of = scenario(ROWS, SERVO, faults)
    known = given(of, stops_rad=STOPS)
    lowest, highest = np.full(4, np.inf), np.full(4, -np.inf)
    for command in COMMANDS:
        there, before = at_the_end(command, SERVO, faults)
        found = reaches(CHAIN, of, known, Rest(of.times()[-1], lambda _, before=before: before))
        low, high = np.array([r.low for r in found]), np.array([r.high for r in found])
        inside = np.any((low - 1e-12 <= there) & (there <= high + 1e-12), axis=0)
        if "oscillatory" in fault["kind"]:  # anywhere between its two ends
            inside = (low.min(axis=0) - 1e-12 <= there) & (there <= high.max(axis=0) + 1e-12)
        assert inside.all(), (command, there, low, high)
        lowest, highest = np.minimum(lowest, there), np.maximum(highest, there)
    if fault["kind"] == "drift" or (fault["kind"] in ("stuck", "total-loss") or fault.get("rate_degps") == -400):
        np.testing.assert_allclose(lowest, low[0], rtol=0.0, atol=1e-12)  # and all of it is reached
        np.testing.assert_allclose(highest, high[0], rtol=0.0, atol=1e-12)


def test_what_is_stuck_where_it_was_stays_where_it_is_said_to_have_been():
    of = scenario(ROWS, None, [{"kind": "stuck", "surface": "aileron", "start_s": 20 * H}])
    was = np.radians([1.0, -2.0, 3.0, 4.0])
    asked = []

    def before(start_s: float) -> np.ndarray:
        asked.append(start_s)
        return was

    (reach,) = reaches(CHAIN, of, given(of, stops_rad=STOPS), Rest(30 * H, before))
    assert asked == [20 * H]
    np.testing.assert_array_equal(reach.low, [was[0], was[1], *STOPS[2:, 0]])
    np.testing.assert_array_equal(reach.high, [was[0], was[1], *STOPS[2:, 1]])
    np.testing.assert_array_equal(reach.held, [True, True, False, False])
    (free,) = reaches(CHAIN, of, given(of, stops_rad=STOPS), Rest(19 * H, before))
    np.testing.assert_array_equal(np.column_stack([free.low, free.high]), STOPS)


def test_effectiveness_and_bias_act_between_saturation_and_stops():
    # u = omega sat(v) + b: elevator in [0.5 (-2) + 1, 0.5 (4) + 1] deg; the aileron's bias by the weights of its gang
    degree = np.pi / 180.0
    of = Scenario.model_validate(
        {
            "name": "s", "duration_s": 1, "plant": "analytic",
            "saturation": {"min_rad": -2 * degree, "max_rad": 4 * degree},
            "faults": [
                {"surface": "elevator", "effectiveness": "0.5 + 0*t", "bias_deg": "2*t"},
                {"surface": "aileron", "effectiveness": 0, "bias_deg": 3},
                {"surface": "rudder", "effectiveness": 30},
            ],
        }
    )  # fmt: skip
    (reach,) = reaches(CHAIN, of, given(of, stops_rad=STOPS), Rest(0.5, lambda _: np.zeros(4)))
    np.testing.assert_allclose(reach.low / degree, [3.0, -3.0, 0.0, -25.0], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(reach.high / degree, [3.0, -3.0, 3.0, 20.0], rtol=0.0, atol=1e-12)


def test_a_floating_surface_goes_with_the_flow_it_is_said_to():
    of = Scenario.model_validate(
        {
            "name": "s", "duration_s": 1,
            "faults": [
                {"kind": "float", "surface": "left_aileron", "ratio": 0.5},
                {"kind": "float", "surface": "rudder", "ratio": -0.25},
            ],
        }
    )  # fmt: skip
    trim = np.radians([2.0, 0.0, 0.0, 1.0])
    layout = HALE._replace(trim_rad=trim)
    known = given(of, stops_rad=STOPS)._replace(trim_rad=layout.trim_rad, sense=np.array([-1.0, 1.0, 1.0, 1.0]))
    (reach,) = reaches(CHAIN, of, known, Rest(0.5, lambda _: np.zeros(4)))
    at = reach.at(reach.low, alpha=0.1, beta=0.2)
    assert at[0] + trim[0] == pytest.approx(-0.5 * 0.1)  # total deflection, counted against its position
    assert at[3] + trim[3] == pytest.approx(-0.25 * 0.2)


def test_control_power_that_is_left_scales_the_total_deflection_between_the_stops():
    # g (trim + u) - trim with u from stop to stop, twice where two damages act
    damage = [Damage(control_power={"elevator": 0.5}), Damage(start_s=0.2, control_power={"elevator": 0.4})]
    of = Scenario.model_validate({"name": "s", "duration_s": 1})
    trim = np.radians([0.0, 0.0, 2.0, 0.0])
    known = given(of, stops_rad=STOPS)._replace(trim_rad=trim, damage=tuple(damage))
    for t, share in ((0.1, 0.5), (0.5, 0.2)):
        (reach,) = reaches(CHAIN, of, known, Rest(t, lambda _: np.zeros(4)))
        expected = share * (trim[2] + STOPS[2]) - trim[2]
        np.testing.assert_allclose([reach.low[2], reach.high[2]], expected, rtol=0.0, atol=1e-12)


def test_nothing_limits_what_has_neither_limit_nor_stop():
    reach = everywhere(2).scaled(np.array([0.0, 2.0]), np.array([1.0, 1.0]))
    np.testing.assert_array_equal(reach.low, [1.0, -np.inf])  # 0 of any command is 0
    np.testing.assert_array_equal(reach.high, [1.0, np.inf])
