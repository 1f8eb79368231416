"""Margins of a sampled linear loop: against closed forms, and against the poles of the loop with both in it."""

import math

import numpy as np
import pytest

from uavftc.analysis.loop_margins import closed, held, loop_margins
from uavftc.core.statespace import StateSpace


def integrator(n=1):
    return StateSpace(np.zeros((n, n)), np.eye(n), np.eye(n), np.zeros((n, n)))


def gain(K):
    n = len(K)
    return StateSpace(np.zeros((0, 0)), np.zeros((0, n)), np.zeros((n, 0)), np.asarray(K, float))


def test_an_integrator_under_proportional_feedback_has_the_margins_of_its_closed_form():
    # z = 1 - K h is at the edge for K = 2/h; with the delay T: K/w = 1 and pi/2 + w (T + h/2) = pi, nearly
    h, K = 0.001, 5.0
    margins = loop_margins(held(integrator(), h), gain([[-K]]), h)
    assert margins.gain == pytest.approx(2.0 / (K * h), rel=1e-6)
    assert margins.delay_s == pytest.approx(math.pi / (2.0 * K) - 0.5 * h, rel=1e-4)
    assert margins.gain_reduction == 0.0
    assert margins.stable


def test_each_axis_counts_and_the_least_of_them_limits():
    h = 0.001
    margins = loop_margins(held(integrator(3), h), gain(-np.diag([2.0, 8.0, 4.0])), h)
    assert margins.delay_s == pytest.approx(math.pi / 16.0 - 0.5 * h, rel=1e-4)
    assert margins.gain == pytest.approx(2.0 / (8.0 * h), rel=1e-6)


def test_an_unstable_plant_has_a_least_gain_too():
    h, K = 0.001, 6.0
    plant = held(StateSpace(np.array([[2.0]]), np.eye(1), np.eye(1), np.zeros((1, 1))), h)  # x' = 2 x + u
    margins = loop_margins(plant, gain([[-K]]), h)
    assert margins.stable
    assert margins.gain_reduction == pytest.approx(2.0 / K, rel=1e-9)


def radius(plant, controller, factor, delay):
    """Return the spectral radius of a loop with a factor and a delay of whole samples at its input."""
    n, m = plant.B.shape
    if delay == 0:
        return np.abs(np.linalg.eigvals(closed(plant._replace(B=factor * plant.B), controller))).max()
    size = m * delay
    A = np.block(
        [
            [plant.A, np.zeros((n, size - m)), factor * plant.B],
            [np.zeros((size, n)), np.eye(size, k=-m)],
        ]
    )
    B = np.zeros((n + size, m))
    B[n : n + m] = np.eye(m)
    C = np.hstack([plant.C, np.zeros((len(plant.C), size))])
    return np.abs(np.linalg.eigvals(closed(StateSpace(A, B, C, plant.D), controller))).max()


@pytest.mark.parametrize("seed", range(6))
def test_the_margins_are_where_the_poles_leave_the_unit_circle(seed):
    rng = np.random.default_rng(seed)
    h = 0.01
    A = rng.normal(size=(4, 4)) - 2.5 * np.eye(4)
    plant = held(StateSpace(A, rng.normal(size=(4, 2)), np.eye(4), np.zeros((4, 2))), h)
    controller = StateSpace(
        np.diag([0.99, 0.95]),
        0.01 * rng.normal(size=(2, 4)),
        0.3 * rng.normal(size=(2, 2)),
        0.3 * rng.normal(size=(2, 4)),
    )
    margins = loop_margins(plant, controller, h)
    assert margins.stable
    if math.isfinite(margins.gain):
        assert (
            radius(plant, controller, margins.gain * 0.995, 0)
            < 1.0
            < radius(plant, controller, margins.gain * 1.005, 0)
        )
    if margins.delay_s < 2.0:
        whole = int(margins.delay_s / h)
        assert radius(plant, controller, 1.0, whole) < 1.0 < radius(plant, controller, 1.0, whole + 1)
