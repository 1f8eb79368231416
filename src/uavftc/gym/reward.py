"""The dense part of the reward: the margin of the worst requirement at a sample.

Of each requirement of the kind `always` whose window holds the sample, the robustness of its formula there, compressed
as a verdict's (`analysis/requirements.py`): at most 1, 0 at the limit, above -1; 1 where nothing is asked. `eventually`
says nothing of a sample; it counts in the verdict at the end. The formulas are those of the verdict, run by
`machine.py`, and the signals those of `analysis/derived.py`.
"""

from __future__ import annotations

import math

import numpy as np

from uavftc.analysis.derived import IN_DEGREES, Window
from uavftc.core.signals import ANGLES, EFFECTOR, ENGINE, SURFACES, Column, row_type
from uavftc.flight.build import Flight
from uavftc.gym.machine import ASK, DEPTH, GROW, HEADING, ROW, SYMBOLS, Code, code, judge


class Margins:
    """The margins of the samples of a flight, asked in their order.

    Parameters
    ----------
    flight
        What is flown.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._row = row_type(flight.shape)
        self._columns = {column.name: column for column in flight.columns}
        self._memory: list[float] = []
        steps: list[tuple[float, float, float]] = []
        for one in flight.requirements:
            if one.always:
                values = {name: self._signal(name, one.window) for name in one.formula.names}
                steps += one.formula.made_of(SYMBOLS)(values, one.scale).steps
                steps.append((ASK, float(one.first), math.inf if one.last is None else float(one.last)))
        self._table = np.array(steps, dtype=float).reshape(-1, 3)
        self._kept = np.array(self._memory)
        self._stack, self._judge = np.zeros(DEPTH), judge()

    def __call__(self, rows: np.ndarray, first: int, last: int) -> float:
        """Return the sum of the margins at samples `first` to `last - 1`, of rows of shape (n, width)."""
        return self._judge(self._table, self._kept, self._stack, rows, first, last)

    def _signal(self, name: str, window: Window) -> Code:
        """Return the code of a signal: of a column, or of one derived as `analysis/derived.py` says."""
        stem, _, unit = name.rpartition("_")
        for radians, degrees in IN_DEGREES.items():
            if unit == degrees and f"{stem}_{radians}" in self._flight.signals:
                return code(math.degrees(1.0)) * self._signal(f"{stem}_{radians}", window)
        if name == "t":
            return self._at("t")
        if stem.endswith("_error") and (angle := stem.removesuffix("_error")) in ANGLES:
            i = ANGLES.index(angle)
            return self._at("x1_c", i) - (self._heading("x1") if i == 2 else self._at("x1", i))
        if stem.endswith("_travel"):
            return self._grow(self._column(self._columns[f"{stem.removesuffix('_travel')}_rad"]), window,
                              (math.nan, math.nan), 1.0 / window.length_s)  # fmt: skip
        if name.endswith("_saturated_share"):
            axis = SURFACES.index(name.removesuffix("_saturated_share"))
            least, greatest = self._flight.given.design.limits_rad[axis]
            return self._grow(self._at("v2", axis), window, (float(least), float(greatest)), 1.0 / window.rows)
        return self._column(self._columns[name])

    def _column(self, column: Column) -> Code:
        """Return the code of a column of the history, as `signals.column` reads it."""
        if column.name in ("psi_rad", "psi_meas_rad"):
            return self._heading(column.field)
        if column.effector is not None:
            at = self._place("effectors") + (column.effector * EFFECTOR.itemsize + _offset(EFFECTOR, column.field)) // 8
            return code(column.sign) * (code(column.offset) + Code(((ROW, float(at), 0.0),)))
        if column.engine is not None:
            at = self._place("engines") + (column.engine * ENGINE.itemsize + _offset(ENGINE, column.field)) // 8
            return Code(((ROW, float(at), 0.0),))
        if column.weights is not None:
            parts = [code(weight) * self._at(column.field, i) for i, weight in enumerate(column.weights)]
            return sum(parts, code(0.0))
        plain = self._at(column.field, column.component or 0)
        return plain if column.sign == 1.0 else code(column.sign) * plain

    def _place(self, field: str) -> int:
        return _offset(self._row, field) // 8

    def _at(self, field: str, component: int = 0) -> Code:
        return Code(((ROW, float(self._place(field) + component), 0.0),))

    def _heading(self, field: str) -> Code:
        return Code(((HEADING, float(self._place(field) + 2), float(self._place("x1_c") + 2)),))

    def _grow(self, value: Code, window: Window, limits: tuple[float, float], factor: float) -> Code:
        """Return the code of what a sum over a signal grows by in a window, with a memory of its own."""
        at = len(self._memory)
        self._memory += [float(window.rows), math.nan, *limits, 0.0, 0.0, *[0.0] * window.rows]
        return Code((*value.steps, (GROW, float(at), factor)))


def _offset(dtype: np.dtype, field: str) -> int:
    fields = dtype.fields
    assert fields is not None
    return int(fields[field][1])
