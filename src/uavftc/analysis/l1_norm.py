"""The L1 norm of a stable system, with certified bounds.

    ||G||_L1 = max_i sum_j ( |D_ij| + int_0^inf |g_ij(t)| dt ),   g_ij(t) = c_i e^(A t) b_j

the gain from the largest input to the largest output, in the sense of max |.| over time and channels (Lemma 2). A
feed-through D is an impulse in the impulse response and counts with its absolute value.

Method. A Lyapunov equation gives a length of the state, |R x|, that decays: |R e^(A t) x| <= e^(-a t) |R x|, a > 0,
because A^T P + P A <= -2 a P with P = R^T R, which is checked, not assumed. That bounds the tail beyond a horizon, and
the remainder of the Taylor polynomial of g over an interval. Its Bernstein coefficients enclose the polynomial:

* all of them above the remainder, or all below minus it: g has one sign there, and int |g| = |int g|, exactly
  |c A^-1 (e^(A t_b) - e^(A t_a)) b|;
* otherwise |int g| <= int |g| <= h (mean |coefficient| + remainder), and the interval is halved.

Halving goes on until the gap between the two, over all intervals and the tail, meets the tolerance. Only intervals
around a zero of g (or where g vanishes) are ever halved far. Neither distinct nor real poles are needed, and stiffness
costs only intervals at the start. Certified up to the rounding of double precision, which is not followed.
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, eigh, expm, matrix_balance, solve_continuous_lyapunov, solve_triangular

from uavftc.analysis.linear import StateSpace

TOLERANCE = 1e-4  # absolute, in the unit of the norm
DEGREE = 7  # of the Taylor polynomials
MAX_INTERVALS = 4_000_000  # of one impulse response at one level; beyond it memory ends first

_TO_BERNSTEIN = np.array([[comb(k, j) / comb(DEGREE, j) for j in range(DEGREE + 1)] for k in range(DEGREE + 1)])


class Bounds(NamedTuple):
    """lower <= norm <= upper."""

    lower: float
    upper: float


def l1_norm(system: StateSpace, tolerance: float = TOLERANCE) -> float:
    """Return the L1 norm from above: never below the norm, and above it by no more than `tolerance`.

    Raises
    ------
    ValueError
        If the system is not asymptotically stable, has values that are not finite, or the tolerance is not positive.
    ArithmeticError
        If double precision or memory does not suffice for the tolerance.
    """
    return l1_norm_bounds(system, tolerance).upper


def l1_norm_bounds(system: StateSpace, tolerance: float = TOLERANCE) -> Bounds:
    """Return certified bounds of the L1 norm that are no more than `tolerance` apart; errors as `l1_norm`."""
    if not tolerance > 0.0:
        raise ValueError(f"the tolerance must be positive, not {tolerance}")
    if not all(np.all(np.isfinite(matrix)) for matrix in system):
        raise ValueError("the system has entries that are not finite")
    D = np.abs(system.D)
    lower, upper = D.copy(), D.copy()
    if len(system.A) and D.size:
        impulse = _ImpulseResponse(system, tolerance / D.shape[1])
        for i in range(D.shape[0]):
            for j in range(D.shape[1]):
                low, high = impulse.integral(i, j)
                lower[i, j] += low
                upper[i, j] += high
    rows_low, rows_high = lower.sum(axis=1), upper.sum(axis=1)
    return Bounds(float(np.max(rows_low, initial=0.0)), float(np.max(rows_high, initial=0.0)))


class _ImpulseResponse:
    """c e^(A t) b of all channels, with a length |R x| of the state that decays."""

    def __init__(self, system: StateSpace, tolerance: float) -> None:
        self.A, self.B, self.C = balanced(system)
        R, self.decay = contracting(self.A)
        self.budget = 0.5 * tolerance
        self.integrals = np.linalg.solve(self.A.T, self.C.T).T  # C A^-1
        self.gains = np.linalg.norm(solve_triangular(R, self.C.T, trans="T"), axis=0)  # |c x| <= gain |R x|
        self.R = R
        powers = [np.eye(len(self.A))]
        for k in range(1, DEGREE + 2):
            powers.append(powers[-1] @ self.A / k)
        self.powers = np.array(powers)  # A^k / k!
        self.horizon, self.final = self._horizon()
        self._steps: list[np.ndarray] = []

    def _horizon(self) -> tuple[float, np.ndarray]:
        """Return T and e^(A T) B such that the tail of every channel is below the budget."""
        T = 1.0 / self.decay
        step = expm(self.A * T)
        for _ in range(64):
            final = step @ self.B
            tail = np.outer(self.gains, np.linalg.norm(self.R @ final, axis=0)) / self.decay
            if np.max(tail) <= self.budget:
                return T, final
            T, step = 2.0 * T, step @ step
        raise ArithmeticError("the impulse response does not decay within double precision")

    def _step(self, level: int) -> np.ndarray:
        """Return e^(A h), h = T / 2^level."""
        while len(self._steps) <= level:
            self._steps.append(expm(self.A * (self.horizon / 2.0 ** len(self._steps))))
        return self._steps[level]

    def integral(self, i: int, j: int) -> Bounds:
        """Return bounds of int_0^inf |g_ij| dt, no more than twice the budget apart."""
        lower = abs(self.integrals[i] @ self.final[:, j])
        upper = self.gains[i] * np.linalg.norm(self.R @ self.final[:, j]) / self.decay
        taylor_rows = self.C[i] @ self.powers[:-1]  # (DEGREE + 1, n)
        rest_rows = self.R @ self.powers[-1]
        X = self.B[:, j : j + 1]  # states at the left ends of the intervals still open
        for level in range(200):
            h, step = self.horizon / 2.0**level, self._step(level)
            with np.errstate(over="ignore", invalid="ignore"):  # far too long an interval: halved
                taylor = (taylor_rows @ X) * h ** np.arange(DEGREE + 1)[:, None]
                bernstein = _TO_BERNSTEIN @ taylor
                rest = self.gains[i] * np.linalg.norm(rest_rows @ X, axis=0) * h ** (DEGREE + 1)
                one_sign = (bernstein.min(axis=0) > rest) | (bernstein.max(axis=0) < -rest)
                most = h * (np.abs(bernstein).mean(axis=0) + rest)
            least = np.abs(self.integrals[i] @ (step @ X - X))
            lower += least[one_sign].sum()
            upper += least[one_sign].sum()
            open_ = ~one_sign
            gap = np.maximum(most - least, 0.0)[open_].sum()
            if gap <= self.budget:  # false for nan
                low = least[open_].sum()
                return Bounds(float(lower + low), float(upper + low + gap))
            X = X[:, open_]
            if 2 * X.shape[1] > MAX_INTERVALS:
                break
            X = np.hstack([X, self._step(level + 1) @ X])
        raise ArithmeticError(f"the tolerance {2.0 * self.budget:g} is out of reach in double precision")


def balanced(system: StateSpace) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return A, B, C with the states scaled by powers of two, without rounding: the same impulse response."""
    A, (scale, _) = matrix_balance(system.A, permute=False, separate=True)
    return A, system.B / scale[:, None], system.C * scale


def contracting(A: np.ndarray) -> tuple[np.ndarray, float]:
    """Return R, upper triangular, and a > 0, 1/s, such that |R e^(A t) x| <= e^(-a t) |R x| for every x.

    Raises
    ------
    ValueError
        If A is not Hurwitz.
    ArithmeticError
        If it is, but no such R can be certified in double precision.
    """
    abscissa = float(np.max(np.linalg.eigvals(A).real))
    if not abscissa < 0.0:
        raise ValueError(f"the system is not stable: a pole has the real part {abscissa:g}")
    eye = np.eye(len(A))
    for share in (0.5, 0.25, 0.1, 0.0):  # of the slowest pole's rate that the length is to decay with
        try:
            P = solve_continuous_lyapunov((A - share * abscissa * eye).T, -eye)
            P = 0.5 * (P + P.T)
            R = cholesky(P)  # P = R^T R
        except np.linalg.LinAlgError:
            continue
        dissipation = -(A.T @ P + P @ A)
        rounding = 4.0 * len(A) * np.finfo(float).eps * np.linalg.norm(A) * np.linalg.norm(P)
        decay = 0.5 * float(eigh(dissipation - rounding * eye, P, eigvals_only=True)[0])
        if decay > 0.0:
            return R, decay
    raise ArithmeticError("the system is too close to instability for a certificate in double precision")
