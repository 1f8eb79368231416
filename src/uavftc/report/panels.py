"""What the figures are drawn with: style, curves that keep their spikes, axes that do not magnify noise."""

from __future__ import annotations

import string
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from uavftc.report.palette import DARK, LIMIT, VERMILLION
from uavftc.report.series import BINS, ends, envelope, finite, signed, span

MAX_POINTS = 20_000  # rows drawn as they are; beyond, the envelope
THINNED = 2 * BINS  # points of an envelope, about
WITHOUT = "without faults"
"""The label of the twin's curves."""
_LETTERS = string.ascii_letters
IDLE_DEGPS = 1e-3  # an observer whose estimate stays below is idle: the commanded rates are 2.5 deg/s

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


def legends(axes: np.ndarray, columns: int | None = None) -> None:
    """Put beneath each column of `axes` one legend of all its curves, each label once, where it covers no data.

    `columns` of entries are two by default, and one where the axes are narrow.
    """
    for below in axes.T:
        if entries := _entries(below):
            below[-1].legend(
                list(entries.values()),
                list(entries),
                loc="upper center",
                bbox_to_anchor=(0.5, -0.24),
                ncols=columns or (2 if axes.shape[1] < 3 else 1),
            )


def legend(fig: Figure, axes: np.ndarray) -> None:
    """Put beneath the figure one legend of all curves of `axes`, each label once, in as many columns as have room."""
    if not (entries := _entries(axes.ravel())):
        return
    size = mpl.rcParams["legend.fontsize"]
    widest = max((width_of(label, size) for label in entries), default=0.0) + 4.5 * size  # with its sample
    columns = max(1, int(72 * (fig.get_size_inches()[0] - 0.3) / widest))
    fig.legend(list(entries.values()), list(entries), loc="outside lower center", ncols=columns)


def _entries(axes: Iterable[Axes]) -> dict[str, Artist]:
    """Return what is drawn in `axes`, by its label; the twin comes last."""
    entries: dict[str, Artist] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    return dict(sorted(entries.items(), key=lambda entry: entry[0] == WITHOUT))


def title_legend(ax: Axes, curves: Sequence[Artist], columns: int) -> None:
    """Name curves of one panel to the right of its title; they take no part in the legend beneath."""
    place: Any = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderaxespad": 0.1}
    ax.legend(handles=curves, ncols=columns, fontsize="small", columnspacing=1.2, handlelength=2.4, **place)
    for one in curves:
        one.set_label(f"_{one.get_label()}")


def width_of(text: str, size: float) -> float:
    """Return the width of a text of so many points, points."""
    return float(text_to_path.get_text_width_height_descent(text, FontProperties(size=size), False)[0])


def curve(ax: Axes, t: np.ndarray, y: np.ndarray, *, turn: float | None = None, **look: Any) -> np.ndarray:
    """Draw y over t, both shape (n,), thinned if long; return the values drawn.

    Where y jumps by more than half a `turn` there is no line: an angle that is counted within one turn wraps there.
    """
    if len(t) > MAX_POINTS:
        t, y = envelope(t, y)
    if turn is not None:
        wraps = np.flatnonzero(np.abs(np.diff(y)) > 0.5 * turn) + 1
        t, y = np.insert(t, wraps, t[wraps]), np.insert(y, wraps, np.nan)
    if len(t) < 3:
        look.setdefault("marker", "o")
    ax.plot(t, y, **look)
    return y


def cut(ax: Axes, values: Sequence[float]) -> None:
    """Bound the y-axis to a span beyond a lower and an upper limit, both drawn.

    A command far past its limit acts as one at the limit; on its full scale nothing else could be read.
    """
    if len(values) != 2:
        return
    low, high = min(values), max(values)
    bottom, top = ax.get_ylim()
    new = max(bottom, 2 * low - high), min(top, 2 * high - low)
    if new[0] < high and new[1] > low:
        ax.set_ylim(*new)


def name_off_scale(ax: Axes) -> None:
    """Say above a panel how far its curves go beyond the ends of the y-axis, if they do; not on a logarithmic one."""
    if ax.get_yscale() != "linear":
        return
    drawn = [np.asarray(line.get_ydata(), dtype=float) for line in ax.lines if line.get_transform() == ax.transData]
    drawn += [np.asarray(path.vertices)[:, 1] for band in ax.collections for path in band.get_paths()]
    values, (bottom, top) = finite(drawn), ax.get_ylim()
    if not values.size:
        return
    low, high = float(values.min()), float(values.max())
    slack = 1e-9 * (top - bottom)
    beyond = [v for v, off in ((low, low < bottom - slack), (high, high > top + slack)) if off]
    if beyond:
        remark(ax, "off scale: to " + " and ".join(map(signed, beyond)))


def remark(ax: Axes, text: str) -> None:
    """Write a remark to the right above a panel, behind what stands there."""
    before = ax.get_title(loc="right")
    text = text.replace("-", "\N{MINUS SIGN}")
    if ax.get_legend() is not None:  # which has that place
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8}
        look: Any = {"ha": "right", "va": "bottom", "fontsize": "small", "color": DARK, "bbox": box}
        ax.text(0.995, 0.02, text, transform=ax.transAxes, **look)
        return
    ax.set_title(f"{before}; {text}" if before else text, loc="right", fontsize="small", color=DARK)


def fit_y(ax: Axes, values: Sequence[np.ndarray], least: float, keep: Sequence[np.ndarray] = ()) -> None:
    """Set the y-axis as `series.span` says."""
    ax.set_ylim(*span(values, least, keep))


def fit_t(ax: Axes, t: np.ndarray) -> None:
    """Set the shared time axis to the flight."""
    start, end = ends(t)
    ax.set_xlim(start, end if end > start else start + 1.0)


def limits(ax: Axes, drawn: Sequence[np.ndarray], values: Sequence[float]) -> list[np.ndarray]:
    """Draw lines at `values` and return them for `fit_y`; those so far off that curves would go flat are only named."""
    found = finite(drawn)
    reach = 2.0 * np.ptp(found) if found.size else 0.0
    shown = [v for v in values if found.size and np.abs(found - v).min() <= reach]
    for value in shown:
        ax.axhline(value, label="limit", **LIMIT)
    if off := ", ".join(signed(v) for v in values if v not in shown):
        remark(ax, f"off scale: limit {off}")
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


def note(ax: Axes, text: str, height: float = 0.5) -> None:
    """Write a remark into an empty panel, at a share of its height."""
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
    ax.text(0.5, height, text, transform=ax.transAxes, ha="center", va="center", color=DARK, fontsize="small", bbox=box)


def idle(size: float, unit: str) -> str:
    """Return the remark on an observer whose estimate is nothing but rounding, at most `size`."""
    if size == 0.0:
        return "observer idle: its estimate is 0"
    digit, exponent = f"{size:.0e}".split("e")
    return rf"observer idle: at most ${digit}\cdot 10^{{{int(exponent)}}}$ {unit}"


def absent(ax: Axes, text: str) -> None:
    """Write into a panel why there is nothing in it, and take its scale away."""
    note(ax, text)
    ax.set_yticks([])
    ax.grid(False)


def letters(ax: Axes, index: int, title: str, unit: str) -> None:
    """Give a panel its letter (by `index`), title and unit."""
    ax.set_title(f"({_LETTERS[index % len(_LETTERS)]}) {title}")
    ax.set_ylabel(unit)
