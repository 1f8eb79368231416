"""The L1 norm against closed forms and against brute-force quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag, expm

from uavftc.analysis.l1_norm import TOLERANCE, contracting, l1_norm, l1_norm_bounds
from uavftc.analysis.linear import StateSpace, filter_C, product, static


def system(A, B, C, D=None):
    A, B, C = (np.atleast_2d(np.asarray(M, float)) for M in (A, B, C))
    return StateSpace(A, B, C, np.zeros((len(C), B.shape[1])) if D is None else np.atleast_2d(np.asarray(D, float)))


def second_order(zeta, wn):
    return system([[0.0, 1.0], [-(wn**2), -2.0 * zeta * wn]], [[0.0], [1.0]], [[1.0, 0.0]])


def assert_norm(found, expected, tolerance):
    """The bounds enclose the closed form and are as narrow as asked for; `slack` is rounding."""
    slack = 1e-11 * max(expected, 1.0)
    assert found.lower - slack <= expected <= found.upper + slack
    assert found.upper - found.lower <= tolerance + slack


@pytest.mark.parametrize("tolerance", [1e-2, TOLERANCE, 1e-9])
class TestClosedForms:
    @pytest.mark.parametrize("a", [1e-3, 0.2, 1.0, 60.0, 1e4])
    def test_first_order(self, a, tolerance):
        # int exp(-a t) dt = 1/a
        assert_norm(l1_norm_bounds(system(-a, 1.0, 1.0), tolerance), 1.0 / a, tolerance)

    @pytest.mark.parametrize("zeta", [0.005, 0.1, 0.5, 0.9])
    @pytest.mark.parametrize("wn", [0.3, 4.0])
    def test_underdamped_second_order(self, zeta, wn, tolerance):
        # Between its zeros the impulse response has areas in geometric progression:
        # 1/wn^2 coth(zeta pi / (2 sqrt(1 - zeta^2))).
        expected = 1.0 / (wn**2 * np.tanh(0.5 * zeta * np.pi / np.sqrt(1.0 - zeta**2)))
        assert_norm(l1_norm_bounds(second_order(zeta, wn), tolerance), expected, tolerance)

    @pytest.mark.parametrize(("n", "a"), [(2, 1.0), (5, 0.5), (8, 0.3)])
    def test_repeated_poles_in_one_chain(self, n, a, tolerance):
        # 1/(s + a)^n as one Jordan block, which has a single eigenvector: t^(n-1) exp(-a t)/(n-1)! >= 0, area a^-n.
        A = -a * np.eye(n) + np.diag(np.ones(n - 1), 1)
        assert_norm(l1_norm_bounds(system(A, np.eye(n)[:, -1:], np.eye(n)[:1]), tolerance), a**-n, tolerance)

    @pytest.mark.parametrize("ratio", [3.0, 300.0, 1e5, 1e7])
    def test_stiff_difference_of_exponentials(self, ratio, tolerance):
        # g = exp(-t) - ratio exp(-ratio t): one zero, at t = ln(ratio)/(ratio - 1), on either side a closed area.
        t = np.log(ratio) / (ratio - 1.0)
        before = (1.0 - np.exp(-ratio * t)) - (1.0 - np.exp(-t))
        after = np.exp(-t) - np.exp(-ratio * t)
        found = l1_norm_bounds(system(np.diag([-1.0, -ratio]), [[1.0], [ratio]], [[1.0, -1.0]]), tolerance)
        assert_norm(found, before + after, tolerance)

    def test_a_high_pass_counts_its_impulse(self, tolerance):
        # s/(s + a) = 1 - a/(s + a): an impulse of 1, and an area of 1 of the other sign, which does not cancel it.
        assert_norm(l1_norm_bounds(system(-7.0, 1.0, -7.0, 1.0), tolerance), 2.0, tolerance)

    def test_triangular_coupling(self, tolerance):
        # Two first-order channels, the second fed by the first: rows 1/a and |k|/(a b) + 1/b, the larger counts.
        a, b, k = 2.0, 0.5, -3.0
        A = [[-a, 0.0], [k, -b]]
        expected = max(1.0 / a, abs(k) / (a * b) + 1.0 / b)
        assert_norm(l1_norm_bounds(system(A, np.eye(2), np.eye(2)), tolerance), expected, tolerance)

    def test_the_largest_row_sum_counts_not_the_largest_column(self, tolerance):
        # Gains [[1, 2], [0, 2.5]] over first-order lags of unit area: rows 3 and 2.5, columns 1 and 4.5.
        lags = system(-np.eye(2), np.eye(2), np.eye(2))
        gains = np.array([[1.0, -2.0], [0.0, 2.5]])
        assert_norm(l1_norm_bounds(product(static(gains), lags), tolerance), 3.0, tolerance)

    def test_exact_cancellation_is_zero(self, tolerance):
        # The same lag twice with opposite signs, in coordinates that hide it: g vanishes, but no entry does.
        rng = np.random.default_rng(3)
        T = rng.normal(size=(4, 4))
        A = T @ block_diag(-np.diag([1.0, 30.0]), -np.diag([1.0, 30.0])) @ np.linalg.inv(T)
        B, C = T @ np.array([[1.0], [2.0], [1.0], [2.0]]), np.array([[3.0, 1.0, -3.0, -1.0]]) @ np.linalg.inv(T)
        assert_norm(l1_norm_bounds(system(A, B, C), tolerance), 0.0, tolerance)

    def test_a_filter_of_the_papers_has_norm_one(self, tolerance):
        # k/(s + k) has the area 1 whatever k: three channels, one row each.
        assert_norm(l1_norm_bounds(filter_C(60.0, np.array([0.1, 0.7, 1.0])), tolerance), 1.0, tolerance)


def test_without_states_the_norm_is_that_of_the_feed_through():
    # Row sums of |D|: 1 + 2 and 0.5 + 3.
    assert l1_norm(static([[1.0, -2.0], [0.5, 3.0]])) == 3.5


def test_the_norm_is_never_below_the_dc_gain_and_equals_it_for_one_sign():
    # |int g| <= int |g|; a chain of three different lags has g >= 0.
    A = np.diag([-0.2, -3.0, -60.0]) + np.diag([1.0, 1.0], 1)
    chain = system(A, [[0.0], [0.0], [1.0]], [[1.0, 0.0, 0.0]])
    assert l1_norm(chain, 1e-8) == pytest.approx(1.0 / (0.2 * 3.0 * 60.0), abs=1e-8)


def brute_force(G, T, doublings):
    """Trapezoidal int |g| over [0, T] with 2^doublings steps; returns the norm and the step."""
    h = T / 2**doublings
    X, E = G.B[:, None, :], expm(G.A * h)
    for _ in range(doublings):
        X = np.concatenate([X, np.einsum("ij,jkl->ikl", E, X)], axis=1)
        E = E @ E
    g = np.abs(np.einsum("ij,jkl->ikl", G.C, X))
    area = h * (g.sum(axis=1) - 0.5 * g[:, 0])
    return float(np.max((area + np.abs(G.D)).sum(axis=1))), h


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**31), n=st.integers(1, 6), p=st.integers(1, 3), m=st.integers(1, 3))
def test_random_coupled_systems_agree_with_brute_force(seed, n, p, m):
    # Full matrices, real and complex poles between 0.4 and 60 rad/s, feed-through: 500 000 trapezoids over 50 s, which
    # err by h^2/12 times the variation of g', below 2e-4 for these.
    rng = np.random.default_rng(seed)
    rates, blocks = list(-np.exp(rng.uniform(np.log(0.4), np.log(60.0), n))), []
    while rates:
        if len(rates) > 1 and rng.random() < 0.5:
            real, imaginary = rates.pop(), rng.uniform(0.1, 30.0)
            rates.pop()
            blocks.append([[real, imaginary], [-imaginary, real]])
        else:
            blocks.append([[rates.pop()]])
    T = np.linalg.qr(rng.normal(size=(n, n)))[0] * np.exp(rng.uniform(-0.5, 0.5, n))
    A = T @ block_diag(*blocks) @ np.linalg.inv(T)
    G = system(A, rng.normal(size=(n, m)), rng.normal(size=(p, n)), rng.normal(size=(p, m)))
    reference, _ = brute_force(G, 50.0, 19)
    found = l1_norm_bounds(G, TOLERANCE)
    assert found.upper - found.lower <= TOLERANCE
    assert found.lower - 2e-4 <= reference <= found.upper + 2e-4


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**31), n=st.integers(1, 7))
def test_the_decay_that_everything_rests_on_is_true(seed, n):
    # |R e^(A t) x| <= e^(-a t) |R x| for a spread of times, on strongly non-normal matrices.
    rng = np.random.default_rng(seed)
    A = np.triu(rng.normal(scale=5.0, size=(n, n)), 1) - np.diag(np.exp(rng.uniform(-1.5, 4.0, n)))
    R, decay = contracting(A)
    assert decay > 0.0
    for t in np.geomspace(1e-3, 10.0, 9):
        gain = np.linalg.norm(R @ expm(A * t) @ np.linalg.inv(R), 2)
        assert gain <= np.exp(-decay * t) * (1.0 + 1e-7)


@pytest.mark.parametrize("a", [0.0, 1e-3, 2.0])
def test_unstable_systems_have_no_norm(a):
    # An integrator and growing modes, also where the growing mode is neither reached nor seen.
    with pytest.raises(ValueError, match="not stable"):
        l1_norm(system(a, 1.0, 1.0))
    with pytest.raises(ValueError, match="not stable"):
        l1_norm(system(np.diag([-1.0, a]), [[1.0], [0.0]], [[1.0, 0.0]]))


def test_wrong_arguments_are_refused():
    # A tolerance that cannot be met by any work, and numbers that are none.
    with pytest.raises(ValueError, match="tolerance"):
        l1_norm(system(-1.0, 1.0, 1.0), 0.0)
    with pytest.raises(ValueError, match="not finite"):
        l1_norm(system(np.nan, 1.0, 1.0))
