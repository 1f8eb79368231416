"""What changes about a plant between two rows of a flight: damage that begins or ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.core.program import Program

Fly = Callable[[Program, np.ndarray, int, int], int]
"""fly(program, rows, first, last): as `Plant.run`."""
Change = Callable[[], None]
NEVER = 2**53
"""A row that no flight reaches; beyond it a double cannot tell one row from the next."""


class Struck(NamedTuple):
    """A damage that a plant itself feels, not only its effectors."""

    entry: Any
    """Of the scenario's `damage`."""
    first: int
    """Row at which it begins."""
    end: int | None
    """Row at which it has ended, or None."""


def struck_by(damage: Sequence[Any], rate_hz: float) -> tuple[Struck, ...]:
    """Return the damages that change mass, forces or moments, with their rows at a sample rate, Hz."""
    felt = [entry for entry in damage if entry.changes_mass or entry.acts]
    rows = [(row_at(e.start_s, rate_hz), None if e.end_s is None else row_at(e.end_s, rate_hz)) for e in felt]
    # a window between two samples is none
    return tuple(Struck(e, first, end) for e, (first, end) in zip(felt, rows, strict=True) if first != end)


def row_at(time_s: float, rate_hz: float) -> int:
    """Return the first row k at or after a time, s, with the samples at k / rate; NEVER where that is beyond it."""
    if time_s * rate_hz >= NEVER:
        return NEVER
    k = max(0, math.ceil(time_s * rate_hz) - 1)
    while k / rate_hz < time_s:
        k += 1
    return k


class Schedule:
    """Changes of a plant, each before it moves on from a row; those of one row in the order given."""

    def __init__(self, changes: Iterable[tuple[int | None, Change]]) -> None:
        due = [(row, change) for row, change in changes if row is not None]
        due.sort(key=lambda item: item[0])
        self._due = due[::-1]
        self._flown = 0

    def fly(self, fly: Fly, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        """Fly rows `first` to `last - 1`, which are the next of the flight, as `Plant.run`."""
        offset, k = self._flown - first, first
        while k < last:
            while self._due and self._due[-1][0] <= k + offset:
                self._due.pop()[1]()
            until = min(last, self._due[-1][0] - offset) if self._due else last
            done = fly(program, rows, k, until)
            if done < until:
                self._flown = done + offset
                return done
            k = until
        self._flown = last + offset
        return last
