"""The positions of surfaces that JSBSim moves by itself: read at each sample, and what their axes get from them.

Position and deflection of row k are what the command of row k brings about by t_k + h, as of every other effector. The
program has written into row k what was read at t_k, which belongs to the row before.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.layout import shares
from uavftc.core.signals import as_records
from uavftc.plants.jsbsim.model import TrimmedModel


class Followed:
    """Those effectors of a trimmed model whose position is read."""

    def __init__(self, model: TrimmedModel) -> None:
        effectors, mixing = model.effectors, np.array(model.mixing)
        self.read = np.array([not e.ideal and e.position is not None for e in effectors])
        """Whether the position of each effector is read, shape (n,)."""
        self.any = bool(self.read.any())
        self._own = np.flatnonzero(self.read)
        self._rad = np.array([e.position_rad for e in effectors])
        self._trim = np.array([e.trim_rad for e in effectors])
        self._shares = shares(mixing)
        self._axes = np.flatnonzero(mixing[self.read].any(axis=0))

    def take(self, rows: np.ndarray, first: int, done: int, last_read: np.ndarray) -> None:
        """Put the positions of rows `first` to `done` - 1 where they belong, and what their axes get.

        Parameters
        ----------
        rows
            Rows of a chunk; in row `done`, if the flight ended at it, is the position at its time, and it stays.
        last_read
            What was read after the last of these rows, shape (n,), in units of the properties.
        """
        end = min(done + 1, len(rows))
        records = as_records(rows[first:end])
        effectors, n = records["effectors"], done - first
        for j in self._own:
            position = effectors["position"][:, j]
            if n:
                position[: n - 1] = position[1:n].copy()
                position[n - 1] = self._rad[j] * last_read[j]
        moved = effectors["deflection"].copy()
        moved[:, self._own] = effectors["position"][:, self._own] - self._trim[self._own]
        for i in self._axes:
            records["u2"][:, i] = moved @ self._shares[:, i]
