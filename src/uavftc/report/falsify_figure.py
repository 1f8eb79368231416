"""How a search for failures went: margin and distance flight by flight, and the fault that was found in its ranges.

Importing this module imports matplotlib (0.7 s), so import it where the figure is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from uavftc.report import panels
from uavftc.report.falsify_text import searched, short
from uavftc.report.palette import BLACK, BLUE, DARK, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION
from uavftc.results.single import figure_metadata, write_single

STAGES = {
    "nominal": ("nominal", BLACK, "*"),
    "start": ("Sobol points", GREY, "o"),
    "cma": ("CMA-ES", BLUE, "^"),
    "ray": ("bisection of a ray", ORANGE, "s"),
    "reset": ("keys back to nominal", SKY, "D"),
    "plane": ("plane of margins", PURPLE, "P"),
}
LOWEST = -2.05
FEW = 8
"""Keys, as if there were at least so many: bars of a few are no thicker."""


def write_falsify_figure(file: Path, title: str, rows: Sequence[Mapping[str, Any]], one: Mapping[str, Any]) -> None:
    """Draw one search to a PNG file, from the rows of its trace and its entry in `summary.json`."""
    with panels.style():
        figure = falsify_figure(title, rows, one)
        write_single(file, lambda partial: figure.savefig(partial, metadata=figure_metadata(file.suffix)))


def falsify_figure(title: str, rows: Sequence[Mapping[str, Any]], one: Mapping[str, Any]) -> Figure:
    """Return the figure of one search."""
    shown, what = (one["found"], "the failure found") if one["found"] else (one["lowest"], "the lowest margin")
    keys = [] if shown is None else list(shown["values"])
    fig = Figure(figsize=(15.0, 1.9 + max(7.0, 0.42 * len(keys) + 2.2)), layout="constrained")
    fig.get_layout_engine().set(w_pad=0.12, h_pad=0.1)  # type: ignore[union-attr, call-arg]
    fig.suptitle(f"{title}\n{_head(one)}", fontsize=14, fontweight="bold", parse_math=False)
    left, right = np.ravel(np.array(fig.subfigures(1, 2)))
    margin, distance = left.subplots(2, 1, sharex=True, height_ratios=[1.3, 1.0])
    _margins(margin, rows)
    _distances(distance, rows)
    handles, labels = margin.get_legend_handles_labels()
    left.legend(handles, labels, loc="outside lower center", ncols=3)
    ax = right.subplots()
    ax.set_title(f"(c) {what}, in the ranges of the campaign")
    if shown is None:
        panels.absent(ax, "no flight could be flown")
    else:
        _fault(ax, keys, shown, one["base"])
    return fig


def _head(one: Mapping[str, Any]) -> str:
    found = one["found"]
    if found is None:
        return f"nothing found that breaks it in {searched(one)}"
    return (
        f"{found['outcome']}, margin {found['margin']:.3g} ({found['limiting']}), {found['distance']:.3g} from nominal"
    )


def _margins(ax: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """Draw the margin of each flight by its stage, and the lowest so far."""
    flown = [row for row in rows if row["margin"] is not None]
    number = np.array([row["flight"] + 1 for row in flown])
    margins = np.array([row["margin"] for row in flown], dtype=float)
    for stage, (label, colour, marker) in STAGES.items():
        here = np.array([row["stage"] == stage for row in flown], dtype=bool)
        if here.any():
            size = 11 if stage == "nominal" else 4
            look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": size, "linestyle": "none"}
            ax.plot(number[here], margins[here], label=label, alpha=0.75, markeredgewidth=0, **look)
    if flown:
        lowest = np.minimum.accumulate(margins)
        ax.step(number, lowest, where="post", color=VERMILLION, linewidth=1.8, label="lowest so far")
    ax.axhline(0.0, color=DARK, linewidth=0.9)
    if flown and margins.min() <= -1.0:
        ax.axhspan(LOWEST, -1.0, color="#ebebeb", zorder=0)
        ax.text(0.995, 0.03, "lost", transform=ax.transAxes, ha="right", color=DARK)
    low = float(margins.min()) if flown else 0.0
    ax.set_ylim(LOWEST if low <= -1.0 else min(low, 0.0) - 0.12, 1.05)
    ax.set_title("(a) margin: below 0 broken")
    ax.set_ylabel("margin")


def _distances(ax: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """Draw how far each failure is from nominal, and the nearest so far."""
    failed = [row for row in rows if row["outcome"] not in ("survived", "error")]
    number = np.array([row["flight"] + 1 for row in failed])
    far = np.array([row["distance"] for row in failed], dtype=float)
    ax.set_title("(b) distance of each failure from nominal, in ranges")
    ax.set_xlabel("flight")
    ax.set_xlim(0.0, len(rows) + 1.0)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    if not failed:
        panels.absent(ax, "no failure")
        return
    ax.plot(number, far, color=DARK, marker="o", markersize=4, linestyle="none", alpha=0.6, markeredgewidth=0)
    near = np.minimum.accumulate(far)
    ax.step([*number, len(rows)], [*near, near[-1]], where="post", color=GREEN, linewidth=1.8)
    ax.annotate(
        f"nearest so far: {near[-1]:.3g}",
        (len(rows), near[-1]),
        xytext=(-4, -14),
        textcoords="offset points",
        ha="right",
        color=GREEN,
    )
    ax.set_ylim(0.0, 1.08 * float(far.max()) if far.max() > 0.0 else 1.0)
    ax.set_ylabel("distance")


def _fault(ax: Axes, keys: Sequence[str], shown: Mapping[str, Any], base: Mapping[str, Any]) -> None:
    """Draw where each key stands in its range, and how far that is from nominal."""
    y = np.arange(len(keys))[::-1]
    at = np.array([shown["at"][key] for key in keys])
    nominal = np.array([base["at"][key] for key in keys])
    ax.barh(y, np.ones(len(keys)), 0.62, color="#efefef", linewidth=0)
    ax.barh(y, at - nominal, 0.3, left=nominal, color=VERMILLION, alpha=0.55, linewidth=0)
    ax.plot(nominal, y, marker="|", markersize=17, markeredgewidth=2.4, color=BLACK, linestyle="none", label="nominal")
    ax.plot(at, y, marker="o", markersize=8, color=VERMILLION, linestyle="none", label="this flight")
    low, high = min(0.0, nominal.min(), at.min()), max(1.0, nominal.max(), at.max())
    for place, key in zip(y, keys, strict=True):
        ax.text(high + 0.04, place, _brief(shown["values"][key]), ha="left", va="center", fontsize="small")
    ax.set_yticks(y, keys, fontsize="small")
    ax.set_ylim(min(-0.7, len(keys) - FEW), len(keys) - 0.3)
    ax.set_xlim(low - 0.04, high + 0.3)
    ax.set_xticks([0.0, 0.5, 1.0], ["least", "middle", "greatest"])
    ax.grid(False, axis="y")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), ncols=2)


def _brief(value: Any) -> str:
    text = short(value)
    return text if len(text) <= 16 else f"{text[:15]}\N{HORIZONTAL ELLIPSIS}"
