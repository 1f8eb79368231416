"""The positions of surfaces that JSBSim moves by itself: read at each sample, and what their axes get from them.

Position and deflection of row k are what the command of row k brings about by t_k + h, as of every other effector. The
program has written into row k what was read at t_k, which belongs to the row before.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.layout import shares
from uavftc.core.signals import EFFECTOR, ROW, ROW_WIDTH
from uavftc.plants.jsbsim.model import TrimmedModel

_WIDTH = EFFECTOR.itemsize // 8
_POSITION, _DEFLECTION = (EFFECTOR.fields[name][1] // 8 for name in ("position", "deflection"))  # type: ignore[index]
_U2 = ROW.fields["u2"][1] // 8  # type: ignore[index]


class Followed:
    """Those effectors of a trimmed model whose position is read."""

    def __init__(self, model: TrimmedModel) -> None:
        effectors, mixing = model.effectors, np.array(model.mixing)
        self.read = np.array([not e.ideal and e.position is not None for e in effectors])
        """Whether the position of each effector is read, shape (n,)."""
        self.any = bool(self.read.any())
        first = [ROW_WIDTH + j * _WIDTH for j in range(len(effectors))]
        self._own = [(j, first[j] + _POSITION, e.position_rad) for j, e in enumerate(effectors) if self.read[j]]
        share = shares(mixing)
        self._axes: list[tuple[int, list[tuple[int, float]], float]] = []
        """Of each axis that a read effector serves: column of u2, columns and shares of its effectors, their trim."""
        for i in np.flatnonzero(mixing[self.read].any(axis=0)):
            members = [j for j in range(len(effectors)) if share[j, i] != 0.0]
            columns = [(first[j] + (_POSITION if self.read[j] else _DEFLECTION), float(share[j, i])) for j in members]
            trim = sum(float(share[j, i]) * effectors[j].trim_rad for j in members if self.read[j])
            self._axes.append((_U2 + int(i), columns, trim))

    def take(self, rows: np.ndarray, first: int, done: int, last: int, last_read: np.ndarray) -> None:
        """Put the positions of rows `first` to `done` - 1 where they belong, and what their axes get.

        Columns of the rows, not records: it is called every 256 rows or more often, and a dtype costs 30 us.

        Parameters
        ----------
        rows, last
            Rows of a chunk, to be flown up to `last` - 1; if the flight ended before, row `done` keeps the position at
            its time.
        last_read
            What was read after the last of these rows, shape (n,), in units of the properties.
        """
        if last == first + 1:
            self._take_one(rows[first], last_read if done > first else None)
            return
        if done > first:
            for j, column, rad in self._own:
                rows[first : done - 1, column] = rows[first + 1 : done, column]
                rows[done - 1, column] = rad * last_read[j]
        part = rows[first : min(done + 1, last)]
        for u2, ((column, share), *more), trim in self._axes:
            total = share * part[:, column]
            for column, share in more:  # noqa: PLW2901 - few, and each is done with
                total += share * part[:, column]
            part[:, u2] = total - trim

    def _take_one(self, row: np.ndarray, read: np.ndarray | None) -> None:
        """Do the same for one row alone, number by number: of arrays of one it takes five times as long."""
        if read is not None:
            for j, column, rad in self._own:
                row[column] = rad * read[j]
        for u2, ((column, share), *more), trim in self._axes:
            total = share * row[column]
            for column, share in more:  # noqa: PLW2901 - few, and each is done with
                total += share * row[column]
            row[u2] = total - trim
