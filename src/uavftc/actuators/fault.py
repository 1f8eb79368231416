"""What all faults share: when they act, whether the controller is told, and on what they act.

A severe fault works on the total deflection: the angle of the surface as the aircraft counts it, trim included. An
effector is counted as its position is; a gang of several as its axis is, each member by its weight.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from pydantic import SerializerFunctionWrapHandler, model_serializer

from uavftc.config.values import Flag, NonNegative, SurfaceName, Window
from uavftc.core.given import Given
from uavftc.core.stage import law


class Fault(Window):
    """A fault on [start_s, end_s), of which the controller is told nothing unless it says so."""

    known: Flag = False
    """whether the controller is told of it"""
    known_after_s: NonNegative = 0.0
    """how long after its beginning, where it is told: the time of a detection; it knows of the end as late"""

    @model_serializer(mode="wrap")
    def _short(self, default: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out what the controller is not told: most faults have nothing there."""
        written: dict[str, Any] = default(self)
        if not self.known and not self.known_after_s:
            del written["known"], written["known_after_s"]
        return written

    @property
    def known_from_s(self) -> float | None:
        """When the controller is told of it, s; None where it never is."""
        return _later(self.start_s, self.known_after_s) if self.known else None

    @property
    def known_until_s(self) -> float | None:
        """Until when the controller takes it to last, s, where it is told at all; None is to the end of the flight."""
        return None if self.end_s is None else _later(self.end_s, self.known_after_s)


class SurfaceFault(Fault):
    """A fault of a surface, or of a gang of them."""

    surface: SurfaceName
    """`aileron`, `elevator`, `rudder`, or an effector of the aircraft such as `left_aileron`"""


def _later(time_s: float, after_s: float) -> float:
    """Return the sum, rounded to 1 ns: 0.1 + 0.2 is the sample at 0.3 s, not the one after it."""
    return time_s if after_s == 0.0 else round(time_s + after_s, 9)


class Struck(NamedTuple):
    """The effectors of a flight as one fault sees them; n of them, in their order in a row."""

    start: np.ndarray
    """Beginning, s, shape (n,); infinite for those that it does not act on."""
    end: np.ndarray
    """End, s, shape (n,); infinite till the end of the flight."""
    weight: np.ndarray
    """Deflection per deflection of the surface or gang, both as the laws count them, shape (n,); 0 of the others."""
    scale: np.ndarray
    """Deflection, as the laws count it, per angle of the fault, shape (n,)."""
    sense: np.ndarray
    """Deflection, as the laws count it, per angle as the aircraft counts it, shape (n,): 1 or -1."""
    trim: np.ndarray
    """Deflection at trim, rad, shape (n,): the total deflection is this and `e.deflection`."""


def struck(entry: Any, given: Given) -> Struck:
    """Return whom a fault with a `surface` and a window acts on, and how its angles count there."""
    n = len(given.effectors)
    members = given.targets[entry.surface]
    hit = np.array([j in members for j in range(n)])
    sense = np.ones(n) if given.sense is None else np.asarray(given.sense, dtype=float)
    weight = np.array([members.get(j, 0.0) for j in range(n)])
    alone = entry.surface in given.effectors and len(members) == 1
    return Struck(
        start=np.where(hit, entry.start_s, np.inf),
        end=np.full(n, np.inf if entry.end_s is None else entry.end_s),
        weight=weight,
        scale=np.where(hit, sense, 0.0) if alone else weight,
        sense=sense,
        trim=np.zeros(n) if given.trim_rad is None else np.asarray(given.trim_rad, dtype=float),
    )


def beyond_stops(entry: Any, given: Given, key: str, angle_deg: float) -> list[tuple[str, str]]:
    """Return (key, line) where a total deflection of a fault, deg, is beyond a mechanical stop."""
    hit = struck(entry, given)
    about_trim = hit.scale * np.radians(angle_deg) - hit.trim
    for j in given.targets[entry.surface]:
        low, high = given.stops_rad[j]
        if not low - 1e-9 <= about_trim[j] <= high + 1e-9:
            stops = np.degrees(hit.sense[j] * (hit.trim[j] + given.stops_rad[j]))
            line = f"{given.effectors[j]} has its stops at {min(stops):.4g} and {max(stops):.4g} deg, where it stays"
            return [(key, f"{angle_deg:g} is beyond a stop: {line}")]
    return []


@law
def put(s, e, deflection):
    """Put the effector where a fault has it; nan stays nan. `s.most` keeps how far the fault moved it, rad."""
    before = e.deflection
    e.deflection = deflection + 0.0 * before
    s.most = max(s.most, abs(e.deflection - before))
