"""The curves of one flight: each with the unfaulted twin's beneath it, and what is measured where that differs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from uavftc.report import panels, series
from uavftc.report.chatter import chatter
from uavftc.report.palette import MEASURED, TWIN
from uavftc.results.context import FigureContext

History = Mapping[str, np.ndarray]
Read = Callable[[History], np.ndarray]


class Drawn:
    """What draws the curves of a flight."""

    def __init__(self, history: History, context: FigureContext) -> None:
        self.history = history
        self.t = history["time_s"]
        self._twin = context.twin
        self._measured = "sensor" in context.has

    def curve(self, ax: Axes, read: Read, *, turn: float | None = None, **look: Any) -> list[np.ndarray]:
        """Draw what `read` makes of the columns over the time, beneath it that of the twin; return both.

        `turn` is that of `panels.curve`, the rest is how the curve looks.
        """
        return [*self._of_twin(ax, read, turn), panels.curve(ax, self.t, read(self.history), turn=turn, **look)]

    def busy(self, ax: Axes, read: Read, **look: Any) -> list[np.ndarray]:
        """Draw as `curve` does, but where it chatters its mean over a band."""
        return [*self._of_twin(ax, read), chatter(ax, self.t, read(self.history), **look)]

    def _of_twin(self, ax: Axes, read: Read, turn: float | None = None) -> list[np.ndarray]:
        if self._twin is None:
            return []
        return [panels.curve(ax, self._twin["time_s"], read(self._twin), turn=turn, label=panels.WITHOUT, **TWIN)]

    def measured(self, ax: Axes, name: str, *, turn: float | None = None) -> list[np.ndarray]:
        """Draw a measured angle or rate, deg or deg/s, where the sensors have errors; return it."""
        if not self._measured or name not in self.history:
            return []
        values = series.deg(self.history, name)
        if turn is not None:
            return [panels.curve(ax, self.t, values, turn=turn, label="as measured", **MEASURED)]
        return [chatter(ax, self.t, values, label="as measured", **MEASURED)]
