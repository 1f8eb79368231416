"""Dead band, delay and backlash of servos, their faults, and whose keys an effector follows."""

from __future__ import annotations

import numpy as np
import pytest
from moved import H, given, moved, scenario

from uavftc.actuators import CHAIN, servo_delay
from uavftc.actuators.servo import farthest, servos
from uavftc.config.effect import config_of

N = 80
T = H * np.arange(N)
WAVE = 0.05 * np.sin(2.0 * np.pi * 4.0 * T)
LEFT, RIGHT, ELEVATOR, RUDDER = range(4)


def held(command, substeps):
    return np.repeat(command, substeps)


def test_a_dead_band_takes_half_its_width_to_either_side():
    # u - sign(u) w/2 beyond it, nothing inside
    half = np.radians(1.0)
    got = moved(WAVE, {"deadband_deg": 2}).every[:, RUDDER]
    np.testing.assert_allclose(got, np.sign(WAVE) * np.maximum(np.abs(WAVE) - half, 0.0), rtol=0, atol=1e-16)
    assert np.count_nonzero(got == 0.0) > 10


def test_backlash_follows_the_play_operator():
    # up to a turn the surface is half the play behind; it rests while the servo crosses all of it
    half = np.radians(0.5)
    got = moved(WAVE, {"backlash_deg": 1}).every[:, ELEVATOR]
    y, expected = 0.0, []
    for u in WAVE:
        y = min(max(y, u - half), u + half)
        expected.append(y)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-16)
    assert got.max() == pytest.approx(WAVE.max() - half, abs=1e-15)
    top = int(np.argmax(WAVE))
    resting = np.flatnonzero(np.diff(got[top:]) != 0.0)[0] + top
    assert WAVE[resting] >= WAVE.max() - 2.0 * half > WAVE[resting + 1]


@pytest.mark.parametrize(
    ("delay_s", "substeps", "steps"), [(0.015, 1, 3), (0.015, 4, 12), (0.0025, 2, 1), (0.4, 1, 80)]
)
def test_a_delay_of_whole_plant_steps_shifts_the_command(delay_s, substeps, steps):
    # behind that of the loop, with a line of its own; before the first command comes trim
    got = moved(WAVE, {"delay_s": delay_s}, substeps=substeps).every[:, LEFT]
    expected = np.concatenate([np.zeros(steps), held(WAVE, substeps)])[: N * substeps]
    np.testing.assert_array_equal(got, expected)


def test_a_delay_of_part_of_a_plant_step_gives_the_mean():
    # 3.25 steps: for a quarter of each the command before
    got = moved(WAVE, {"delay_s": 3.25 * H}).every[:, RUDDER]
    late = np.concatenate([np.zeros(4), WAVE])
    np.testing.assert_allclose(got, 0.75 * late[1 : N + 1] + 0.25 * late[:N], rtol=0, atol=1e-15)


def test_what_a_servo_does_comes_in_the_order_of_the_contract():
    # dead band, delay, lag, backlash; each made of the one before it by its own law
    keys = {"deadband_deg": 1, "delay_s": 0.01, "bandwidth_radps": 57, "backlash_deg": 0.4}
    got = moved(WAVE, keys)
    assert got.blocks == ("deadband", "servo_delay", "lag", "backlash")
    y = WAVE
    for key, value in keys.items():
        y = moved(y, {key: value}).every[:, RUDDER]
    np.testing.assert_allclose(got.every[:, RUDDER], y, rtol=0, atol=1e-16)


def test_a_servo_without_keys_costs_nothing():
    # no block, no column, and every command as it is
    got = moved(WAVE)
    assert got.blocks == ()
    np.testing.assert_array_equal(got.every, np.repeat(WAVE[:, None], 4, axis=1))


# --- faults ----------------------------------------------------------------------------------------------------------

FIRST, LAST = 20, 50  # rows of the window
WINDOW = {"start_s": FIRST * H - 0.3 * H, "end_s": LAST * H - 0.6 * H}  # they begin and end with the next row


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("bandwidth", [None, 57.0])
def test_a_rate_limit_is_that_of_the_window_and_the_servo_goes_on_from_where_it_is(bandwidth, substeps):
    # inside no faster than the rate; then an ideal servo is at once where it is commanded, one with a lag catches up
    rate = np.radians(5.0)
    fault = {"kind": "rate-limit", "surface": "rudder", "rate_degps": 5, **WINDOW}
    keys = {"bandwidth_radps": bandwidth}
    got, free = (moved(WAVE, keys, faults, substeps=substeps) for faults in ([fault], []))
    np.testing.assert_array_equal(got.every[: FIRST * substeps], free.every[: FIRST * substeps])
    np.testing.assert_array_equal(got.every[:, :RUDDER], free.every[:, :RUDDER])
    inside = got.servo[FIRST:LAST, RUDDER]
    assert np.abs(np.diff(inside)).max() <= rate * H * (1 + 1e-12)
    assert np.abs(np.diff(inside)).max() >= rate * H * (1 - 1e-12)
    if bandwidth is None:
        np.testing.assert_array_equal(got.every[LAST * substeps :], free.every[LAST * substeps :])
        return
    apart = got.servo[LAST:, RUDDER] - free.servo[LAST:, RUDDER]  # a difference of first order decays by itself
    assert abs(apart[0]) > 0.01
    np.testing.assert_allclose(apart, apart[0] * np.exp(-bandwidth * H * np.arange(N - LAST)), rtol=0, atol=1e-14)


def test_a_servo_slower_than_its_fault_stays_as_it_is():
    # the lower limit, the wider play and the wider band count
    for key, fault in (
        ({"rate_limit_degps": 5}, {"kind": "rate-limit", "rate_degps": 20}),
        ({"backlash_deg": 2}, {"kind": "backlash", "width_deg": 1}),
        ({"deadband_deg": 2}, {"kind": "deadband", "width_deg": 1}),
    ):
        got, own = (moved(WAVE, key, faults) for faults in ([{**fault, "surface": "rudder"}], []))
        np.testing.assert_array_equal(got.every, own.every)


@pytest.mark.parametrize("own", [0, 2])
@pytest.mark.parametrize("substeps", [1, 2])
def test_an_added_delay_gives_each_command_once_and_in_turn(own, substeps):
    # the servo waits for the first command that is old enough, and afterwards goes on with its own delay
    added = 5
    fault = {"kind": "delay", "surface": "rudder", "delay_s": added * H, **WINDOW}
    got = moved(WAVE, {"delay_s": own * H}, [fault], substeps=substeps).every[::substeps, RUDDER]
    source = []
    for k in range(N):
        wanted = k - own - (added if FIRST <= k < LAST else 0)
        source.append(max(wanted, source[-1] if source else wanted))
    np.testing.assert_array_equal(got, [WAVE[i] if i >= 0 else 0.0 for i in source])
    assert source[FIRST : FIRST + added + 1] == [FIRST - own - 1] * added + [FIRST - own]


def test_a_play_that_widens_goes_on_from_where_the_surface_lies():
    # the operator with the width of each row; with no play of its own the surface is back with the servo at once
    fault = {"kind": "backlash", "surface": "aileron", "width_deg": 2, **WINDOW}
    got = moved(WAVE, None, [fault]).every[:, LEFT]
    y, expected = 0.0, []
    for k, u in enumerate(WAVE):
        half = np.radians(1.0) if FIRST <= k < LAST else 0.0
        y = min(max(y, u - half), u + half)
        expected.append(y)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-16)
    np.testing.assert_array_equal(got[LAST:], WAVE[LAST:])


def test_a_dead_band_is_there_inside_its_window_only():
    fault = {"kind": "deadband", "surface": "left_aileron", "width_deg": 10, **WINDOW}
    got = moved(WAVE, None, [fault]).every
    inside = (np.arange(N) >= FIRST) & (np.arange(N) < LAST)
    assert not got[inside, LEFT].any()
    np.testing.assert_array_equal(got[~inside, LEFT], WAVE[~inside])
    np.testing.assert_array_equal(got[:, RIGHT], WAVE)


def test_faults_that_follow_each_other_on_one_servo_each_have_their_window():
    # two of one kind that touch, and a gang among them: the width of each row
    widths = np.radians(np.select([T < 0.1, T < 0.2, T < 0.25], [1.0, 3.0, 0.0], 2.0))
    faults = [
        {"kind": "deadband", "surface": "left_aileron", "start_s": 0.1, "end_s": 0.2, "width_deg": 3},
        {"kind": "deadband", "surface": "aileron", "end_s": 0.1, "width_deg": 1},
        {"kind": "deadband", "surface": "left_aileron", "start_s": 0.25, "width_deg": 2},
    ]
    got = moved(WAVE, None, faults).every
    np.testing.assert_allclose(
        got[:, LEFT], np.sign(WAVE) * np.maximum(np.abs(WAVE) - 0.5 * widths, 0.0), rtol=0, atol=1e-16
    )


# --- what a fault changed --------------------------------------------------------------------------------------------

REST = np.zeros(N)
EARLY = np.where(T < 0.05, WAVE, WAVE[9])  # a command that rests before the window begins


def apart(commands, keys, *faults, **more):
    """Return how far each fault moved the servo, rad."""
    got = moved(commands, keys, faults, **more)
    laws = {effect.FAULT: effect for effect in CHAIN if hasattr(effect, "FAULT")}
    found = []
    for i, entry in enumerate(got.given.faults):
        law = laws[type(entry)]
        found.append(farthest(got.program[law.stage.name], law.FIRST, type(entry), i, got.given))
    return found


@pytest.mark.parametrize("substeps", [1, 2])
def test_a_fault_of_a_servo_that_had_nothing_to_do_moved_it_by_nothing(substeps):
    # commands at rest, a rate that is never reached (WAVE: at most 72 deg/s), a servo worse by itself
    on = {"surface": "aileron", **WINDOW}
    for commands, keys, fault in (
        (REST, None, {"kind": "deadband", "width_deg": 5}),
        (REST, None, {"kind": "backlash", "width_deg": 5}),
        (EARLY, None, {"kind": "delay", "delay_s": 0.1}),
        (EARLY, None, {"kind": "rate-limit", "rate_degps": 0.1}),
        (WAVE, {"bandwidth_radps": 57}, {"kind": "rate-limit", "rate_degps": 80}),
        (WAVE, {"bandwidth_radps": 57, "damping": 0.7}, {"kind": "rate-limit", "rate_degps": 100}),
        (WAVE, {"rate_limit_degps": 5}, {"kind": "rate-limit", "rate_degps": 20}),
        (WAVE, {"backlash_deg": 2}, {"kind": "backlash", "width_deg": 1}),
        (WAVE, {"deadband_deg": 2}, {"kind": "deadband", "width_deg": 1}),
    ):
        (most,) = apart(commands, keys, {**fault, **on}, substeps=substeps)
        assert most <= 1e-15, fault


def test_a_fault_of_a_servo_knows_how_far_it_moved_it():
    # by what each law takes away in the window: all within the band, the first push of the play, the age of a command
    inside = slice(FIRST, LAST)
    on = {"surface": "rudder", **WINDOW}
    assert apart(WAVE, None, {"kind": "deadband", "width_deg": 10, **on}) == [np.abs(WAVE[inside]).max()]
    assert apart(WAVE, {"deadband_deg": 1}, {"kind": "deadband", "width_deg": 2, **on}) == pytest.approx(
        [np.radians(0.5)], abs=1e-15
    )
    assert apart(WAVE, None, {"kind": "backlash", "width_deg": 1, **on}) == pytest.approx([np.radians(0.5)], abs=1e-15)
    waits = np.maximum(np.arange(FIRST, LAST) - 4, FIRST - 1)
    assert apart(WAVE, None, {"kind": "delay", "delay_s": 4 * H, **on}) == [np.abs(WAVE[inside] - WAVE[waits]).max()]
    # an ideal servo of a rate: behind by the step of the command less what it may move, at the first step
    step = abs(WAVE[FIRST] - WAVE[FIRST - 1]) - np.radians(1.0) * H
    assert apart(WAVE, None, {"kind": "rate-limit", "rate_degps": 1, **on}, at_end=True) == pytest.approx(
        [step], abs=1e-15
    )


@pytest.mark.parametrize(
    "kind",
    [
        {"kind": "rate-limit", "rate_degps": 1},
        {"kind": "delay", "delay_s": 0.02},
        {"kind": "backlash", "width_deg": 1},
        {"kind": "deadband", "width_deg": 1},
    ],
)
def test_of_several_faults_on_a_servo_each_knows_its_share(kind):
    # commands of the left aileron begin at row 50: the fault before is idle, the next is not
    late = np.zeros((N, 4))
    late[50:, LEFT] = WAVE[: N - 50]
    windows = [("left_aileron", 0.3, None), ("left_aileron", 0.1, 0.2), ("rudder", 0.0, None), ("aileron", 0.2, 0.3)]
    faults = [{**kind, "surface": name, "start_s": a, "end_s": b} for name, a, b in windows]
    first, second, third, fourth = apart(late, None, *faults)
    assert second == third == 0.0
    assert first > 1e-4
    assert fourth > 1e-4


# --- whose keys ------------------------------------------------------------------------------------------------------


def bandwidths(actuators, **more):
    of = scenario(N, actuators)
    return [None if s.keys is None else s.keys.bandwidth_radps for s in servos(of.actuators, given(of, **more))]


def test_an_effector_goes_before_its_gang_and_a_gang_before_all():
    # left_aileron, right_aileron, elevator, rudder
    assert bandwidths({"bandwidth_radps": 57}) == [57.0] * 4
    named = {"bandwidth_radps": 57, "aileron": {"bandwidth_radps": 20}, "left_aileron": {"bandwidth_radps": 10}}
    assert bandwidths({**named, "rudder": None}) == [10.0, 20.0, 57.0, None]
    assert bandwidths({"left_aileron": {"bandwidth_radps": 10}}) == [10.0, None, None, None]


def test_what_an_own_map_leaves_out_follows_the_common_one():
    # and what it says with null or 0 does not
    keys = {"bandwidth_radps": 57, "damping": 0.7, "delay_s": 0.02, "rudder": {"delay_s": 0, "damping": None}}
    own = scenario(N, keys).actuators.named()["rudder"]
    assert (own.bandwidth_radps, own.damping, own.delay_s) == (57.0, None, 0.0)


def test_common_keys_leave_out_an_effector_with_a_servo_of_the_aircrafts():
    # and its name is a wish for both
    own = ({}, {}, {"lag_radps": 40.0}, {"lag_radps": 40.0})
    assert bandwidths({"bandwidth_radps": 57}, servos=own) == [57.0, 57.0, None, None]
    assert bandwidths({"bandwidth_radps": 57, "rudder": {}}, servos=own) == [57.0, 57.0, None, 57.0]


def test_the_line_is_as_long_as_the_longest_delay_and_no_longer_than_the_flight():
    of = scenario(N, {"delay_s": 0.01}, [{"kind": "delay", "surface": "rudder", "delay_s": 3600, "start_s": 0.3}])
    (block,) = servo_delay.blocks(config_of(servo_delay, of), given(of))
    assert block.state.shape == (4, 1 + 5 + 1 + N + 2)  # age, schedule, place in the line, line
    got = moved(WAVE, {"delay_s": 0.01}, [{"kind": "delay", "surface": "rudder", "delay_s": 3600, "start_s": 0.3}])
    np.testing.assert_array_equal(got.every[60:, RUDDER], got.every[59, RUDDER])  # it waits till the end
