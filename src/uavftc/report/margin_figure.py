"""The margin against each quantity that `uavftc margin` varied."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uavftc.report import palette, panels
from uavftc.report.margin_text import Entry, name_of
from uavftc.results.single import figure_metadata, write_single

FAR_APART = 30.0
"""Greatest over least value, both above 0, from which on an axis is logarithmic."""


def write_limits_figure(file: Path, title: str, entries: Sequence[Entry]) -> None:
    """Draw the margin against each quantity to a PNG file: one line a controller, the limit where it crosses 0."""
    with panels.style():
        figure = limits_figure(title, entries)
        write_single(file, lambda partial: figure.savefig(partial, metadata=figure_metadata(file.suffix)))


def limits_figure(title: str, entries: Sequence[Entry]) -> Figure:
    """Return the figure; broken is below 0, a vehicle lost at -1 or below is on grey."""
    names = list(dict.fromkeys(name_of(entry) for entry in entries))
    looks = palette.controllers(list(dict.fromkeys(entry["controller"] for entry in entries)))
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    fig = Figure(figsize=(max(4.6 * columns, 7.5), 3.4 * rows + 1.2), layout="constrained")
    axes = fig.subplots(rows, columns, squeeze=False, sharey=True)
    for ax, name in zip(axes.flat, names, strict=False):
        _panel(ax, name, [entry for entry in entries if name_of(entry) == name], looks)
    for ax in list(axes.flat)[len(names) :]:
        ax.set_visible(False)
    for row in axes:
        row[0].set_ylabel("margin")
    lines, labels = axes[0][0].get_legend_handles_labels()
    fig.legend(lines, labels, loc="outside lower center", ncols=min(len(labels), 6), frameon=False)
    fig.suptitle(f"{title}\nmargin of the verdict: below 0 broken, grey: lost", fontsize=12, parse_math=False)
    return fig


def _panel(ax: Axes, name: str, entries: Sequence[Entry], looks: Mapping[str, dict[str, Any]]) -> None:
    for entry in entries:
        values, margins = zip(*sorted(entry["curve"]), strict=True)
        ax.plot(values, margins, **looks[entry["controller"]], markersize=4, linewidth=1.5, label=entry["controller"])
    flown = sorted({value for entry in entries for value, _ in entry["curve"]})
    positive = [value for value in flown if value > 0.0]
    if positive and positive[-1] / positive[0] >= FAR_APART:
        if flown[0] <= 0.0:
            ax.set_xscale("symlog", linthresh=positive[0])
        else:
            ax.set_xscale("log")
    ax.axhline(0.0, color=palette.DARK, linewidth=0.9)
    ax.axhspan(-2.05, -1.0, color="#ebebeb", zorder=0)
    ax.set(xlabel=name, ylim=(-2.05, 1.05))
