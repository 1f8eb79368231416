"""Linear systems of the inner loop: eqs. (33) to (35) as state space.

    H(s) = (sI - A)^-1 B_m           C(s) = diag( omega_i k / (s + omega_i k) )
    G(s) = H(s) (I - C(s))           H(s) C(s) K

with A = A_s = A_m + K_1 as printed, or A = A_m, the matrix of the plant (27). k is the filter's bandwidth, rad/s, and
omega the effectiveness, one factor a channel, taken as constant: only then is C(s) a transfer matrix.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.statespace import StateSpace


def static(D: np.ndarray) -> StateSpace:
    """Return the system without state, y = D u."""
    D = np.atleast_2d(np.asarray(D, float))
    p, m = D.shape
    return StateSpace(np.zeros((0, 0)), np.zeros((0, m)), np.zeros((p, 0)), D)


def product(left: StateSpace, right: StateSpace) -> StateSpace:
    """Return left(s) right(s), a series connection: the input meets `right` first."""
    A = np.block(
        [
            [right.A, np.zeros((len(right.A), len(left.A)))],
            [left.B @ right.C, left.A],
        ]
    )
    return StateSpace(
        A,
        np.vstack([right.B, left.B @ right.D]),
        np.hstack([left.D @ right.C, left.C]),
        left.D @ right.D,
    )


def times_first_order(system: StateSpace, M_1: np.ndarray, M_0: np.ndarray) -> StateSpace:
    """Return system(s) (s M_1 + M_0), without states of its own; `system` must be strictly proper.

    From s (sI - A)^-1 = I + A (sI - A)^-1.

    Raises
    ------
    ValueError
        If `system` has a feed-through: the product would be a differentiator.
    """
    if np.any(system.D):
        raise ValueError("a system with feed-through times a polynomial in s is not proper")
    A, B, C, _ = system
    return StateSpace(A, A @ B @ M_1 + B @ M_0, C, C @ B @ M_1)


def response(system: StateSpace, s: complex) -> np.ndarray:
    """Return the transfer matrix at one complex frequency s, shape (p, m)."""
    A, B, C, D = system
    return C @ np.linalg.solve(s * np.eye(len(A)) - A, B) + D


def H_of(A: np.ndarray, B_m: np.ndarray) -> StateSpace:
    """Return H(s) = (sI - A)^-1 B_m, eq. (35), from deflection, rad, to rate, rad/s. A in 1/s, B_m in 1/s^2."""
    n, m = B_m.shape
    return StateSpace(A, B_m, np.eye(n), np.zeros((n, m)))


def filter_C(bandwidth: float, omega: np.ndarray) -> StateSpace:
    """Return C(s) = diag(omega_i k / (s + omega_i k)), below eq. (32); k in rad/s, omega shape (m,), above 0."""
    poles = np.diag(bandwidth * np.asarray(omega, float))
    m = len(poles)
    return StateSpace(-poles, np.eye(m), poles, np.zeros((m, m)))


def complement(C: StateSpace) -> StateSpace:
    """Return I - C(s)."""
    return StateSpace(C.A, C.B, -C.C, np.eye(len(C.D)) - C.D)


def G_of(H: StateSpace, C: StateSpace) -> StateSpace:
    """Return G(s) = H(s) (I - C(s)), eq. (34)."""
    return product(H, complement(C))


def HCK_of(H: StateSpace, C: StateSpace, K: np.ndarray) -> StateSpace:
    """Return H(s) C(s) K, from the commanded rate to the reference system's rate up to its sign, eq. (46)."""
    return product(product(H, C), static(K))


def initial_response(A: np.ndarray) -> StateSpace:
    """Return s (sI - A)^-1 = I + A (sI - A)^-1, the system of sigma_in in eq. (33); its feed-through is I."""
    eye = np.eye(len(A))
    return times_first_order(StateSpace(A, eye, eye, np.zeros_like(eye)), eye, np.zeros_like(eye))


def C_over_H(C: StateSpace, A: np.ndarray, B_m: np.ndarray) -> StateSpace:
    """Return C(s) H(s)^-1 = C(s) B_m^-1 (sI - A), proper because C has relative degree 1; B_m square."""
    inverse = np.linalg.inv(B_m)
    return times_first_order(C, inverse, -inverse @ A)
