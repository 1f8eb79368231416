"""The dense part of the reward: the margin of the worst requirement at a sample.

Of each requirement of the kind `always` whose window holds the sample, the robustness of its formula there, compressed
as a verdict's (`analysis/requirements.py`): at most 1, 0 at the limit, above -1. `eventually` says nothing of a sample;
it counts in the verdict at the end.

The formulas are those of the verdict. Signals are read from the row one number at a time here, where a verdict takes
chunks of rows; what is no plain column is taken as the verdict takes it, from a chunk of one row.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from uavftc.analysis.derived import IN_DEGREES, Source, Window
from uavftc.analysis.requirements import margin_of
from uavftc.config.formula import Formula
from uavftc.core.signals import ROW, Column
from uavftc.flight.build import Flight

Reader = Callable[[list[float], np.ndarray], float]
"""A signal at a sample: of the numbers of its row, and of its record, shape (1,)."""

ANGLES = ("phi", "theta", "psi")
_AT = {name: ROW.fields[name][1] // 8 for name in ROW.names or ()}  # type: ignore[index]
_TURN = 2.0 * math.pi


class StepMargin:
    """The margin of each sample of a flight, asked in their order.

    Parameters
    ----------
    flight
        What is flown.
    """

    def __init__(self, flight: Flight) -> None:
        self._columns = {column.name: column for column in flight.columns}
        self._asked: list[tuple[Formula, float | None, int, float, int]] = []
        self._readers: dict[int, dict[str, Reader]] = {}
        for one in flight.requirements:
            if not one.always:
                continue
            readers = self._readers.setdefault(one.window.rows, {})
            for name in one.formula.names:
                if name not in readers:
                    known = flight.signals[name]
                    readers[name] = self._reader(name, one.window) or _by_source(known.make(one.window))
            last = math.inf if one.last is None else float(one.last)
            self._asked.append((one.formula, one.scale, one.first, last, one.window.rows))

    def __call__(self, k: int, record: np.ndarray, row: np.ndarray) -> float:
        """Return the margin at sample `k`: of its record, shape (1,), and the same as numbers, shape (width,).

        It is 1 where no requirement asks anything of the sample.
        """
        numbers = row.tolist()
        seen = {
            window: {name: reader(numbers, record) for name, reader in readers.items()}
            for window, readers in self._readers.items()
        }
        worst = math.inf
        for formula, scale, first, last, window in self._asked:
            if first <= k <= last:
                worst = min(worst, formula.at(seen[window], scale))
        return margin_of(worst) if worst < 1.0 else 1.0

    def _reader(self, name: str, window: Window) -> Reader | None:
        """Return what reads a plain column, an error or a travel, or one of these in degrees; None of another."""
        stem, _, unit = name.rpartition("_")
        for radians, degrees in IN_DEGREES.items():
            if unit == degrees and (inner := self._reader(f"{stem}_{radians}", window)) is not None:
                return _turned(inner)
        if stem.endswith("_error") and unit == "rad" and stem.removesuffix("_error") in ANGLES:
            return _error(ANGLES.index(stem.removesuffix("_error")))
        if (
            stem.endswith("_travel")
            and unit == "radps"
            and (of := self._reader(f"{stem[:-7]}_rad", window)) is not None
        ):
            return _Travel(of, window)
        column = self._columns.get(name)
        if column is None or not _is_plain(column):
            return None
        at, sign = _AT[column.field] + (column.component or 0), column.sign
        return (lambda numbers, _: numbers[at]) if sign == 1.0 else (lambda numbers, _: sign * numbers[at])


def _is_plain(column: Column) -> bool:
    own = (column.effector, column.engine, column.weights)
    return own == (None, None, None) and column.field in _AT and not column.name.startswith("psi")


def _turned(inner: Reader) -> Reader:
    factor = math.degrees(1.0)
    return lambda numbers, record: factor * inner(numbers, record)


def _error(axis: int) -> Reader:
    reference, angle = _AT["x1_c"] + axis, _AT["x1"] + axis
    if axis < 2:
        return lambda numbers, _: numbers[reference] - numbers[angle]

    def heading(numbers: list[float], _: np.ndarray) -> float:
        near = numbers[angle] - _TURN * round((numbers[angle] - numbers[reference]) / _TURN)
        return numbers[reference] - near

    return heading


class _Travel:
    """How far a signal went in the window behind a sample, over its length: `derived.Behind`, number by number."""

    def __init__(self, of: Reader, window: Window) -> None:
        self._of, self._factor = of, 1.0 / window.length_s
        self._sums = deque([0.0] * window.rows, maxlen=window.rows)
        self._last: float | None = None

    def __call__(self, numbers: list[float], record: np.ndarray) -> float:
        value = self._of(numbers, record)
        total = self._sums[-1] + abs(value - (value if self._last is None else self._last))
        self._last, behind = value, self._sums[0]
        self._sums.append(total)
        return self._factor * (total - behind)


def _by_source(source: Source) -> Reader:
    return lambda _, record: float(source.take(record)[0])
