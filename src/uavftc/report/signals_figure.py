"""The figure of a custom controller's own signals: one panel for each, a vector in one, with its unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uavftc.core.layout import OwnSignal
from uavftc.report import panels
from uavftc.report.panels import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION
from uavftc.results.context import FigureContext

_COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
_DASHES = ("-", "--", "-.", ":")
_MAX_LABELS = 6  # of a panel's legend; a longer vector is drawn without
_CHARACTERS, _SAMPLE = 110, 5  # of a whole row of panels; taken by a curve next to its label
_LARGEST = 1e9  # beyond it, the end of a diverged flight is not drawn: it would overflow the axes
_SHOWN = {
    "1": "-", "rad": "deg", "rad/s": "deg/s", "rad/s^2": "deg/s$^2$", "deg/s^2": "deg/s$^2$", "m/s^2": "m/s$^2$",
    "1/s^2": "1/s$^2$", "kg m^2": "kg m$^2$",
}  # fmt: skip
"""Units as a panel has them; angles are drawn in degrees, as in the other figures."""


def custom(
    history: Mapping[str, np.ndarray], context: FigureContext, faults: Sequence[tuple[float, float, str]]
) -> Figure:
    """Draw each signal over time, with the windows of faults shaded; two panels a row of more than two signals."""
    signals, t = context.signals, history["time_s"]
    columns = 1 if len(signals) <= 2 else 2
    rows = -(-len(signals) // columns)
    fig, axes = panels.new_figure(context.title, rows, columns, (11.0, 1.4 + 2.6 * rows))
    panels.fit_t(axes[0, 0], t)
    for k, signal in enumerate(signals):
        ax = axes[k // columns, k % columns]
        _draw(ax, history, signal, room=_CHARACTERS // columns)
        panels.shade(ax, faults, name="fault", written=False)
    if len(signals) < axes.size:
        axes[-1, -1].set_visible(False)
        axes[-2, -1].tick_params(labelbottom=True)
    return fig


def _draw(ax: Axes, history: Mapping[str, np.ndarray], signal: OwnSignal, room: int) -> None:
    """Draw one signal, with the labels of a vector next to its title where there is room for so many characters."""
    angle = signal.unit.startswith("rad")
    drawn = []
    for i, (name, colour) in enumerate(zip(signal.columns, cycle(_COLOURS), strict=False)):
        values = history.get(name, np.full(len(history["time_s"]), np.nan))
        values = np.where(np.abs(values) < _LARGEST, values, np.nan)
        look = {"color": colour, "linestyle": _DASHES[i % len(_DASHES)]}
        if signal.labels:
            look["label"] = signal.labels[i].replace("_", " ")
        drawn.append(panels.curve(ax, history["time_s"], np.rad2deg(values) if angle else values, **look))
    if not any(np.isfinite(values).any() for values in drawn):
        panels.absent(ax, "the controller returned none")
    finite = np.concatenate(drawn)
    finite = finite[np.isfinite(finite)]
    size = float(np.abs(finite).max()) if finite.size else 1.0
    panels.fit_y(ax, drawn, least=max(1e-3 * size, 1e-12))
    title = signal.name.replace("_", " ")
    ax.set_title(title, parse_math=False)
    ax.set_ylabel(f"[{_SHOWN.get(signal.unit, signal.unit)}]")
    if 1 < len(signal.labels) <= _MAX_LABELS:
        room -= len(title)
        per_row = max(1, room // (_SAMPLE + max(map(len, signal.labels))))
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderaxespad": 0.1}
        ax.legend(ncols=per_row, fontsize="small", columnspacing=1.2, handlelength=1.8, **place)
