"""The figure of a custom controller's own signals: one panel for each, a vector in one, with its unit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uavftc.core.layout import OwnSignal
from uavftc.report import panels, series
from uavftc.report.drawn import Drawn, History
from uavftc.report.palette import SEVERAL
from uavftc.report.strip import mark, new_figure
from uavftc.results.context import FigureContext

_MAX_LABELS = 6  # of a panel's legend; a longer vector is drawn without
_CHARACTERS, _SAMPLE = 110, 5  # of a whole row of panels; taken by a curve next to its label
_SHOWN = {
    "1": "-", "rad": "deg", "rad/s": "deg/s", "rad/s^2": "deg/s$^2$", "deg/s^2": "deg/s$^2$", "m/s^2": "m/s$^2$",
    "1/s^2": "1/s$^2$", "kg m^2": "kg m$^2$",
}  # fmt: skip
"""Units as a panel has them; angles are drawn in degrees, as in the other figures."""


def custom(history: History, context: FigureContext) -> Figure:
    """Draw each signal over time, with all windows shaded; two panels a row of more than two signals."""
    signals, flight = context.signals, Drawn(history, context)
    columns = 1 if len(signals) <= 2 else 2
    rows = -(-len(signals) // columns)
    fig, axes = new_figure(context, flight.t, rows, columns, (11.0, 1.4 + 2.6 * rows))
    for k, signal in enumerate(signals):
        ax = axes[k // columns, k % columns]
        _draw(ax, flight, signal, room=_CHARACTERS // columns)
        mark(ax, context, *(name for window in context.windows for name in window.concerns))
    if len(signals) < axes.size:
        axes[-1, -1].set_visible(False)
        axes[-2, -1].tick_params(labelbottom=True)
    panels.legend(fig, axes)
    return fig


def _draw(ax: Axes, flight: Drawn, signal: OwnSignal, room: int) -> None:
    """Draw one signal, with the labels of a vector next to its title where there is room for so many characters."""
    drawn: list[np.ndarray] = []
    curves: list[Artist] = []
    for i, name in enumerate(signal.columns):
        look = dict(SEVERAL[i % len(SEVERAL)])
        if signal.labels:
            look["label"] = signal.labels[i].replace("_", " ")
        drawn += flight.curve(ax, _shown(name, signal.unit), **look)
        curves.append(ax.lines[-1])
    if not any(np.isfinite(values).any() for values in drawn):
        panels.absent(ax, "the controller returned none")
    found = series.finite(drawn)
    size = float(np.abs(found).max()) if found.size else 1.0
    if size == 0.0:
        panels.note(ax, "0 all flight", height=0.7)
    panels.fit_y(ax, drawn, least=max(1e-3 * size, 1e-12))
    title = signal.name.replace("_", " ")
    ax.set_title(title, parse_math=False)
    ax.set_ylabel(f"[{_SHOWN.get(signal.unit, signal.unit)}]")
    if 1 < len(signal.labels) <= _MAX_LABELS:
        room -= len(title)
        panels.title_legend(ax, curves, max(1, room // (_SAMPLE + max(map(len, signal.labels)))))


def _shown(name: str, unit: str) -> Callable[[History], np.ndarray]:
    read = series.deg if unit.startswith("rad") else series.column
    return lambda history: read(history, name)
