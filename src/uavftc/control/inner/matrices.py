"""Conditions on the matrices of the inner loop; each check returns the problems it finds."""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Matrix3, Problem

MAX_CONDITION = 1e8  # of B_m and A_m + K_1; beyond it what is solved with them has lost half of its digits


def is_hurwitz(matrix: np.ndarray) -> bool:
    """Return whether all eigenvalues of `matrix` are in the open left half plane."""
    try:
        return bool(np.max(np.linalg.eigvals(matrix).real) < 0)
    except np.linalg.LinAlgError:
        return False


def hurwitz(A_m: Matrix3, K_1: Matrix3) -> list[Problem]:
    """A_s = A_m + K_1 governs the prediction error, so it must be stable."""
    with np.errstate(all="ignore"):
        A_s = np.array(A_m) + np.array(K_1)
        condition = float(np.linalg.cond(A_s)) if is_hurwitz(A_s) else np.inf
    if condition < MAX_CONDITION:
        return []
    if is_hurwitz(A_s):
        return [
            Problem(
                ("A_m",),
                f"A_m + K_1 = {A_s.tolist()}, condition number {condition:.3g}",
                f"A_m + K_1 with a condition number below {MAX_CONDITION:g}; beyond it P of eq. (31) has no digits",
                "bring its entries closer together; the paper's A_m with K_1 = identity is the default",
            )
        ]
    return [
        Problem(
            ("A_m",),
            f"A_m + K_1 = {A_s.tolist()}, which is not Hurwitz",
            "A_m + K_1 with all eigenvalues in the left half plane",
            "make A_m more stable or K_1 smaller; the paper's A_m with K_1 = identity is the default",
        )
    ]


def positive_definite(Q: Matrix3) -> list[Problem]:
    """Q is the right side of the Lyapunov equation A_s' P + P A_s = -Q."""
    q = np.array(Q)
    with np.errstate(all="ignore"):
        symmetric = np.allclose(q, q.T, rtol=1e-9, atol=0)
        try:
            if symmetric and np.min(np.linalg.eigvalsh(q)) > 0:
                return []
        except np.linalg.LinAlgError:
            pass
    found = f"{q.tolist()}, which is not {'positive definite' if symmetric else 'symmetric'}"
    return [Problem(("Q",), found, "a symmetric positive definite matrix", "use the identity, the default")]


def invertible(B_m: Matrix3 | None) -> list[Problem]:
    """The gains are B_m^-1 times a matrix; null is the aircraft's B_m, which is checked where it is computed."""
    if B_m is None:
        return []
    with np.errstate(all="ignore"):
        try:
            condition = float(np.linalg.cond(np.array(B_m)))
        except np.linalg.LinAlgError:
            condition = np.inf
    if condition < MAX_CONDITION:
        return []
    found = f"{np.array(B_m).tolist()}, condition number {condition:.3g}"
    expected = f"an invertible matrix, condition number below {MAX_CONDITION:g}"
    return [Problem(("B_m",), found, expected, "leave B_m out (null): the aircraft's is used")]
