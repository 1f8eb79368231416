"""What surfaces with limits can still do about an equilibrium: sets of moments, as linear programs.

    { B du : low <= du <= high }

with B the change of angular (or other) acceleration per deflection and du the way that each surface has left. The set
is a zonotope: a sum of segments, one a surface. Durham, Bordignon and Beck, Aircraft Control Allocation (Wiley, 2017),
chapter 4, call it the attainable moment subset.
"""

from __future__ import annotations

import itertools

import numpy as np

LOST = 0.02
"""Of what all surfaces together could do: a direction with less is lost."""
FAR = 1e6
"""Shares beyond this, and disturbances beyond what is there by it, count as infinite."""


def kept(B: np.ndarray, size: np.ndarray) -> list[int]:
    """Return the rows of B, shape (k, n), that can still be had apart from each other; the others are lost.

    `size`, shape (k,), is what counts as all of each row. As long as there is a direction of which less than `LOST` is
    there, the row that it mostly is goes: with the rudder lost that is yaw, though ailerons yaw a little as they roll.
    """
    rows = list(range(len(B)))
    scaled = B / np.maximum(size, 1e-12)[:, None]
    while rows:
        U, values, _ = np.linalg.svd(scaled[rows])
        values = np.append(values, np.zeros(len(rows)))[: len(rows)]
        if values[-1] >= LOST:
            break
        rows.pop(int(np.argmax(np.abs(U[:, -1]))))
    return rows


def left(B: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the least and greatest that can be had of each row with the other rows at zero, shape (k, 2).

    Parameters
    ----------
    B
        Shape (k, n).
    low, high
        Ways that the n surfaces have left, low <= 0 <= high, shape (n,); may be infinite.
    """
    found = np.zeros((len(B), 2))
    for i, side in itertools.product(range(len(B)), range(2)):
        sign = (-1.0, 1.0)[side]
        share = share_of(B, low, high, sign * np.eye(len(B))[i])
        found[i, side] = sign * (np.inf if share == 0.0 else 1.0 / share)
    return found


def share_of(B: np.ndarray, low: np.ndarray, high: np.ndarray, demand: np.ndarray) -> float:
    """Return which share of what the surfaces can do in the direction of a demand, shape (k,), it takes.

    Over 1 it cannot be met; infinite where they can do nothing in that direction; 0 of no demand, or where nothing
    limits them.

    The greatest s with B du = s demand, low <= du <= high, by `scipy.optimize.linprog`; the share is 1/s.
    """
    from scipy.optimize import linprog  # noqa: PLC0415 - 0.1 s that a command without it need not pay

    size = float(np.max(np.abs(demand)))
    if size == 0.0:
        return 0.0
    n = B.shape[1]
    rows = np.maximum(np.max(np.abs(B), axis=1, initial=0.0), 1e-12)  # each equation in its natural size
    equations = np.column_stack([B, -demand / size]) / rows[:, None]
    bounds = [
        (lo if np.isfinite(lo) else None, hi if np.isfinite(hi) else None) for lo, hi in zip(low, high, strict=True)
    ]
    result = linprog(np.append(np.zeros(n), -1.0), A_eq=equations, b_eq=np.zeros(len(B)), bounds=[*bounds, (0.0, None)])
    if result.status == 3:  # unbounded
        return 0.0
    most = float(result.x[-1]) if result.x is not None else 0.0
    return np.inf if most * FAR < size else size / most


def outline(B: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the corners of { B u : low <= u <= high }, B shape (2, n), in their order around, shape (m, 2).

    A sum of segments: sorted by angle, they are its edges, once there and once back.
    """
    ways = (B * (high - low)).T
    ways = ways[np.any(ways != 0.0, axis=1)]
    start = B @ low + np.sum(np.where(_backwards(ways)[:, None], ways, 0.0), axis=0)
    ways = np.where(_backwards(ways)[:, None], -ways, ways)
    ways = ways[np.argsort(np.arctan2(ways[:, 1], ways[:, 0]))]
    there = start + np.vstack([np.zeros((1, 2)), np.cumsum(ways, axis=0)])
    back = there[-1] - np.cumsum(ways, axis=0)[:-1] if len(ways) else np.zeros((0, 2))
    return np.vstack([there, back])


def _backwards(ways: np.ndarray) -> np.ndarray:
    """Return which vectors point down, or straight to the left: those are walked the other way."""
    down: np.ndarray = (ways[:, 1] < 0.0) | ((ways[:, 1] == 0.0) & (ways[:, 0] < 0.0))
    return down


DIRECTIONS = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])


def extremes(samples: np.ndarray) -> np.ndarray:
    """Return those of many samples, shape (N, 3), that are furthest in one of 26 directions, shape (m, 3)."""
    furthest = np.argmax(samples @ DIRECTIONS.T, axis=0)
    chosen: np.ndarray = samples[np.unique(furthest)]
    return chosen
