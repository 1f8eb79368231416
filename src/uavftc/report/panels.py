"""What the figures are drawn with: style, curves that keep their spikes, axes that do not magnify noise."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

# Okabe and Ito, "Color universal design" (2008): distinct with every common colour vision deficiency.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILLION, PURPLE = "#0072B2", "#D55E00", "#CC79A7"

MAX_POINTS = 20_000  # rows drawn as they are; beyond, the envelope
_BINS = 2_000  # two points each; a panel is some 700 pixels wide

_STYLE: Any = {
    "figure.dpi": 150,
    "savefig.dpi": 150,
    "font.size": 12.5,
    "axes.titlesize": 12.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 12.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#e2e2e2",
    "grid.linewidth": 0.7,
    "xtick.labelsize": 11.5,
    "ytick.labelsize": 11.5,
    "legend.fontsize": 12.5,
    "legend.frameon": False,
    "lines.linewidth": 1.7,
    "agg.path.chunksize": 10_000,  # a chattering command has more corners than Agg draws in one go
}


@contextmanager
def style(changes: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Draw in this project's style, whatever the user's matplotlib settings are, and leave those unchanged.

    `changes` are settings of matplotlib that differ from the style for these figures.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_STYLE | dict(changes or {}))
        yield


def new_figure(title: str, rows: int, columns: int, size: tuple[float, float]) -> tuple[Figure, np.ndarray]:
    """Return a figure of `size` inches and its axes, shape (rows, columns), which share the time axis."""
    fig = Figure(figsize=size, layout="constrained")
    fig.get_layout_engine().set(w_pad=0.08, h_pad=0.05)  # type: ignore[union-attr, call-arg]
    fig.suptitle(title, fontsize=14, fontweight="bold", parse_math=False)
    axes = fig.subplots(rows, columns, sharex=True, squeeze=False)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
        ax.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=[1, 2, 5, 10]))
    return fig, axes


def legends(axes: np.ndarray, columns: int | None = None) -> None:
    """Put beneath each column of `axes` one legend of all its curves, each label once, where it covers no data.

    `columns` of entries are two by default, and one where the axes are narrow.
    """
    for column in axes.T:
        if entries := _entries(column):
            column[-1].legend(
                list(entries.values()),
                list(entries),
                loc="upper center",
                bbox_to_anchor=(0.5, -0.24),
                ncols=columns or (2 if axes.shape[1] < 3 else 1),
            )


def legend(fig: Figure, axes: np.ndarray, columns: int) -> None:
    """Put beneath the figure one legend of all curves of `axes`, each label once, in so many columns."""
    entries = _entries(axes.ravel())
    fig.legend(list(entries.values()), list(entries), loc="outside lower center", ncols=columns)


def _entries(axes: Iterable[Axes]) -> dict[str, Artist]:
    """Return what is drawn in `axes`, by its label."""
    entries: dict[str, Artist] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return entries


def curve(ax: Axes, t: np.ndarray, y: np.ndarray, **look: Any) -> np.ndarray:
    """Draw y over t, both shape (n,), thinned if long; return the values drawn."""
    if len(t) > MAX_POINTS:
        t, y = envelope(t, y)
    if len(t) < 3:
        look.setdefault("marker", "o")
    ax.plot(t, y, **look)
    return y


def envelope(t: np.ndarray, y: np.ndarray, bins: int = _BINS) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the greatest sample of each of about `bins` stretches, in their order in time.

    Shape (n,) in, about (2 bins,) out; a spike of a single sample survives, and so do the first and the last sample.
    NaN is passed over, unless the whole stretch is NaN.
    """
    width = -(-len(t) // bins)
    missing = -len(t) % width
    block = np.concatenate([y, np.full(missing, np.nan)]).reshape(-1, width)
    low = np.where(np.isnan(block), np.inf, block).argmin(axis=1)
    high = np.where(np.isnan(block), -np.inf, block).argmax(axis=1)
    start = np.arange(len(block)) * width
    pick = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=1) + start[:, None]
    kept = np.concatenate([[0], pick.ravel(), [len(t) - 1]])
    return t[kept], y[kept]


def cut(ax: Axes, drawn: Sequence[np.ndarray], values: Sequence[float]) -> None:
    """Bound the y-axis to a span beyond a lower and an upper limit, both drawn, and say what is off the scale.

    A command far past its limit acts as one at the limit; on its full scale nothing else could be read.
    """
    if len(values) != 2:
        return
    low, high = min(values), max(values)
    bottom, top = ax.get_ylim()
    new = max(bottom, 2 * low - high), min(top, 2 * high - low)
    if new[0] >= high or new[1] <= low or new == (bottom, top):
        return
    ax.set_ylim(*new)
    finite = np.concatenate(drawn)
    finite = finite[np.isfinite(finite)]
    ends = [v for v, off in ((finite.min(), finite.min() < new[0]), (finite.max(), finite.max() > new[1])) if off]
    text = "off scale: to " + " and ".join(f"{v:+.3g}" for v in ends)
    ax.set_title(text.replace("-", "\N{MINUS SIGN}"), loc="right", fontsize="small", color="#555555")


def fit_y(ax: Axes, values: Sequence[np.ndarray], least: float, headroom: float = 0.0) -> None:
    """Set the y-axis to the finite `values`, spanning at least `least`, with `headroom` (share of it) free on top."""
    drawn = np.concatenate([np.ravel(v) for v in values]) if values else np.empty(0)
    drawn = drawn[np.isfinite(drawn)]
    low, high = (float(drawn.min()), float(drawn.max())) if drawn.size else (0.0, 0.0)
    short = max(least - (high - low), 0.0) / 2
    low, high = low - short, high + short
    margin = 0.06 * (high - low)
    low -= margin
    ax.set_ylim(low, low + (high + margin - low) / (1.0 - headroom))


def fit_t(ax: Axes, t: np.ndarray) -> None:
    """Set the shared time axis to the flight."""
    finite = t[np.isfinite(t)]
    start, end = (float(finite[0]), float(finite[-1])) if finite.size else (0.0, 0.0)
    ax.set_xlim(start, end if end > start else start + 1.0)


def shade(ax: Axes, windows: Sequence[tuple[float, float, str]], *, name: str, written: bool = True) -> float:
    """Shade time windows (start, end, label) behind the curves, and write the labels at the top where they fit.

    Returns the share of the height that the labels need, for `fit_y`.
    """
    t0, t1 = ax.get_xlim()
    layout = ax.get_subplotspec().get_gridspec()  # type: ignore[union-attr]
    width, height = ax.figure.get_size_inches() * 72 / (layout.ncols, layout.nrows)  # type: ignore[union-attr]
    lines = 0
    for i, (start, end, label) in enumerate(sorted(windows)):
        start, end = max(start, t0), min(end, t1)  # noqa: PLW2901
        if end <= start:
            continue
        ax.axvspan(start, end, color=ORANGE, alpha=(0.13, 0.24)[i % 2], linewidth=0, zorder=0, label=name)
        room = int((end - start) / (t1 - t0) * 0.85 * width / 5.6)  # characters of 10 points
        if written and room >= 5:
            text = _wrapped(label, room)
            lines = max(lines, text.count("\n") + 1)
            ax.text(
                (start + end) / 2, 0.985, text, transform=ax.get_xaxis_transform(),
                ha="center", va="top", fontsize=10, color="#5c3d00", parse_math=False, linespacing=1.05,
            )  # fmt: skip
    return min(lines * 12.5 / (0.7 * height), 0.5)


def limits(ax: Axes, drawn: Sequence[np.ndarray], values: Sequence[float]) -> list[np.ndarray]:
    """Draw lines at `values` and return them for `fit_y`; those so far off that curves would go flat are only named."""
    finite = np.concatenate(drawn)
    finite = finite[np.isfinite(finite)]
    reach = 2.0 * np.ptp(finite) if finite.size else 0.0
    shown = [v for v in values if finite.size and np.abs(finite - v).min() <= reach]
    for value in shown:
        ax.axhline(value, color="#555555", linestyle=(0, (4, 2)), linewidth=1.2, label="limit")
    off = ", ".join(f"{v:+.3g}" for v in values if v not in shown)
    if off:
        ax.set_title(
            f"off scale: limit {off}".replace("-", "\N{MINUS SIGN}"), loc="right", fontsize=10.5, color="#555555"
        )
    return [np.array([v]) for v in shown]


def mark_entry(ax: Axes, t: np.ndarray, error: np.ndarray, band: float) -> None:
    """Mark the first row after the last one outside the band, unless `error` (>= 0) is outside to the end."""
    outside = np.flatnonzero(~(error <= band))
    if not outside.size or outside[-1] + 1 == len(t):
        return
    time = t[outside[-1] + 1]
    late = time > np.dot(ax.get_xlim(), (0.2, 0.8))  # then beneath, left of the marker: the curve comes from above
    look: Any = {"marker": "v", "markersize": 8, "linestyle": "none", "color": VERMILLION}
    ax.plot([time], [band], label="converged", zorder=4, **look)
    ax.annotate(
        f"{time:.2f} s",
        (time, band),
        xytext=(-6, -17) if late else (5, 8),
        textcoords="offset points",
        ha="right" if late else "left",
        fontsize=11,
    )


def note(ax: Axes, text: str) -> None:
    """Write a remark into the middle of an empty panel."""
    look: Any = {"ha": "center", "va": "center", "color": "#555555", "backgroundcolor": "white"}
    ax.text(0.5, 0.5, text, transform=ax.transAxes, **look)


def absent(ax: Axes, text: str) -> None:
    """Write into a panel why there is nothing in it, and take its scale away."""
    note(ax, text)
    ax.set_yticks([])
    ax.grid(False)


def _wrapped(label: str, room: int) -> str:
    parts = label.split("\n")
    lines = [line for part in parts for line in textwrap.wrap(part, room, break_long_words=False)]
    if max(map(len, lines), default=0) > 1.15 * room:
        lines = [line for part in parts for line in textwrap.wrap(part, room)]
    if len(lines) > 4:
        lines = [*lines[:3], lines[3][: room - 3] + "..."]
    return "\n".join(lines)
