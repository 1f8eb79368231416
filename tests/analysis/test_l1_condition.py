"""Condition (33) and the bounds of Theorems 2 and 3 for the paper's design."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from control.paper import A_M, A_S, B_M, BANDWIDTH, GAMMA, lyapunov
from uavftc.analysis.l1_condition import Given, condition_33, norms_of, theorem_2, theorem_2_weighted, theorem_3
from uavftc.analysis.l1_norm import l1_norm
from uavftc.analysis.linear import C_over_H, H_of, filter_C, product

K = np.linalg.solve(B_M, A_M)
ONE = np.ones(3)
SHARED = {"A_s": A_S, "B_m": B_M, "K": K, "filter_bandwidth": BANDWIDTH}
PRINTED = norms_of(A_S, omega=ONE, **SHARED)
PLANT = norms_of(A_M, omega=ONE, **SHARED)
STATED = Given(sigma_0=0.01, sigma_r=1.0, r_max=0.05, delta_5=0.1, lipschitz=0.5)


def quadrature(A, B, C, T=60.0, doublings=20):
    """Largest row sum of int |C e^(A t) B| dt by trapezoids."""
    h = T / 2**doublings
    X, E = B[:, None, :], expm(A * h)
    for _ in range(doublings):
        X, E = np.concatenate([X, np.einsum("ij,jkl->ikl", E, X)], axis=1), E @ E
    g = np.abs(np.einsum("ij,jkl->ikl", C, X))
    return float(np.max((h * (g.sum(axis=1) - 0.5 * g[:, 0])).sum(axis=1)))


@pytest.mark.parametrize(("A", "norms"), [(A_S, PRINTED), (A_M, PLANT)], ids=["A_s", "A_m"])
def test_norms_of_the_papers_design_agree_with_quadrature(A, norms):
    # H, G = H - H C and H C K written out by hand, with the states of the filter below those of H.
    eye, zero, k = np.eye(3), np.zeros((3, 3)), BANDWIDTH * np.eye(3)
    assert pytest.approx(quadrature(A, B_M, eye), abs=1e-5) == norms.H
    series = np.block([[A, B_M @ k], [zero, -k]])
    out = np.hstack([eye, zero])
    through = np.vstack([zero, K])
    assert pytest.approx(quadrature(series, through, out), abs=1e-5) == norms.HCK
    passed = np.block([[A, -B_M @ k], [zero, -k]])
    assert pytest.approx(quadrature(passed, np.vstack([B_M, eye]), out), abs=1e-5) == norms.G


def test_the_initial_condition_counts_the_impulse():
    # s (sI - A)^-1 = I + A (sI - A)^-1: one for the impulse, on top of int |A e^(A t)| dt.
    for A, norms in ((A_S, PRINTED), (A_M, PLANT)):
        assert norms.initial == pytest.approx(1.0 + quadrature(A, A, np.eye(3)), abs=1e-5)
    assert condition_33(PRINTED, STATED).sigma_in == pytest.approx(0.01 * PRINTED.initial)


def test_the_condition_is_the_inequality():
    # (33) in the form (54), with all five figures stated: true just below the largest Lipschitz constant, false at it.
    result = condition_33(PRINTED, STATED)
    assert result.holds is True
    L = result.lipschitz_max
    left = PRINTED.G * (L * STATED.sigma_r + STATED.delta_5)
    right = STATED.sigma_r - PRINTED.HCK * STATED.r_max - PRINTED.initial * STATED.sigma_0
    assert left == pytest.approx(right, rel=1e-12)
    assert condition_33(PRINTED, STATED._replace(lipschitz=L * (1 - 1e-9))).holds is True
    failing = condition_33(PRINTED, STATED._replace(lipschitz=L * (1 + 1e-9)))
    assert failing.holds is False
    assert "fails" in failing.reason


def test_a_condition_that_no_lipschitz_constant_meets():
    # The commands alone take more than sigma_r: 3.5 times 0.5 rad/s against 1 rad/s.
    result = condition_33(PRINTED, STATED._replace(r_max=0.5))
    assert (result.holds, result.lipschitz_max) == (False, None)
    assert "every L" in result.reason


@pytest.mark.parametrize("name", ["sigma_0", "sigma_r", "r_max", "delta_5"])
def test_what_is_not_stated_leaves_the_condition_open(name):
    # The supremum 1/||G|| remains; stating more can only make the largest Lipschitz constant smaller.
    result = condition_33(PRINTED, STATED._replace(**{name: None}))
    assert result.holds is None
    assert name in result.reason
    assert result.lipschitz_max == pytest.approx(1.0 / PRINTED.G)
    assert "supremum" in result.lipschitz_max_is
    assert condition_33(PRINTED, STATED).lipschitz_max < 1.0 / PRINTED.G


def test_without_a_lipschitz_constant_its_limit_is_still_given():
    result = condition_33(PRINTED, STATED._replace(lipschitz=None))
    assert result.holds is None
    assert result.lipschitz_max == condition_33(PRINTED, STATED).lipschitz_max


def test_a_large_sigma_r_approaches_the_supremum():
    limits = [condition_33(PRINTED, STATED._replace(sigma_r=s)).lipschitz_max for s in (1.0, 10.0, 1e4)]
    assert limits == sorted(limits)
    assert limits[-1] == pytest.approx(1.0 / PRINTED.G, rel=1e-4)


class TestTheorem3:
    def test_with_one_scalar_filter_gamma_1_is_the_papers(self):
        # (69): H C H^-1 = C if C is one filter for all channels and H is the H of x2_tilde; its norm is 1.
        result = theorem_3(PRINTED, Given(lipschitz=0.5, gamma_0=1e-3))
        assert result.gamma_1 == pytest.approx(1e-3 / (1.0 - 0.5 * PRINTED.G), rel=1e-6)
        gamma_2 = PRINTED.CH_s * 1e-3 + 0.5 * result.gamma_1
        assert result.gamma_2 == pytest.approx(gamma_2, rel=1e-6)
        assert result.reason is None

    def test_with_different_filters_the_printed_form_is_too_small(self):
        # Effectiveness 0.5, 0.7, 1 gives three filters, and C H^-1 no longer commutes: ||C|| = 1 is not a bound.
        mixed = norms_of(A_S, omega=np.array([0.5, 0.7, 1.0]), **SHARED)
        assert pytest.approx(1.0, abs=1e-6) == mixed.C
        assert mixed.HCH_s > 1.02

    def test_with_the_plants_matrix_it_is_larger(self):
        # H_m C H_s^-1 is not C even for a scalar filter; that is what the plant (27) has.
        direct = l1_norm(product(H_of(A_M, B_M), C_over_H(filter_C(BANDWIDTH, ONE), A_S, B_M)), 1e-6)
        assert PLANT.HCH_s == pytest.approx(direct, abs=2e-6)
        # By hand: C H_s^-1 = B_m^-1 (k I - k (k I + A_s) / (s + k)), with the state of the filter below that of H_m.
        k, zero = BANDWIDTH * np.eye(3), np.zeros((3, 3))
        series = np.block([[A_M, -k @ (k + A_S)], [zero, -k]])
        by_hand = quadrature(series, np.vstack([k, np.eye(3)]), np.hstack([np.eye(3), zero]))
        assert PLANT.HCH_s == pytest.approx(by_hand, abs=1e-5)
        assert PLANT.HCH_s > 1.5

    def test_there_is_none_where_the_loop_gain_reaches_one(self):
        result = theorem_3(PRINTED, Given(lipschitz=1.0 / PRINTED.G, gamma_0=1e-3))
        assert (result.gamma_1, result.gamma_2) == (None, None)
        assert "not below 1" in result.reason

    def test_there_is_none_where_the_condition_fails(self):
        given = STATED._replace(r_max=0.5, gamma_0=1e-3)
        result = theorem_3(PRINTED, given, condition_33(PRINTED, given))
        assert result.gamma_1 is None
        assert "fails" in result.reason

    def test_it_needs_both_constants(self):
        assert theorem_3(PRINTED, Given(lipschitz=0.5)).reason == "not stated: gamma_0"
        assert theorem_3(PRINTED, Given(gamma_0=0.5)).reason == "not stated: lipschitz"


class TestTheorem2:
    def test_the_printed_proof_gives_the_printed_design_no_bound(self):
        # P to four decimals is that of Q = I, and eq. (44) divides by lambda_min(Q) - 1.
        assert theorem_2(lyapunov(A_S, np.eye(3)), B_M, np.eye(3)) is None

    def test_a_larger_Q_has_one_that_holds(self):
        # The prediction error under a constant disturbance eta and eps_hat alone, e_min = 0: the integral of
        # |x2_tilde|^2 is at most 2 (V(0) + V(t)), and by dV/dt = -|x2_tilde|^2 (Q = 2 I) exactly V(0) - V(t).
        Q = 2.0 * np.eye(3)
        P, eta = lyapunov(A_S, Q), np.array([0.02, -0.01, 0.03])
        F = np.block([[A_S, B_M], [-GAMMA * B_M.T @ P, np.zeros((3, 3))]])  # [x2_tilde; eps_hat - eta]
        h, steps = 2e-5, 50_000
        E, x, total = expm(F * h), np.concatenate([np.zeros(3), -eta]), 0.0
        for _ in range(steps):
            x = E @ x
            total += h * x[:3] @ x[:3]
        V = [0.5 * eta @ eta / GAMMA, 0.5 * x[:3] @ P @ x[:3] + 0.5 * x[3:] @ x[3:] / GAMMA]
        assert total == pytest.approx(V[0] - V[1], rel=1e-2)
        bound = theorem_2(P, B_M, Q)
        assert bound.per_V == pytest.approx(2.0)
        assert total <= bound.bound(V[0], V[1], 0.0)

    def test_the_factors_are_those_of_eq_44(self):
        Q = np.diag([3.0, 4.0, 5.0])
        P = lyapunov(A_S, Q)
        bound = theorem_2(P, B_M, Q)
        assert bound.per_V == pytest.approx(2.0 / 2.0)
        assert bound.per_e == pytest.approx(np.max(np.linalg.svd(P @ B_M)[1]) ** 2 / 2.0)
        assert bound.bound(1.0, 2.0, 3.0) == pytest.approx(3.0 * bound.per_V + 3.0 * bound.per_e)

    def test_weighted_by_lambda_the_printed_design_has_one(self):
        # 4/lambda and 4 |P B_m|^2/lambda^2 with lambda = 1: 4 and 174.9, the factor that eq. (44) has for Q = 2 I.
        bound = theorem_2_weighted(lyapunov(A_S, np.eye(3)), B_M, np.eye(3))
        assert bound.per_V == pytest.approx(4.0)
        assert bound.per_e == pytest.approx(174.9, abs=0.05)
        Q = 2.0 * np.eye(3)
        assert bound.per_e == pytest.approx(theorem_2(lyapunov(A_S, Q), B_M, Q).per_e)

    @pytest.mark.parametrize(("gamma", "share"), [(0.0, 0.5), (10.0, 1e-3), (GAMMA, 0.0)])
    def test_the_weighted_bound_holds_for_the_error_dynamics(self, gamma, share):
        # Eq. (40) with (31), written out anew: effectiveness, one weight and eps_hat wrong at the start, a command, a
        # regressor and an e_min that move. For Gamma = 0 nothing adapts and V(0) is without meaning: no parameter is
        # wrong then, and a constant e_min alone drives. `share` of the bound is reached: it is not met by being huge.
        P = lyapunov(A_S, np.eye(3))
        wrong = np.zeros(9) if gamma == 0.0 else np.array([-0.5, -0.3, 0.2, 0.02, -0.01, 0.03, 0.05, 0.02, -0.04])

        def e_min(t):
            return np.array([0.01, -0.02, 0.015]) * (1.0 if gamma == 0.0 else np.cos(40.0 * t))

        def rhs(t, y):
            x, omega, weight, eps = y[:3], y[3:6], y[6:9], y[9:12]
            v, Phi = 0.1 * np.sin(3.0 * t + np.arange(3.0)), np.exp(-(np.sin(t) ** 2))
            s = B_M.T @ P @ x
            x_dot = A_S @ x + B_M @ (omega * v + weight * Phi + eps + e_min(t))
            rate = [x @ x, e_min(t) @ e_min(t)]
            return np.concatenate([x_dot, -gamma * v * s, -gamma * Phi * s, -gamma * s, rate])

        start = np.concatenate([np.zeros(3), wrong, np.zeros(2)])
        t_end = 20.0 if gamma < GAMMA else 1.0
        end = solve_ivp(rhs, (0.0, t_end), start, method="DOP853", rtol=1e-7, atol=1e-12).y[:, -1]
        V_0 = 0.0 if gamma == 0.0 else 0.5 * wrong @ wrong / gamma
        bound = theorem_2_weighted(P, B_M, np.eye(3)).bound(V_0, end[13])
        assert share * bound < end[12] <= bound
