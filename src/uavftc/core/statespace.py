"""A linear system as four matrices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class StateSpace(NamedTuple):
    """x' = A x + B u, or x[k+1] of a sampled one, and y = C x + D u; shapes (n, n), (n, m), (p, n), (p, m)."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
