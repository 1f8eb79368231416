"""The map of a campaign: the margin over two of its inputs, and the boundary at which the margin passes 0.

The other inputs vary too, so a point of the map has many margins. What is shown beneath the flights, and what the
boundary is of, is the mean of the margins near there: weighted by a normal distribution in the two inputs (Nadaraya and
Watson, 1964), its width by Scott's rule, n^(-1/6) of the spread. Where an input takes a few values or texts, each of
them stands alone.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.ndimage import gaussian_filter

from uavftc.report.campaign_text import headline
from uavftc.report.palette import BLACK, BLUE, VERMILLION

CELLS = 72  # along a continuous input
LEVELS = 12  # values of an input up to which each stands alone, if numbers; texts always do
SPREAD = 0.2887  # standard deviation of a uniform distribution, of its range
ENOUGH = 0.02  # of the mean number of flights a cell: below it nothing is shown
FIRST = ("kind", "surface", "engine")
SHOWN = 1_500  # flights drawn as points
COLOURS = LinearSegmentedColormap.from_list("margin", ["#7a2e00", VERMILLION, "#f6e3d8", "#dcecf6", BLUE, "#003b5c"])
NORM = TwoSlopeNorm(vcenter=0.0, vmin=-1.0, vmax=1.0)


class Axis(NamedTuple):
    """One input of the map."""

    key: str
    at: np.ndarray
    """Where each flight is, shape (n,)."""
    edges: np.ndarray
    """Of the cells."""
    labels: list[str] | None
    """Of the cells, where each stands for a value."""
    log: bool

    @property
    def middles(self) -> np.ndarray:
        """Of the cells, on the axis as it is drawn."""
        edges = np.log(self.edges) if self.log else self.edges
        middle = 0.5 * (edges[1:] + edges[:-1])
        return np.exp(middle) if self.log else middle

    def sigma(self, flights: int) -> float:
        """Return the width of the weights, in cells."""
        return 0.0 if self.labels is not None else SPREAD * flights ** (-1.0 / 6.0) * CELLS


def axis_of(key: str, values: np.ndarray, words: Sequence[str] | None, kind: str) -> Axis:
    """Return an input as an axis of the map."""
    levels = np.unique(values)
    if words is not None or len(levels) <= LEVELS:
        labels = [plain(words[int(level)]) if words is not None else f"{level:g}" for level in levels]
        return Axis(key, np.searchsorted(levels, values).astype(float), np.arange(len(levels) + 1) - 0.5, labels, False)
    log = kind == "log-uniform"
    low, high = float(values.min()), float(values.max())
    edges = np.geomspace(low, high, CELLS + 1) if log else np.linspace(low, high, CELLS + 1)
    return Axis(key, values, edges, None, log)


def plain(word: str) -> str:
    """Return a value as a label: of a section the kind, what it is on, and the rest by name."""
    try:
        said = json.loads(word)
    except ValueError:
        return word
    if isinstance(said, list) and said and all(isinstance(one, dict) for one in said):
        return "; ".join(plain(json.dumps(one)) for one in said)
    if not isinstance(said, dict):
        return word
    first = " ".join(f"engine {said[k]}" if k == "engine" else str(said[k]) for k in FIRST if k in said)
    rest = [f"{key} {value}" for key, value in said.items() if key not in FIRST]
    return ", ".join(part for part in (first, *rest) if part)


def near(x: Axis, y: Axis, margin: np.ndarray) -> np.ndarray:
    """Return the mean margin near the middle of each cell, shape (cells of y, cells of x); NaN where no flight is."""
    there = np.isfinite(margin)
    place = (x.at[there], y.at[there])
    edges = (x.edges, y.edges)
    count = np.histogram2d(*place, bins=edges)[0]
    total = np.histogram2d(*place, bins=edges, weights=margin[there])[0]
    flights = int(there.sum())
    sigma = (x.sigma(flights), y.sigma(flights))
    if any(sigma):
        count, total = (gaussian_filter(one, sigma, mode="constant", truncate=4.0) for one in (count, total))
    least = ENOUGH * max(flights, 1) / count.size
    with np.errstate(invalid="ignore", divide="ignore"):
        mean: np.ndarray = np.where(count > least, total / count, np.nan).T
    return mean


def map_figure(
    document: Mapping[str, Any],
    margin: np.ndarray,
    inputs: Mapping[str, tuple[np.ndarray, list[str] | None]],
    kinds: Mapping[str, str],
) -> Figure:
    """Return a panel a variant.

    Parameters
    ----------
    margin
        Shape (cases, variants).
    inputs
        What each of the two keys took, shape (cases,), and its words where it is a text.
    kinds
        How each was drawn.
    """
    x, y = (axis_of(key, *inputs[key], kinds[key]) for key in document["map"])
    if _wordy(x) > _wordy(y):
        x, y = y, x  # texts stand at the side, where there is room to read them
    variants = document["variants"]
    columns = min(3, len(variants))
    rows = -(-len(variants) // columns)
    high = max(3.9, 0.3 * len(y.labels or []) + 0.8)
    size = (4.4 * columns + 1.6 + min(0.07 * _wordy(y), 3.4), high * rows + 1.6)
    fig = Figure(figsize=size, layout="constrained")
    axes = fig.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for i, (ax, one) in enumerate(zip(axes.flat, variants, strict=False)):
        drawn = _panel(ax, x, y, margin[:, i])
        passes = _boundary(ax, x, y, margin[:, i])
        ax.set_title(f"{one['name']}{'' if passes else ': no boundary'}", parse_math=False)
    for ax in list(axes.flat)[len(variants) :]:
        ax.set_visible(False)
    for j in range(columns):
        lowest = max(i for i in range(rows) if i * columns + j < len(variants))
        axes[lowest, j].set_xlabel(x.key, parse_math=False)
        axes[lowest, j].tick_params(labelbottom=True)
    for row in axes:
        row[0].set_ylabel(y.key, parse_math=False)
    bar = fig.colorbar(drawn, ax=axes, extend="min", shrink=0.8, aspect=30)
    bar.set_label("margin; below 0 broken, lost at -1 and below")
    fig.legend(
        handles=[
            Line2D([], [], color=BLACK, linewidth=2.2, label="boundary: the mean margin near there is 0"),
            Line2D([], [], color="none", marker="o", markerfacecolor=BLUE, markeredgecolor="white", label="a flight"),
        ],
        loc="outside lower center",
        ncols=2,
    )
    fig.suptitle(f"{headline(document)}: the margin over two inputs", fontsize=13, parse_math=False)
    return fig


def _wordy(axis: Axis) -> int:
    return max((len(label) for label in axis.labels or []), default=0)


def _panel(ax: Axes, x: Axis, y: Axis, margin: np.ndarray) -> Any:
    drawn = ax.pcolormesh(x.edges, y.edges, near(x, y, margin), cmap=COLOURS, norm=NORM, alpha=0.75, linewidth=0)
    drawn.set_edgecolor("none")
    ax.grid(False)
    there = np.flatnonzero(np.isfinite(margin))[:SHOWN]
    rng = np.random.default_rng(0)  # flights with the same value side by side
    here = [one.at[there] + (rng.uniform(-0.32, 0.32, len(there)) if one.labels is not None else 0.0) for one in (x, y)]
    size = 26.0 if len(there) < 400 else 11.0
    ax.scatter(here[0], here[1], c=margin[there], cmap=COLOURS, norm=NORM, s=size, edgecolors="white", linewidths=0.35)
    for one, scale, ticks in ((x, ax.set_xscale, ax.set_xticks), (y, ax.set_yscale, ax.set_yticks)):
        if one.log:
            scale("log")
        if one.labels is not None:
            folded = [textwrap.shorten(label, 48, placeholder="...") for label in one.labels]
            longest = max(map(len, folded))
            look: dict[str, Any] = {"rotation": 90} if one is x and longest > 4 else {}
            ticks(range(len(folded)), folded, parse_math=False, **look | ({"fontsize": 8.5} if longest > 12 else {}))
    return drawn


def _boundary(ax: Axes, x: Axis, y: Axis, margin: np.ndarray) -> bool:
    """Draw where the mean margin passes 0, and return whether it does."""
    mean = near(x, y, margin)
    known = mean[np.isfinite(mean)]
    if not len(known) or known.min() >= 0.0 or known.max() < 0.0:
        return False
    if x.labels is None and y.labels is None:
        ax.contour(x.middles, y.middles, mean, levels=[0.0], colors=[BLACK], linewidths=2.2)
        return True
    broken = np.where(np.isfinite(mean), mean < 0.0, np.nan)  # a value that stands alone has cells, not slopes
    for i in range(broken.shape[0]):
        for j in range(broken.shape[1]):
            if j + 1 < broken.shape[1] and broken[i, j] + broken[i, j + 1] == 1.0:
                ax.plot([x.edges[j + 1]] * 2, y.edges[i : i + 2], color=BLACK, linewidth=2.2)
            if i + 1 < broken.shape[0] and broken[i, j] + broken[i + 1, j] == 1.0:
                ax.plot(x.edges[j : j + 2], [y.edges[i + 1]] * 2, color=BLACK, linewidth=2.2)
    return True
