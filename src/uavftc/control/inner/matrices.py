"""Conditions on the matrices of the inner loop; each check returns the problems it finds."""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Matrix3, Problem
from uavftc.core.axes import Controlled, indices
from uavftc.core.signals import AXES
from uavftc.errors import InputError

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
    condition = condition_number(np.array(B_m))
    if condition < MAX_CONDITION:
        return []
    found = f"{np.array(B_m).tolist()}, condition number {condition:.3g}"
    expected = f"an invertible matrix, condition number below {MAX_CONDITION:g}"
    return [Problem(("B_m",), found, expected, "leave B_m out (null): the aircraft's is used")]


def condition_number(matrix: np.ndarray) -> float:
    """Return the condition number of a square matrix; infinite where it has none, and of an empty one."""
    with np.errstate(all="ignore"):
        try:
            condition = float(np.linalg.cond(matrix)) if matrix.size else np.inf
        except np.linalg.LinAlgError:
            condition = np.inf
    return condition


def refuse_reduced(A_s: np.ndarray, B_m: np.ndarray, axes: Controlled) -> None:
    """Check A_s and B_m cut down to the controlled axes, shape (n, n) each.

    Raises
    ------
    InputError
        If B_m has no inverse there, or A_s is not Hurwitz: the part of a stable matrix need not be stable.
    """
    of = " and ".join(AXES[i] for i in indices(axes)) if not all(axes) else "all axes"
    condition = condition_number(B_m)
    if not condition < MAX_CONDITION:
        raise InputError(
            "key controller.inner.B_m",
            found=f"{B_m.tolist()} for {of}, condition number {condition:.3g}",
            expected=f"a matrix that can be inverted, condition number below {MAX_CONDITION:g}",
            remedy="leave B_m out (null) if the scenario gives it, or correct analytic.B_m of the aircraft",
        )
    if not is_hurwitz(A_s):
        raise InputError(
            "key controller.inner.A_m",
            found=f"A_m + K_1 = {A_s.tolist()} for {of}, which is not Hurwitz",
            expected="A_m + K_1 with all eigenvalues in the left half plane, on the axes that are controlled too",
            remedy="make A_m more stable or K_1 smaller; the paper's A_m with K_1 = identity is the default",
        )
