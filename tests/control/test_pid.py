"""The cascaded autopilot: the dynamics that its gains are designed for, and the paper's scenarios."""

from __future__ import annotations

import numpy as np
import pytest

from flying import flown
from uavftc.control.whole import pid
from uavftc.core.given import ControlDesign
from uavftc.errors import InputError

A = np.array([[-8.5, 1.2, -3.5], [-1.5, -1.5, -1.0], [-0.02, 0.0, -2.0]])
B = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])
H = 0.001


def design(limit: float = 1e3) -> ControlDesign:
    return ControlDesign(A, B, np.array([[-limit, limit]] * 3), np.zeros(3), "test")


def test_each_rate_answers_alone_with_both_poles_at_the_bandwidth():
    # given the linear pair and no attitude loop (its bandwidth next to nothing) / when the rates are off by e(0)
    # then e'' + 2 w e' + w^2 e = 0 with z(0) = 0: e(t) = e(0) (1 - w t) exp(-w t), axis by axis
    step = pid.create(design(), H, {"attitude_bandwidth": 1e-12, "rate_bandwidth": 3.0})
    x2, start = np.array([0.1, -0.2, 0.3]), np.array([0.1, -0.2, 0.3])
    for k in range(1000):
        v2, _ = step(k * H, np.zeros(3), np.zeros(3), x2)
        x2 = x2 + H * (A @ x2 + B @ v2)
    np.testing.assert_allclose(x2, start * (1 - 3.0) * np.exp(-3.0), rtol=0.02)


def test_at_a_limit_the_integral_settles_and_lets_go_at_once():
    # given a command far beyond the limits for a minute / when it is taken back / then the surfaces leave their stops
    # with the next sample: without anti-windup they would stay there for seconds
    step = pid.create(design(0.05), 0.01, {})
    for k in range(6000):
        v2, _ = step(0.01 * k, np.ones(3), np.zeros(3), np.zeros(3))
    assert np.all(np.abs(v2) <= 0.05)
    assert v2.max() == 0.05
    after, _ = step(60.0, np.zeros(3), np.zeros(3), np.zeros(3))
    assert np.all(after < 0.05)


def test_the_heading_error_is_taken_the_short_way_round():
    here, there = np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, -3.0])
    _, telemetry = pid.create(design(), H, {})(0.0, there, here, np.zeros(3))
    np.testing.assert_allclose(telemetry["v1"], [0.0, 0.0, 0.5 * (2 * np.pi - 6.0)])


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_it_holds_the_step_and_survives_the_faults(plant):
    _, records, outcome = flown("scenario1", plant, "pid")
    assert outcome.completed
    assert np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1].max() < 0.02
    _, records, outcome = flown("scenario3", plant, "pid")
    assert outcome.completed
    assert np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1].max() < 0.5


@pytest.mark.parametrize("options", [{"rate_bandwith": 3}, {"rate_bandwidth": 0}, {"rate_bandwidth": "fast"}])
def test_options_are_known_and_above_0(options):
    with pytest.raises(InputError, match=r"controller\.options\.rate_band"):
        pid.create(design(), H, options)
