"""The motion of a servo against closed forms, an independent integrator, and itself in parts."""

from __future__ import annotations

from math import ceil, inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from moved import H, moved
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from uavftc.actuators.response import LONGEST, first_order, second_order

N = 60
STEP = np.full(N, 0.05)
T = H * np.arange(N)
RANDOM = np.random.default_rng(5).normal(size=N) * 0.05


def part_of(w, zeta, dt):
    return dt / ceil(dt * w * max(1.0, 2.0 * zeta) / LONGEST)


@pytest.mark.parametrize("substeps", [1, 3])
def test_a_step_of_first_order_follows_the_closed_form(substeps):
    # y = c (1 - exp(-w t)) of the servo at each sample; the deflection is its mean over the plant step, or its end,
    # with a twelfth of the corner with which it starts, from y' = 0 to w c
    w, dt = 57.0, H / substeps
    t = dt * np.arange(N * substeps)
    y = 0.05 * (1.0 - np.exp(-w * t))
    mean = 0.05 - 0.05 * np.exp(-w * t) * (1.0 - np.exp(-w * dt)) / (w * dt)
    got = moved(STEP, {"bandwidth_radps": w}, substeps=substeps)
    np.testing.assert_allclose(got.servo[:, 2], y[::substeps], rtol=0, atol=1e-15)
    np.testing.assert_allclose(got.every[:, 2], mean, rtol=0, atol=1e-15)
    end = moved(STEP, {"bandwidth_radps": w}, substeps=substeps, at_end=True).every[:, 2]
    np.testing.assert_allclose(end[0], y[1] + dt * w * 0.05 / 12.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(end[1:-1], y[2:], rtol=0, atol=1e-15)


@pytest.mark.parametrize("substeps", [4, 8])
@pytest.mark.parametrize("limit", [inf, 100.0])
def test_adams_bashforth_3_has_the_integral_of_a_servo_through_its_corner(limit, substeps):
    # of a command that is held; the corner by itself would be short by dt^2/12 of the first rate
    w, c, dt, R = 57.0, 0.05, H / substeps, np.radians(limit)
    keys = {"bandwidth_radps": w} | ({} if limit == inf else {"rate_limit_degps": limit})
    f = np.concatenate([np.zeros(3), moved(STEP, keys, substeps=substeps, at_end=True).every[:-1, 2]])
    integral = dt * (23.0 * f[2:-1] - 16.0 * f[1:-2] + 5.0 * f[:-3]).sum() / 12.0
    ramp = max(0.0, c / R - 1.0 / w)  # at the limit of the rate, before y' = w (c - y)
    way = R * ramp if ramp > 0.0 else 0.0
    exact = 0.5 * way * ramp + c * (dt * (len(f) - 3) - ramp) - (c - way) / w
    assert abs(integral - exact) < 0.01 * dt**2 / 12.0 * min(w * c, R)


@pytest.mark.parametrize("more", [{"backlash_deg": 0.1}, {"damping": 0.7}, {"bandwidth_radps": None}])
def test_a_corner_is_added_where_nothing_behind_follows_it(more):
    # a play would keep what is beyond the way of the servo; second order has no corner; a rate limiter arrives inside
    keys = {"bandwidth_radps": 57.0, "rate_limit_degps": 100.0, **more}
    got = moved(RANDOM, keys, at_end=True)
    play = 0.5 * np.radians(0.1) if "backlash_deg" in more else 0.0
    after = np.abs(got.every[:-1, 2] - got.servo[1:, 2])
    if more == {"bandwidth_radps": None}:
        expected = np.clip(RANDOM[:-1] - got.servo[:-1, 2], -np.radians(100.0) * H, np.radians(100.0) * H)
        np.testing.assert_allclose(got.servo[1:, 2], got.servo[:-1, 2] + expected, rtol=0, atol=1e-15)
    assert after.max() <= play + 1e-15


@pytest.mark.parametrize("zeta", [0.2, 0.7, 1.0, 2.5])
@pytest.mark.parametrize("substeps", [1, 4])
def test_second_order_follows_the_closed_form_under_any_command(zeta, substeps):
    # position and integral by the matrix exponential, for each command that is held
    w, dt = 57.0, H / substeps
    A = np.array([[0.0, 1.0, 0.0, 0.0], [-w * w, -2.0 * zeta * w, 0.0, w * w], [1.0, 0.0, 0.0, 0.0], [0.0] * 4])
    step, z = expm(A * dt), np.zeros(4)
    positions, means = [], []
    for u in np.repeat(RANDOM, substeps):
        z[2:] = 0.0, u
        positions.append(z[0])
        z = step @ z
        means.append(z[2] / dt)
    got = moved(RANDOM, {"bandwidth_radps": w, "damping": zeta}, substeps=substeps)
    np.testing.assert_allclose(got.servo[:, 0], positions[::substeps], rtol=0, atol=1e-14)
    np.testing.assert_allclose(got.every[:, 0], means, rtol=0, atol=1e-14)


def test_a_pure_rate_limit_is_a_ramp_and_ends_at_the_command():
    # c = R t, and the mean over the step in which it arrives counts the rest at c
    R = np.radians(20.0)
    got = moved(STEP, {"rate_limit_degps": 20})
    np.testing.assert_allclose(got.servo[:, 3], np.minimum(R * T, 0.05), rtol=0, atol=1e-15)
    fine = np.minimum(R * (T[:, None] + H * (np.arange(20000) + 0.5) / 20000), 0.05).mean(axis=1)
    np.testing.assert_allclose(got.every[:, 3], fine, rtol=0, atol=1e-10)


def test_a_lag_at_the_limit_of_its_rate_runs_until_the_lag_is_slower():
    # |u - y| > R/w: a ramp; then y = c - (R/w) exp(-w (t - t_r)), t_r = c/R - 1/w
    w, R = 30.0, np.radians(40.0)
    got = moved(STEP, {"bandwidth_radps": w, "rate_limit_degps": 40}).servo[:, 1]
    t_r = 0.05 / R - 1.0 / w
    assert 5 * H < t_r < 20 * H
    expected = np.where(t_r > T, R * T, 0.05 - R / w * np.exp(-w * (T - t_r)))
    np.testing.assert_allclose(np.abs(got), expected, rtol=0, atol=1e-15)


def test_at_a_limit_of_its_position_a_servo_stands_and_comes_back_at_once():
    # first order: y = min(c (1 - exp(-w t)), top); back from the top as the lag says, not from where it would have been
    w, top = 30.0, np.radians(2.0)
    command = np.where(np.arange(N) < 30, 0.05, -0.01)
    got = moved(command, {"bandwidth_radps": w, "max_deg": 2}).servo[:, 2]
    expected = np.minimum(0.05 * (1.0 - np.exp(-w * T)), top)
    back = -0.01 + (top + 0.01) * np.exp(-w * (T - T[30]))
    np.testing.assert_allclose(got, np.where(np.arange(N) < 31, expected, back), rtol=0, atol=1e-15)


def by_integration(y, v, u, w, zeta, R, low, high, T):
    """Return position, rate and mean of a servo of second order: phases between the events that scipy finds."""
    t, area = 0.0, 0.0
    v = min(max(v, -R), R)
    for _ in range(100):
        if t >= T - 1e-13:
            break
        a = w * w * (u - y) - 2.0 * zeta * w * v
        if (y >= high - 1e-12 and v >= 0 and u >= high) or (y <= low + 1e-12 and v <= 0 and u <= low):
            return y, 0.0, (area + y * (T - t)) / T
        ramp = abs(v) >= R * (1 - 1e-11) and v * a > 1e-9 * w * w
        sign = 1.0 if v > 0 else -1.0

        def motion(_t, x, ramp=ramp):
            return [x[1], 0.0 if ramp else w * w * (u - x[0]) - 2.0 * zeta * w * x[1], x[0]]

        events = [lambda _t, x: x[0] - high if high < inf else -1.0, lambda _t, x: x[0] - low if low > -inf else 1.0]
        events[0].direction, events[1].direction = 1.0, -1.0
        if ramp:
            events.append(lambda _t, x, s=sign: s * (w * w * (u - x[0]) - 2.0 * zeta * w * x[1]))
            events[-1].direction = -1.0
        elif inf > R:
            events += [lambda _t, x: x[1] - R, lambda _t, x: x[1] + R]
            events[-2].direction, events[-1].direction = 1.0, -1.0
        for event in events:
            event.terminal = True
        part = solve_ivp(motion, (t, T), [y, v, 0.0], rtol=1e-11, atol=1e-13, events=events, max_step=0.02 / w)
        y, v = part.y[0, -1], part.y[1, -1]
        area += part.y[2, -1]
        t = part.t[-1]
        if len(part.t_events[0]) or len(part.t_events[1]):
            y, v = (high if len(part.t_events[0]) else low), 0.0
    return y, v, area / T


CASES = [
    # y, v, u, w, zeta, R, low, high, T
    (0.0, 0.0, 0.1, 57.0, 0.7, np.radians(100.0), -inf, inf, 0.06),  # up to the rate, along it, and off
    (0.0, 0.0, 0.1, 57.0, 0.3, np.radians(100.0), -inf, 0.08, 0.15),  # into the stop with its rate
    (0.05, -1.5, 0.1, 40.0, 0.3, 1.5, -0.02, inf, 0.4),  # turns, and overshoots
    (0.08, 0.5, -0.2, 40.0, 0.5, 1.0, -0.1, 0.08, 0.4),  # from one stop to the other
    (0.0, 3.0, 0.0, 57.0, 0.7, inf, -0.01, 0.01, 0.1),  # thrown into the stop, and back by itself
    (0.0, 2.0, 0.05, 20.0, 1.5, 0.4, -inf, inf, 0.3),  # faster than it may be
]


@pytest.mark.parametrize("case", CASES)
def test_second_order_with_limits_is_what_an_integrator_with_events_finds(case):
    # every corner of the motion found, over one long step
    w, zeta, dt = case[3], case[4], case[8]
    got = second_order(*case, part_of(w, zeta, dt))
    expected = by_integration(*case)
    np.testing.assert_allclose([got[0], got[1] / w, got[2]], [expected[0], expected[1] / w, expected[2]], atol=1e-8)


@pytest.mark.parametrize(("most", "rate"), [(0.1, 0.4), (0.002, 4.0)])
def test_a_sinusoid_through_a_servo_with_limits(most, rate):
    # the loop of a flight: a new command each sample; scipy goes through the same commands
    command = 0.1 * np.sin(2.0 * np.pi * 3.0 * T)
    w, zeta = 57.0, 0.7
    keys = {"bandwidth_radps": w, "damping": zeta, "rate_limit_degps": np.degrees(rate), "max_deg": np.degrees(most)}
    got = moved(command, keys)
    y = v = 0.0
    for k, u in enumerate(command):
        assert got.servo[k, 2] == pytest.approx(y, abs=1e-8)
        y, v, mean = by_integration(y, v, u, w, zeta, rate, -inf, most, H)
        assert got.every[k, 2] == pytest.approx(mean, abs=1e-8)


NUMBERS = st.floats(-1.0, 1.0)


@settings(deadline=None, max_examples=300)
@given(
    y=NUMBERS, v=NUMBERS, u=NUMBERS, w=st.floats(1.0, 200.0), zeta=st.sampled_from([0.0, 0.1, 0.7, 1.0, 3.0]),
    R=st.sampled_from([inf, 0.05, 1.0, 30.0]), low=st.sampled_from([-inf, -1.0, -0.2]),
    high=st.sampled_from([inf, 1.0, 0.2]), dt=st.sampled_from([1e-4, 5e-3, 0.1]), share=st.floats(0.05, 0.95),
)  # fmt: skip
def test_a_step_in_two_parts_is_the_step(y, v, u, w, zeta, R, low, high, dt, share):
    # no step is a corner of the motion: position, rate and mean are those of two steps, within the limits
    y = min(max(y, low), high)
    v = min(max(20.0 * v, -R), R)

    def move(y, v, dt):
        if zeta == 0.0:
            end, mean = first_order(y, u, w, R, low, high, dt)
            return end, 0.0, mean
        return second_order(y, v, u, w, zeta, R, low, high, dt, part_of(w, zeta, dt))

    whole = move(y, v, dt)
    first = move(y, v, share * dt)
    second = move(first[0], first[1], dt - share * dt)
    scale = abs(y) + abs(u) + abs(v) / w + 1e-3
    assert abs(whole[0] - second[0]) < 1e-9 * scale
    assert abs(whole[1] - second[1]) < 1e-8 * w * scale
    assert abs(whole[2] - (share * first[2] + (1.0 - share) * second[2])) < 1e-9 * scale
    assert low <= whole[0] <= high
    assert abs(whole[1]) <= R * (1.0 + 1e-9)


def test_an_aileron_that_counts_the_other_way_has_the_limits_turned():
    # min and max of the common keys are about the axis: hale's right aileron has them with the other sign
    command = np.column_stack([STEP, -STEP, STEP, STEP])
    got = moved(command, {"max_deg": 1, "min_deg": -2}).every[-1]
    np.testing.assert_allclose(np.degrees(got), [1.0, -1.0, 1.0, 1.0], rtol=1e-14)
    own = moved(command, {"right_aileron": {"max_deg": 1, "min_deg": -2}}).every[-1]
    np.testing.assert_allclose(own, [0.05, np.radians(-2.0), 0.05, 0.05], rtol=1e-14)
