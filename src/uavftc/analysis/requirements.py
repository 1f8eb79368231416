"""Requirements on a flight, and how far each was from being broken: robustness, computed while the flight goes by.

With rho(t) the robustness of a formula at a sample (`config/formula.py`), over the samples t of [from, to]:

    always        min rho(t)
    eventually    max over t of  min of rho over [t, t + hold]

after A. Donze and O. Maler, "Robust satisfaction of temporal logic over real-valued signals", FORMATS 2010, in discrete
time; a hold that the end of the flight cuts short does not count. The margin of a requirement is m(rho):

    m = min(1, rho) for rho >= 0        m = rho/(1 + |rho|) for rho < 0, and above -1

so that it is at most 1, 0 at the limit and above -1, and still falls where rho falls. Memory does not grow with the
flight, and chunks change no bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from uavftc.analysis.derived import Known, Source, Window
from uavftc.config.formula import Formula

LEAST = math.nextafter(-1.0, 0.0)
"""The lowest margin of a flight that reached its end."""


class Requirement(NamedTuple):
    """One requirement, in rows of the flight."""

    name: str
    formula: Formula
    first: int = 0
    """First row that counts."""
    last: int | None = None
    """Last row that counts, or at which a hold may begin; None is the end of the flight."""
    always: bool = True
    """Else eventually."""
    hold: int = 0
    """Steps that it must hold on, of `eventually`."""
    scale: float | None = None
    """Of every comparison; None is |limit| of each."""
    window: Window = Window(400, 2.0)
    """Of the signals that look back."""


class Met(NamedTuple):
    """How a requirement fared."""

    name: str
    margin: float | None
    """None where the flight ended before it could be judged."""
    met: bool
    at_s: float | None
    """When it was nearest to its limit, or furthest beyond; of `eventually`, when it was best."""


def margin_of(robustness: float) -> float:
    """Return the margin of a robustness: at most 1, 0 at the limit, above -1."""
    if robustness >= 0.0:
        return min(1.0, robustness)
    return max(LEAST, robustness / (1.0 - robustness)) if math.isfinite(robustness) else LEAST


class _Judge(Protocol):
    """The robustness of a requirement, from that of its formula, shape (n,), at successive rows."""

    def take(self, first: int, robustness: np.ndarray) -> None: ...

    def found(self) -> tuple[float, int] | None:
        """Return robustness and row, or None while nothing counted."""


class _Always:
    def __init__(self, first: int, last: int | None) -> None:
        self._first, self._last = first, last
        self._found: tuple[float, int] | None = None

    def take(self, first: int, robustness: np.ndarray) -> None:
        begin = max(0, self._first - first)
        piece = robustness[begin : None if self._last is None else max(0, self._last + 1 - first)]
        if len(piece):
            at = int(np.argmin(piece))
            if self._found is None or piece[at] < self._found[0]:
                self._found = float(piece[at]), first + begin + at

    def found(self) -> tuple[float, int] | None:
        return self._found


class _Eventually:
    def __init__(self, first: int, last: int | None, hold: int) -> None:
        self._first, self._last, self._hold = first, last, hold
        self._tail = np.empty(0)  # rows whose hold has not ended yet
        self._found: tuple[float, int] | None = None

    def take(self, first: int, robustness: np.ndarray) -> None:
        from scipy.ndimage import minimum_filter1d  # noqa: PLC0415 - most flights have none

        rows = np.concatenate([self._tail, robustness])
        begins = first - len(self._tail)  # the row of rows[0]
        n = len(rows) - self._hold  # of these the hold has ended
        self._tail = rows[max(0, n) :]
        if n <= 0:
            return
        size = self._hold + 1
        held = rows if size == 1 else minimum_filter1d(rows, size, origin=-(size // 2))[:n]
        begin = max(0, self._first - begins)
        piece = held[begin : None if self._last is None else max(0, self._last + 1 - begins)]
        if len(piece):
            at = int(np.argmax(piece))
            if self._found is None or piece[at] > self._found[0]:
                self._found = float(piece[at]), begins + begin + at

    def found(self) -> tuple[float, int] | None:
        return self._found


class Monitor:
    """The requirements of a flight, from chunks of its rows in order: a recorder.

    Parameters
    ----------
    requirements
        What is asked.
    known
        Every signal that they name, at least.
    rate_hz
        Of the rows.
    """

    def __init__(self, requirements: Sequence[Requirement], known: Mapping[str, Known], rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._rows = 0
        self._sources: dict[tuple[str, Window | None], Source] = {}
        self._asked: list[tuple[Requirement, dict[str, tuple[str, Window | None]], _Judge]] = []
        for one in requirements:
            keys = {name: (name, one.window if known[name].windowed else None) for name in one.formula.names}
            for name, key in keys.items():
                if key not in self._sources:
                    self._sources[key] = known[name].make(one.window)
            judge: _Judge = _Always(one.first, one.last) if one.always else _Eventually(one.first, one.last, one.hold)
            self._asked.append((one, keys, judge))

    def take(self, records: np.ndarray) -> None:
        """Judge the next rows, shape (n,), dtype `signals.ROW`."""
        if not len(records):
            return
        values = {key: source.take(records) for key, source in self._sources.items()}
        for one, keys, judge in self._asked:
            rho = one.formula.robustness({name: values[key] for name, key in keys.items()}, one.scale)
            judge.take(self._rows, np.broadcast_to(rho, (len(records),)))
        self._rows += len(records)

    def robustness(self) -> dict[str, float | None]:
        """Return the robustness of each requirement so far, not compressed; None where nothing counted yet."""
        return {one.name: found[0] if (found := judge.found()) else None for one, _, judge in self._asked}

    def found(self) -> list[Met]:
        """Return how each requirement fared so far."""
        result = []
        for one, _, judge in self._asked:
            if (found := judge.found()) is None:
                result.append(Met(one.name, None, False, None))
            else:
                rho, row = found
                result.append(Met(one.name, margin_of(rho), rho >= 0.0, row / self._rate_hz))
        return result
