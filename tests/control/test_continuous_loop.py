"""The closed loop before it is sampled, which the benchmark gives to general solvers, against the printed equations."""

from __future__ import annotations

import numpy as np
import pytest

import paper
from uavftc.flight.build import build_flight
from uavftc.jobs.bench import continuous
from uavftc.jobs.bench.flights import scenario


@pytest.fixture(scope="module")
def loop():
    flight = build_flight(scenario("scenario2", plant="analytic"))
    return continuous.loop_of(flight, np.radians([5.0, 5.0, 5.0]))


def test_the_right_hand_side_is_the_papers_equations(loop):
    # Against the printed equations in plain numpy, (1), (2), (7), (9), (10), (14)-(16), (20), (30)-(32), at states
    # where every term acts, the limits of the surfaces among them; no bound of an estimate is reached.
    rng = np.random.default_rng(7)
    limited = 0
    for t in (1.0, 11.0, 19.0):
        y = np.concatenate([rng.normal(size=9) * 0.1, 1.0 + rng.normal(size=3) * 0.1, rng.normal(size=39) * 0.1])
        x1, x2, x2_hat, omega, eps, v, zeta = y[:21].reshape(7, 3)
        W, W_observer = y[21:].reshape(2, 5, 3)
        G, Phi = paper.g1(x1), paper.phi(x1, x2)
        gradient = (x2_hat - x2) @ paper.P @ paper.B_M
        eta, d1_hat, e = omega * v + W.T @ Phi + eps, W_observer.T @ Phi, x1 - zeta
        v1 = np.linalg.solve(G, 0.5 * (np.radians(5.0) - x1) - d1_hat)
        u2 = np.clip(v, -0.05, 0.1)
        limited += np.count_nonzero(u2 != v)
        gyroscopic = np.linalg.solve(paper.INERTIA, -np.cross(x2, paper.INERTIA @ x2))
        expected = [
            G @ x2,
            gyroscopic + paper.A_M @ x2 + paper.B_M @ u2 + continuous.d2_of(t),
            paper.A_M @ x2_hat + paper.B_M @ eta + paper.K_1 @ (x2_hat - x2),
            -paper.GAMMA * gradient * v,
            -paper.GAMMA * gradient,
            -paper.BANDWIDTH * (eta + np.linalg.solve(paper.B_M, paper.A_M) @ v1),
            0.5 * e + G @ x2 + d1_hat,
            -paper.GAMMA * np.outer(Phi, gradient).ravel(),
            0.05 * np.outer(Phi, e).ravel(),
        ]
        found = continuous.right_hand_side(t, y, loop)
        np.testing.assert_allclose(found, np.concatenate(expected), rtol=1e-9, atol=1e-9)
    assert limited > 0


def test_the_projection_holds_an_estimate_at_its_bound(loop):
    # given: every estimate at its upper bound; then: one that falls moves as without bounds, one that rises does not
    y = continuous.start(np.zeros(3))
    y[6:9] = np.linalg.solve((paper.P @ paper.B_M).T, [0.01, -0.01, 0.02])  # a gradient of both signs
    y[15:18] = 0.1, 0.1, -0.1
    free = loop.copy()
    for name, bound in (("omega_max", 2.0), ("W_max", 50.0), ("eps_max", 50.0)):
        assert loop[name] == bound
        free[name] = np.inf
    places = {"omega_max": slice(9, 12), "eps_max": slice(12, 15), "W_max": slice(21, 36)}
    for name, place in places.items():
        y[place] = loop[name]
    held, moving = (continuous.right_hand_side(0.0, y, each) for each in (loop, free))
    for place in places.values():
        assert (moving[place] > 0.0).any()
        assert (moving[place] < 0.0).any()
        np.testing.assert_array_equal(held[place], np.minimum(moving[place], 0.0))
