"""Named effectors in flight: single surfaces of a gang, a V-tail, and positions that JSBSim moves by itself."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from flying import flown
from plain import at_trim, plain, replayed
from tails import v_tail, with_servo
from uavftc.core.layout import shares
from uavftc.core.signals import COLUMNS, as_records, column, empty_rows
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.scenario.load import load_scenario

FREE = ("saturation=null", "duration_s=4")
LEFT_DEAD = ("faults=[{surface: left_aileron, start_s: 0.5, effectiveness: 0}]", "duration_s=6")


def aileron_moments(left: float, right: float) -> np.ndarray:
    """Return roll and yaw moment of the two ailerons at trim, lb ft, less those of neutral ones."""
    fdm = at_trim(0.29, 0.0, 0.0)
    found = []
    for ends in ((0.0, 0.0), (left, right)):
        fdm["fcs/left-aileron-cmd-norm"], fdm["fcs/right-aileron-cmd-norm"] = ends
        for _ in range(3):
            fdm.run()
        found.append([fdm["moments/l-aero-lbsft"], fdm["moments/n-aero-lbsft"]])
    return np.subtract(found[1], found[0])


def test_each_aileron_of_hale_makes_half_of_the_roll_and_of_the_yaw():
    both, left, right = (aileron_moments(*ends) for ends in ((0.1, -0.1), (0.1, 0.0), (0.0, -0.1)))
    assert np.all(np.abs(both) > 1.0)
    np.testing.assert_allclose(left, both / 2.0, rtol=1e-12)
    np.testing.assert_allclose(right, both / 2.0, rtol=1e-12)
    flight, *_ = flown("scenario1", "jsbsim", None, LEFT_DEAD)
    B = np.array([e.B for e in flight.model.effectors])[:, 3:]
    np.testing.assert_allclose(B[0], flight.model.B_rates[:, 0] / 2.0, rtol=1e-9)
    np.testing.assert_allclose(B[1], -B[0], rtol=1e-9)


def test_the_stick_of_hale_moves_both_ailerons():
    # plain JSBSim, a pilot or another program drives it by one command
    fdm = plain()
    fdm.run_ic()
    fdm["fcs/aileron-cmd-norm"] = 0.1
    fdm["fcs/right-aileron-cmd-norm"] = 0.03
    fdm.run()
    assert fdm["fcs/left-aileron-pos-rad"] == pytest.approx(0.1, abs=1e-15)
    assert fdm["fcs/right-aileron-pos-rad"] == pytest.approx(-0.07, abs=1e-15)


def test_a_dead_left_aileron_flies_as_plain_jsbsim_with_the_same_positions():
    # Driven by the positions of the history alone, without this package: the flight is the same, roll, yaw and all.
    flight, records, outcome = flown("scenario1", "jsbsim", None, LEFT_DEAD)
    assert outcome.completed
    history = published(records, flight.columns)
    states, _ = replayed(history, flight.model.trim)
    np.testing.assert_allclose(np.unwrap(states[:, :3], axis=0), records["x1"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(states[:, 3:], records["x2"], rtol=0, atol=1e-9)
    dead = records["t"] >= 0.5
    assert np.ptp(history["left_aileron_cmd_rad"][dead]) > 1e-3
    assert np.ptp(history["left_aileron_rad"][dead]) == 0.0


def test_what_an_axis_gets_of_a_gang_with_a_dead_member_is_half():
    # and so the effectiveness of the axis, in the history and the figures, is 0.5
    _, records, _ = flown("scenario1", "jsbsim", None, LEFT_DEAD)
    dead = records["t"] >= 0.5
    np.testing.assert_array_equal(records["effectiveness"][:, 0], np.where(dead, 0.5, 1.0))
    limited = np.clip(records["v2"][dead, 0], -0.05, 0.1)
    np.testing.assert_allclose(records["u2"][dead, 0], 0.5 * limited, rtol=1e-14)


def test_a_bias_of_one_member_shows_as_its_share_in_the_axis():
    faults = "faults=[{surface: right_aileron, bias_deg: 2}]"
    _, records, _ = flown("scenario1", "analytic", None, (faults, "duration_s=1"))
    np.testing.assert_allclose(records["bias"][:, 0], np.radians(-1.0), rtol=1e-14)
    np.testing.assert_allclose(records["u2"][:, 0], records["v2"][:, 0] + np.radians(-1.0), rtol=1e-12)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_a_fault_of_a_gang_is_one_of_each_member(plant):
    # to the bit: the paper's scenarios fly a gang of two as they flew one surface
    each = (
        "faults=[{surface: left_aileron, effectiveness: 0.5, bias_deg: 1}, "
        "{surface: right_aileron, effectiveness: 0.5, bias_deg: -1}]"
    )
    both = "faults=[{surface: aileron, effectiveness: 0.5, bias_deg: 1}]"
    first, second = (flown("scenario1", plant, None, (faults, "duration_s=2"))[1] for faults in (each, both))
    for name in ("x1", "x2", "u2", "effectiveness", "bias"):
        np.testing.assert_array_equal(first[name], second[name])
    np.testing.assert_allclose(second["u2"][:, 0], 0.5 * np.clip(second["v2"][:, 0], -0.05, 0.1) + np.radians(1.0))


@pytest.fixture(scope="module")
def vee(tmp_path_factory):
    """A flight with a V-tail in place of hale's elevator and rudder."""
    folder = v_tail(tmp_path_factory.mktemp("aircraft") / "vee")
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=list(FREE)))
    return flight, *fly_to_memory(flight)


def test_a_v_tail_flies_as_the_elevator_and_rudder_that_it_stands_for(vee):
    # half the sum of its surfaces is the elevator, half their difference the rudder: another allocation, one vehicle
    flight, records, outcome = vee
    assert outcome.completed
    assert flight.layout.names == ("left_aileron", "right_aileron", "left_tail", "right_tail")
    _, hale, _ = flown("scenario1", "jsbsim", None, FREE)
    for name in ("x1", "x2", "v2", "u2"):
        np.testing.assert_allclose(records[name], hale[name], rtol=0, atol=1e-10, err_msg=name)
    left, right = (records["effectors"]["deflection"][:, j] for j in (2, 3))
    np.testing.assert_allclose(left, hale["u2"][:, 1] + hale["u2"][:, 2], rtol=0, atol=1e-10)
    np.testing.assert_allclose(right, hale["u2"][:, 1] - hale["u2"][:, 2], rtol=0, atol=1e-10)


def test_a_dead_surface_of_a_v_tail_couples_pitch_and_yaw(vee):
    # the left one alone pitches and yaws: half of each axis is lost, and what is left of one reaches the other
    folder = vee[0].aircraft.folder
    dead = "faults=[{surface: left_tail, effectiveness: 0}]"
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=[*FREE, dead]))
    records, _ = fly_to_memory(flight)
    v2 = records["v2"]
    np.testing.assert_array_equal(records["effectiveness"], np.broadcast_to([1.0, 0.5, 0.5], v2.shape))
    np.testing.assert_allclose(records["u2"][:, 1], 0.5 * (v2[:, 1] - v2[:, 2]), rtol=0, atol=1e-12)
    np.testing.assert_allclose(records["u2"][:, 2], 0.5 * (v2[:, 2] - v2[:, 1]), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "mixing",
    [
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[1, 0, 0], [-1, 0, 0], [0, 1, 1], [0, 1, -1]],
        [[1, 1, 0], [-1, 1, 0], [0, 0.5, 0], [0, 0, 0]],
        [[0.3, 1, 0.2], [-1, 1, 0], [0.1, 0.5, 2]],
    ],
)
def test_what_an_axis_gets_undoes_the_mixing(mixing):
    # M^+ M is the identity on the axes that have an effector
    M = np.array(mixing, dtype=float)
    served = np.diag(M.any(axis=0).astype(float))
    np.testing.assert_allclose(shares(M).T @ M, served, atol=1e-14)
    np.testing.assert_allclose(shares(M).T, np.linalg.pinv(M), atol=1e-14)


SERVO = ("saturation=null", "duration_s=1.5")


@pytest.mark.parametrize("substeps", [1, 3])
def test_the_history_has_jsbsims_own_position_of_every_surface(tmp_path, substeps):
    # the rudder lags by its servo and reports degrees; row k has where its command has brought it at t_k + h
    folder = with_servo(tmp_path / "servo")
    over = [*SERVO, f"simulation.substeps={substeps}"]
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=over))
    rows = empty_rows(301, flight.shape)
    records = as_records(rows, flight.shape)
    flight.inputs.fill(records, 0)
    names = ["fcs/left-aileron-pos-rad", "fcs/right-aileron-pos-rad", "fcs/elevator-pos-rad", "fcs/rudder-pos-rad"]
    seen, ends = [], [0, 1, 2, 50, 51, 301]
    for k in range(301):  # JSBSim is asked at each row; the program flies them in pieces of any length
        flight.plant.run(flight.program, rows, k, k + 1)
        seen.append([flight.plant.fdm[name] for name in names])
    history = published(records, flight.columns)
    shown = [history[f"{n}_rad"] for n in ("left_aileron", "right_aileron", "elevator_position", "rudder_position")]
    np.testing.assert_allclose(np.transpose(shown), seen, rtol=0, atol=1e-12)
    np.testing.assert_allclose(history["rudder_rad"], np.array(seen)[:, 3], rtol=0, atol=1e-12)
    assert np.max(np.abs(history["rudder_rad"] - history["rudder_cmd_rad"])) > 1e-3  # it lags
    again = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=over))
    pieces = empty_rows(301, flight.shape)
    again.inputs.fill(as_records(pieces, flight.shape), 0)
    for first, last in pairwise(ends):
        again.plant.run(again.program, pieces, first, last)
    np.testing.assert_array_equal(pieces, rows)


def test_the_row_of_a_loss_has_the_position_at_its_time(tmp_path):
    # its command is never flown, so the surface stays where the row before has left it
    folder = with_servo(tmp_path / "servo")
    over = [*SERVO, "envelope.bank_deg=1"]
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=over))
    records, outcome = fly_to_memory(flight)
    assert not outcome.completed
    position, u2 = records["effectors"]["position"][:, 3], records["u2"][:, 2]
    assert position[-1] == position[-2] == flight.plant.fdm["fcs/rudder-pos-rad"]
    np.testing.assert_allclose(u2, position, rtol=0, atol=1e-12)


def test_columns_are_the_common_ones_and_those_of_the_effectors(vee):
    common = [c.name for c in COLUMNS]
    flight, records, _ = vee
    names = [c.name for c in flight.columns]
    assert names[: len(common)] == common
    own = [f"{n}{kind}_rad" for n in flight.layout.names for kind in ("_cmd", "")]
    assert names[len(common) : len(common) + len(own)] == own
    trim = flight.model.effectors[2].trim_rad
    (command,) = (c for c in flight.columns if c.name == "left_tail_cmd_rad")
    np.testing.assert_allclose(column(records, command), trim + records["v2"][:, 1] + records["v2"][:, 2], atol=1e-15)
