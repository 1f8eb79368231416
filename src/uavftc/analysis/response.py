"""How fast a controller answers a step: the time to 63 % of it, 1/bandwidth of a loop of first order.

A comparison of tracking errors ranks tolerance to faults only among loops of the same speed: a loop of twice the
bandwidth has half the integral of the error before anything fails.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from uavftc.core.signals import ANGLES, AXES

SHARE = 1.0 - math.exp(-1.0)
LEAST_STEP_DEG = 0.1
UNEQUAL = 1.25
"""Ratio of the slowest to the fastest time from which loops count as of different speed."""


def response_s(history: Mapping[str, np.ndarray], axis: str) -> float | None:
    """Return the time at which an axis first has 63 % of the step that is commanded at t = 0, s.

    Parameters
    ----------
    history
        Published columns, name to shape (n,).
    axis
        `roll`, `pitch` or `yaw`.

    Returns
    -------
    None where its reference is no step at t = 0, or moves before, or the axis never comes so far.
    """
    angle = ANGLES[AXES.index(axis)]
    t, x, reference = history["time_s"], history[f"{angle}_rad"], history[f"{angle}_ref_rad"]
    if not len(t):
        return None
    x, reference = np.unwrap(x), np.unwrap(reference)
    step = reference[0] - x[0]
    if not math.isfinite(step) or abs(step) < math.radians(LEAST_STEP_DEG):
        return None
    share = (x - x[0]) / step
    reached = np.flatnonzero(share >= SHARE)
    if not len(reached) or reached[0] == 0:
        return None
    k = int(reached[0])
    if np.any(np.abs(reference[: k + 1] - reference[0]) > 1e-9):
        return None
    part = (SHARE - share[k - 1]) / (share[k] - share[k - 1])
    return float(t[k - 1] + part * (t[k] - t[k - 1]))


def unequal(times: Mapping[str, Mapping[str, float | None]]) -> str | None:
    """Return a line that says which controllers answer a step at other speeds, on the axis where they differ most.

    Parameters
    ----------
    times
        By controller and axis, s, from `response_s`.
    """
    worst, line = UNEQUAL, None
    for axis in AXES:
        known = {name: at for name, each in times.items() if (at := each.get(axis)) is not None}
        if len(known) < 2 or (ratio := max(known.values()) / min(known.values())) <= worst:
            continue
        worst = ratio
        listed = ", ".join(f"{name} {at:.2f} s" for name, at in sorted(known.items(), key=lambda item: item[1]))
        line = (
            f"not equally fast: {axis} has 63 % of its step after {listed}; a faster loop has smaller integrals of the "
            "error without tolerating more, so compare at equal bandwidths (--variant NAME:KEY=VALUE)"
        )
    return line
