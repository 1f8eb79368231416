"""Linear algebra in three dimensions, unrolled: vectors are any three values, nothing is allocated."""

from __future__ import annotations

from uavftc.core.stage import law


@law
def multiply(A, x):
    """Return A x, three values; A (3, 3)."""
    return (
        A[0, 0] * x[0] + A[0, 1] * x[1] + A[0, 2] * x[2],
        A[1, 0] * x[0] + A[1, 1] * x[1] + A[1, 2] * x[2],
        A[2, 0] * x[0] + A[2, 1] * x[1] + A[2, 2] * x[2],
    )


@law
def multiply_transposed(A, x):
    """Return A^T x, three values; A (3, 3)."""
    return (
        A[0, 0] * x[0] + A[1, 0] * x[1] + A[2, 0] * x[2],
        A[0, 1] * x[0] + A[1, 1] * x[1] + A[2, 1] * x[2],
        A[0, 2] * x[0] + A[1, 2] * x[1] + A[2, 2] * x[2],
    )


@law
def solve(M, b):
    """Return the solution x of M x = b by Cramer's rule, three values; M (3, 3).

    A singular M gives inf or nan, which the flight's watch reports as the loss of the vehicle.
    """
    c0 = M[1, 1] * M[2, 2] - M[1, 2] * M[2, 1]
    c1 = M[1, 2] * M[2, 0] - M[1, 0] * M[2, 2]
    c2 = M[1, 0] * M[2, 1] - M[1, 1] * M[2, 0]
    det = M[0, 0] * c0 + M[0, 1] * c1 + M[0, 2] * c2
    return (
        (b[0] * c0 + b[1] * (M[0, 2] * M[2, 1] - M[0, 1] * M[2, 2]) + b[2] * (M[0, 1] * M[1, 2] - M[0, 2] * M[1, 1]))
        / det,
        (b[0] * c1 + b[1] * (M[0, 0] * M[2, 2] - M[0, 2] * M[2, 0]) + b[2] * (M[0, 2] * M[1, 0] - M[0, 0] * M[1, 2]))
        / det,
        (b[0] * c2 + b[1] * (M[0, 1] * M[2, 0] - M[0, 0] * M[2, 1]) + b[2] * (M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0]))
        / det,
    )
