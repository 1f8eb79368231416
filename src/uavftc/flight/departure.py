"""Where a lost flight began to be lost: the first cause, not the last symptom.

A vehicle has departed about an axis at the row after the last one with an attitude error of at most `AWAY_DEG`; of
several axes the first counts. With it is said which faults acted then, and which effectors were at a stop or at a
limit, and from when on.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from uavftc.core.signals import AXES, attitude_error
from uavftc.flight.build import Flight
from uavftc.scenario.schema import Scenario

AWAY_DEG = 5.0  # what the default requirement `excursion` allows
NEAR_S = 0.5  # s; what came to its stop within this after the departure is named with it
_AT = 1e-9  # rad


def departure(flight: Flight, records: np.ndarray) -> str | None:
    """Return in words when a lost flight departed, or None where it ended with a small error.

    Parameters
    ----------
    flight
        As flown.
    records
        Its last rows, shape (n,), the one at which it was lost among them or next.
    """
    if not len(records):
        return None
    away = ~(np.abs(attitude_error(records)) <= np.radians(AWAY_DEG)) & np.array(flight.given.axes)
    first = [_since(away[:, axis]) for axis in range(3)]
    begun = [k for k in first if k is not None]
    if not begun:
        return None
    k = min(begun)
    axis = AXES[first.index(k)]
    at = float(records["t"][k])
    if k == 0 and at == 0.0:
        return f"never within {AWAY_DEG:g} deg of its reference in {axis}"
    stopped = sorted((part for part in _at_limits(flight, records) if part[1] <= at + NEAR_S), key=lambda part: part[1])
    parts = [f"departed in {axis} from {at:.2f} s", *_acting(flight.scenario, at)]
    return ", ".join([*parts, *(f"{what} from {since:.2f} s" for what, since in stopped)])


def _acting(scenario: Scenario, t: float) -> list[str]:
    """Return the faults and the damage that act at a time, s."""
    entries: list[tuple[str, Any]] = [(f"faults[{i}]", fault) for i, fault in enumerate(scenario.faults)]
    entries += [(f"damage[{i}]", one) for i, one in enumerate(scenario.damage)]
    acting = []
    for name, entry in entries:
        if entry.start_s <= t and (entry.end_s is None or t < entry.end_s):
            kind = getattr(entry, "kind", "")
            of = getattr(entry, "surface", getattr(entry, "engine", ""))
            acting.append(f"under {name}{f' ({kind} of {of})' if kind else ''} since {entry.start_s:g} s")
    return acting


def _since(true: np.ndarray) -> int | None:
    """Return the row from which on it is true to the end, or None."""
    if not true[-1]:
        return None
    false = np.flatnonzero(~true)
    return int(false[-1]) + 1 if len(false) else 0


def _at_limits(flight: Flight, records: np.ndarray) -> list[tuple[str, float]]:
    """Return what is at its stop, or commanded to its limit, at the end, and since when, s."""
    given, found = flight.given, []
    for j, name in enumerate(given.effectors):
        low, high = given.stops_rad[j]
        u = records["effectors"]["deflection"][:, j]
        if (k := _since((u <= low + _AT) | (u >= high - _AT))) is not None:
            found.append((f"{name} at its stop", float(records["t"][k])))
    if not found:
        for axis, (low, high) in enumerate(given.design.limits_rad):
            v2 = records["v2"][:, axis]
            k = _since((v2 <= low + _AT) | (v2 >= high - _AT)) if given.axes[axis] else None
            if k is not None:
                found.append(
                    (f"{('aileron', 'elevator', 'rudder')[axis]} command at its limit", float(records["t"][k]))
                )
    return found
