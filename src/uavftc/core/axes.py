"""The axes that an aircraft controls, and matrices cut down to them.

An aircraft without a rudder, or without ailerons, has two. Its laws are those of two axes, put into three: what belongs
to the missing axis is a row and a column of zeros.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.signals import AXES, SURFACES

Controlled = tuple[bool, bool, bool]
"""Whether roll, pitch and yaw are controlled."""

ALL: Controlled = (True, True, True)


def indices(axes: Controlled) -> np.ndarray:
    """Return the controlled axes, in order: I of docs/theory.md, "Fewer axes"."""
    return np.flatnonzero(axes)


def reduced(matrix: np.ndarray, axes: Controlled) -> np.ndarray:
    """Return M_II, shape (n, n), of a matrix (3, 3): rows and columns of the controlled axes."""
    i = indices(axes)
    return np.asarray(matrix, float)[np.ix_(i, i)]


def embedded(matrix: np.ndarray, axes: Controlled, fill: float = 0.0) -> np.ndarray:
    """Return a matrix of the controlled axes, shape (n, n), put into (3, 3); `fill` elsewhere."""
    i = indices(axes)
    whole = np.full((3, 3), fill)
    whole[np.ix_(i, i)] = matrix
    return whole


def masked(matrix: np.ndarray, axes: Controlled) -> np.ndarray:
    """Return a matrix (3, 3) with zeros in the rows and columns of the axes that are not controlled."""
    return embedded(reduced(matrix, axes), axes)


def left_to_the_airframe(axes: Controlled) -> list[str]:
    """Return a line for each axis that is not controlled."""
    return [
        f"no {SURFACES[j]}: {AXES[j]} is left to the airframe (no effector acts about it)"
        for j in range(3)
        if not axes[j]
    ]
