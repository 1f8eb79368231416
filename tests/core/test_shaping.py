"""Shaped noise against scipy: transition, covariance and stationary state of sections in series, at any step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

from uavftc.core.shaping import SECTIONS, move, output

RATES = np.array([1.0, 9.0, 120.0, 0.7, 3.0, 1500.0])
LEADS = np.array([0.0, 1.54, 1.57, 1.63, 0.0, 1.5])


def matrices(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return F, G and the output row of n sections, from the differential equations of each."""
    F, G, y = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    for i in range(n):
        into = y.copy()  # y of the section before, over the states
        F[i] = RATES[i] * into
        F[i, i] -= RATES[i]
        lead = LEADS[i] if i else 0.0
        y = lead * into
        y[i] += 1.0 - lead
    G[0] = RATES[0]
    return F, G, y


def covariance(F: np.ndarray, G: np.ndarray, step: float) -> np.ndarray:
    """Return the covariance of the noise over a step: that of the stationary state less what is left of it."""
    P = solve_continuous_lyapunov(F, -np.outer(G, G))
    Phi = expm(F * step)
    return P - Phi @ P @ Phi.T


def moved(x: np.ndarray, n: int, step: float, key: int = 1, counter: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Return the states after a step, and the memory that the law worked in."""
    state, work = np.zeros(SECTIONS), np.zeros((6, SECTIONS, SECTIONS))
    state[:n] = x
    move(state, RATES, LEADS, n, step, key, counter, work)
    return state[:n], work


@pytest.mark.parametrize("n", [1, 2, 3, 5, 6])
@pytest.mark.parametrize("step", [1e-6, 1e-3, 0.05, 0.9, 30.0])
def test_transition_and_covariance_are_exact(n, step):
    # whatever the step: by the matrix exponential, and by the stationary covariance of Lyapunov's equation
    F, G, _ = matrices(n)
    noise = moved(np.zeros(n), n, step)[0]
    for i in range(n):
        unit = moved(np.eye(n)[i], n, step)[0] - noise
        np.testing.assert_allclose(unit, expm(F * step)[:, i], atol=1e-13)
    root = np.tril(moved(np.zeros(n), n, step)[1][4][:n, :n])
    expected = covariance(F, G, step)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    if step >= 1e-3:  # below, the difference of two stationary covariances has no digits left for what is small
        np.testing.assert_allclose((root @ root.T) / scale, expected / scale, atol=1e-8)
    else:
        assert (root @ root.T)[0, 0] == pytest.approx(RATES[0] * -np.expm1(-2.0 * RATES[0] * step) / 2.0, rel=1e-12)


@pytest.mark.parametrize("n", [2, 6])
def test_a_long_step_draws_the_stationary_state(n):
    # many of them have the covariance that Lyapunov's equation gives, and no memory of where they began
    F, G, _ = matrices(n)
    P = solve_continuous_lyapunov(F, -np.outer(G, G))
    drawn = np.array([moved(np.full(n, 1e3), n, 1e3, counter=n * i)[0] for i in range(20_000)])
    scale = np.sqrt(np.diag(P))
    np.testing.assert_allclose(np.cov(drawn.T) / np.outer(scale, scale), P / np.outer(scale, scale), atol=0.03)
    np.testing.assert_allclose(drawn.mean(axis=0) / scale, 0.0, atol=0.03)


def test_two_half_steps_spread_as_one():
    # Q(2a) = Q + Phi Q Phi': the doubling, on steps that need none
    F, G, _ = matrices(4)
    half, whole = covariance(F, G, 0.004), covariance(F, G, 0.008)
    Phi = expm(F * 0.004)
    np.testing.assert_allclose(half + Phi @ half @ Phi.T, whole, rtol=1e-9)
    roots = [np.tril(moved(np.zeros(4), 4, step)[1][4][:4, :4]) for step in (0.004, 0.008)]
    np.testing.assert_allclose(roots[0] @ roots[0].T, half, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(roots[1] @ roots[1].T, whole, rtol=1e-7, atol=1e-12)


def test_the_output_is_that_of_the_sections():
    # as the rows of the differential equations have it
    x = np.array([0.3, -1.0, 2.0, 0.5, -0.7, 0.1])
    for n in (1, 2, 4, 5, 6):
        assert output(x, LEADS, n) == pytest.approx(matrices(n)[2] @ x[:n], rel=1e-14)


def test_a_step_that_is_not_a_number_ends():
    # the length flown is made of the vehicle's airspeed: it may be nan or infinite, and the loop must end
    for step in (np.nan, np.inf, 1e300):
        moved(np.ones(3), 3, step)
