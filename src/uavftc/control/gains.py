"""Gains of the inner loop from its design matrices: eqs. (30) to (32) and the Erzberger condition of section 3.2.2."""

from __future__ import annotations

import numpy as np


def lyapunov_P(A_s: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Return the symmetric P, shape (3, 3), of A_s^T P + P A_s = -Q (below eq. 31).

    A_s, Q: shape (3, 3); A_s Hurwitz (1/s), Q symmetric positive definite.
    """
    from scipy.linalg import solve_continuous_lyapunov  # noqa: PLC0415 - a scenario is checked without it

    P = solve_continuous_lyapunov(A_s.T, -Q)
    return 0.5 * (P + P.T)


def reference_gain(A: np.ndarray, B_m: np.ndarray) -> np.ndarray:
    """Return K = B_m^-1 A, shape (3, 3), rad per rad/s.

    With A = A_m the closed loop x2' = A_m x2 - B_m K r has unit DC gain from r to x2. The printed K_2 is this formula
    with A = A_s, which the plant of eq. (27) does not have.
    """
    return np.linalg.solve(B_m, A)


def erzberger_K_0(A_l: np.ndarray, A_m: np.ndarray, B_m: np.ndarray) -> np.ndarray:
    """Return K_0, shape (3, 3), of A_l - B_m K_0^T = A_m, the full matching condition of the paper's [34]."""
    return np.linalg.solve(B_m, A_l - A_m).T
