"""The observer of the outer loop, eqs. (14) to (16), against a continuous integration of the same equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import paper
from uavftc.control.outer import nndo
from uavftc.core.program import Program
from uavftc.core.stage import params_of
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario

SIGMA, GAMMA = 0.5, 0.05  # section 4
NODES = 5


def motion(t):
    """A smooth attitude motion: x1 and its first derivative, each (n, 3)."""
    t = np.atleast_1d(np.asarray(t, float))[:, None]
    a, w, b = np.radians([12.0, 8.0, 15.0]), np.array([0.9, 1.3, 0.5]), np.array([0.2, 0.7, 1.1])
    return a * np.sin(w * t + b), a * w * np.cos(w * t + b)


def rates(x1, x1_dot, d1=0.0):
    """x2 of x1' = g1 x2 + d1."""
    return np.array([np.linalg.solve(paper.g1(a), b) for a, b in zip(x1, x1_dot - d1, strict=True)])


def observed(h, x1, x2, psi_0=0.0, gamma=GAMMA):
    """d1_hat of the law and its state after every sample, on given measurements."""
    params = params_of(
        nndo.PARAMS, h=h, sigma=SIGMA, gamma=gamma, centres=paper.CENTRES, width=paper.WIDTH, psi_0=psi_0, axes=1.0
    )
    law = paper.Law(nndo.stage, params)
    d1_hat, states = np.empty((len(x1), 3)), np.empty(len(x1), nndo.STATE)
    for k in range(len(x1)):
        d1_hat[k] = law(x1_meas=x1[k], x2_meas=x2[k])["d1_hat"]
        states[k] = law.state
    return d1_hat, states


def continuous(t, x1_of, x2_of):
    """d1_hat(t) of the continuous eqs. (14) to (16)."""

    def rhs(now, y):
        zeta, W = y[:3], y[3:].reshape(NODES, 3)
        x1, x2 = x1_of(now), x2_of(now)
        Phi = paper.phi(x1, x2)
        zeta_dot = -SIGMA * zeta + SIGMA * x1 + paper.g1(x1) @ x2 + W.T @ Phi
        return np.concatenate([zeta_dot, GAMMA * np.outer(Phi, x1 - zeta).ravel()])

    start = np.concatenate([x1_of(t[0]), np.zeros(3 * NODES)])
    solved = solve_ivp(rhs, (t[0], t[-1]), start, t_eval=t, rtol=1e-9, atol=1e-12)
    W = solved.y[3:].T.reshape(-1, NODES, 3)
    return np.array([w.T @ paper.phi(x1_of(s), x2_of(s)) for w, s in zip(W, t, strict=True)])


def idle_bound(h, drive, duration):
    """Bound of |d1_hat| by the quadrature error alone, per axis.

    Over a step the law holds f = sigma x1 + x1' at the mean of its ends: an error of at most
    h^3/12 (max|f''| + sigma max|f'|), as if a disturbance delta of 1/h of it acted. With V = e^2/2 + |W|^2/(2 gamma),
    V' = -sigma e^2 + e delta <= delta^2/(4 sigma), so |W| <= delta sqrt(gamma T/(2 sigma)); |Phi| <= sqrt(5).
    """
    first, second = np.gradient(drive, h, axis=0), np.diff(drive, 2, axis=0) / h**2
    delta = h**2 / 12.0 * (np.abs(second).max(axis=0) + SIGMA * np.abs(first).max(axis=0))
    return np.sqrt(NODES * GAMMA * duration / (2.0 * SIGMA)) * delta


@pytest.mark.parametrize("rate", [50, 200, 1000])
def test_idle_where_the_kinematics_are_exact(rate):
    # e and d1_hat stay at the size of the quadrature error, O(h^2): the observer sees nothing where there is nothing
    h, duration = 1.0 / rate, 10.0
    x1, x1_dot = motion(np.arange(0.0, duration + h / 2, h))
    d1_hat, _ = observed(h, x1, rates(x1, x1_dot))
    bound = 1.05 * idle_bound(h, SIGMA * x1 + x1_dot, duration)
    assert (np.abs(d1_hat).max(axis=0) < bound).all()
    assert bound.max() < 0.07 / rate**2  # the bound itself is small and falls with the square of the rate


def test_idle_in_a_whole_flight_with_exact_kinematics():
    # eqs. (14) to (16) do nothing in the paper's scenarios: d1 = 0, and d2 enters the inner loop only
    rate, duration = 200, 20.0
    scenario = Scenario.model_validate(
        {
            "name": "idle", "duration_s": duration, "plant": "analytic",
            "reference": {"phi_deg": 5, "theta_deg": 5, "psi_deg": 5},
            "saturation": {"min_rad": -0.05, "max_rad": 0.1},
            "disturbances": [{"kind": "angular-acceleration", "q_degps2": "0.3 + sin(2*t)", "r_degps2": 0.5}],
        }
    )  # fmt: skip
    records, outcome = fly_to_memory(build_flight(scenario))
    assert outcome.completed
    x1_dot = np.array([paper.g1(x1) @ x2 for x1, x2 in zip(records["x1"], records["x2"], strict=True)])
    # within a sample f'' is larger than its mean over two: the rates bend where the command steps
    bound = 2.0 * idle_bound(1.0 / rate, SIGMA * records["x1"] + x1_dot, duration)
    assert (np.abs(records["d1_hat"]).max(axis=0) < bound).all()
    assert np.degrees(np.abs(records["d1_hat"]).max()) < 2e-5  # deg/s; the commanded rates reach 2.5 deg/s


@pytest.mark.parametrize(("rate", "allowed"), [(50, 2e-3), (200, 5e-4), (1000, 1e-4)])
def test_estimate_of_a_constant_disturbance_is_the_continuous_one(rate, allowed):
    # along a real motion: the sampled observer follows the continuous one at first order in the sample time
    h, d1 = 1.0 / rate, np.radians([1.0, -0.5, 0.7])
    t = np.arange(0.0, 20.0 + h / 2, h)
    x1, x1_dot = motion(t)
    d1_hat, _ = observed(h, x1, rates(x1, x1_dot, d1))
    every = rate // 10
    reference = continuous(t[::every], lambda s: motion(s)[0][0], lambda s: rates(*motion(s), d1)[0])
    assert np.abs(d1_hat[::every] - reference).max() < allowed * np.abs(d1).max()
    assert np.abs(reference).max() > 0.5 * np.abs(d1).max()  # the comparison is of something


def test_converges_to_a_constant_disturbance():
    # e'' + sigma e' + gamma |Phi|^2 e = 0 here: decay sigma/2, so that 60 s leave exp(-15) of the start
    h, d1 = 0.005, np.radians([0.3, -0.4, 0.2])
    x1 = np.tile(np.radians([2.0, -1.0, 3.0]), (12001, 1))
    d1_hat, _ = observed(h, x1, rates(x1, np.zeros_like(x1), d1))
    assert np.abs(d1_hat[-1] - d1).max() < 1e-5 * np.abs(d1).max()
    assert np.abs(d1_hat[int(8 / h)] - d1).max() > 0.01 * np.abs(d1).max()  # and not at once


def test_converges_to_minus_the_gyro_bias_seen_through_the_kinematics():
    # measured rates x2 + b look like x1' = g1 (x2 + b) + d1 with d1 = -g1 b
    h, b = 0.005, np.radians([0.3, 0.3, 0.3])
    x1 = np.tile(np.radians([5.0, 5.0, 5.0]), (12001, 1))
    d1_hat, _ = observed(h, x1, np.tile(b, (12001, 1)))
    np.testing.assert_allclose(d1_hat[-1], -paper.g1(x1[0]) @ b, atol=1e-5 * b[0])


def test_lyapunov_function_of_theorem_1_never_rises_outside_the_ball():
    # d1 = W*' Phi lies in the span of the network, so V' = -sum sigma_i e_i^2; what the sampling adds acts like an
    # error eps of the approximation, and outside the ball |e_i| <= eps / sigma_i of the theorem V must fall
    h = 0.005
    t = np.arange(0.0, 30.0 + h / 2, h)
    W_opt = np.random.default_rng(3).normal(scale=np.radians(0.5), size=(NODES, 3))

    def x2_of(s):
        return np.radians([3.0, 2.0, 2.5]) * np.cos(np.array([0.8, 1.1, 0.6]) * s)

    def x1_dot(s, x1):
        return paper.g1(x1) @ x2_of(s) + W_opt.T @ paper.phi(x1, x2_of(s))

    x1 = solve_ivp(x1_dot, (0.0, t[-1]), np.zeros(3), t_eval=t, rtol=1e-11, atol=1e-13).y.T
    _, states = observed(h, x1, np.array([x2_of(s) for s in t]))
    e = x1 - states["zeta"]
    V = 0.5 * (e**2).sum(axis=1) + ((W_opt - states["W_hat"]) ** 2).sum(axis=(1, 2)) / (2.0 * GAMMA)
    # d1_hat is held over a step and used one sample late: its change over a step is what eps stands for
    eps = np.abs(np.diff(np.einsum("kni,kn->ki", W_opt - states["W_hat"], states["Phi"]), axis=0)).max(axis=0)
    outside = (np.abs(e) > eps / SIGMA).any(axis=1)[:-1]
    assert outside.mean() > 0.5  # the statement is about most of the flight
    assert (np.diff(V)[outside] <= 0.0).all()
    # and it falls by what eq. (18) says, the integral of sigma e^2
    np.testing.assert_allclose(V[0] - V[-1], h * SIGMA * (e**2).sum(), rtol=0.02)


def test_basis_takes_the_heading_relative_to_the_start():
    # the same flight on another heading gives the same estimate
    h, d1 = 0.01, np.radians([0.3, -0.4, 0.2])
    x1, x1_dot = motion(np.arange(0.0, 5.0, h))
    x2 = rates(x1, x1_dot, d1)
    north, _ = observed(h, x1, x2)
    south, _ = observed(h, x1 + np.array([0.0, 0.0, np.pi]), x2, psi_0=np.pi)
    np.testing.assert_allclose(south, north, atol=1e-13)
    assert np.abs(north[-1]).max() > 1e-3


def test_starts_at_the_measurement_and_without_an_estimate():
    # zeta(0) = x1(0) and W_hat(0) = 0: the first sample must not kick the loop
    rows = paper.empty_rows(1)
    record = paper.as_records(rows)[0]
    record["x1_meas"], record["x2_meas"] = [0.5, -0.3, 2.0], [0.1, 0.2, 0.3]
    block = nndo.stage.block(
        params_of(nndo.PARAMS, h=0.01, sigma=0.5, gamma=0.05, centres=paper.CENTRES, width=0.4, psi_0=2.0, axes=1.0)
    )
    assert Program([block]).run(rows, 0, 1) == 1
    np.testing.assert_array_equal(record["d1_hat"], 0.0)
    np.testing.assert_array_equal(block.state[0]["zeta"], [0.5, -0.3, 2.0])
