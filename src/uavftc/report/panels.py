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

MAX_POINTS = 20_000  # rows drawn as they are; beyond, the envelope
_BINS = 2_000  # two points each; a panel is some 700 pixels wide
THINNED = 2 * _BINS  # points of an envelope, about
_LARGEST = 1e9  # beyond it, the end of a diverged flight is not drawn: it would overflow the axes
_BRIEF = 0.005  # share of the samples on either side that may be a spike
_FAR = 4.0  # a spike makes the span of the values at least so many times that of the others
_WOUND_UP_DEG = 30.0  # how far beyond the deflection a command is drawn where there is no limit
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
    for column in axes.T:
        if entries := _entries(column):
            column[-1].legend(
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


def wound_up(command: np.ndarray, deflection: Sequence[np.ndarray], limits: Sequence[float]) -> list[np.ndarray]:
    """Return what the y-axis is to show of a command, deg: of one far beyond what is deflected or allowed a part.

    That part reaches a span of the limits beyond them, or 30 deg beyond the deflection where there are not two.
    """
    kept, values = finite([*deflection, np.asarray(limits, dtype=float)]), finite([command])
    if not kept.size or not values.size:
        return [command]
    low, high = float(kept.min()), float(kept.max())
    reach = high - low if len(limits) == 2 else max(_WOUND_UP_DEG, high - low)
    return [np.clip(values, low - reach, high + reach)]


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
        remark(ax, "off scale: to " + " and ".join(map(_signed, beyond)))


def _signed(value: float) -> str:
    """Return a number with its sign and three digits that count: +1390."""
    return f"{float(f'{value:.3g}'):+g}"


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
    """Set the y-axis to the finite `values` and to `keep`, spanning at least `least`; a spike of `values` is cut.

    A spike is what at most one per cent of the values do, if it makes their span more than four times as large.
    """
    drawn, kept = finite(values), finite(keep)
    low, high = (float(drawn.min()), float(drawn.max())) if drawn.size else (0.0, 0.0)
    if drawn.size:
        core = [float(v) for v in np.quantile(drawn, (_BRIEF, 1.0 - _BRIEF))]
        span = max(core[1] - core[0], least)
        if high - low > _FAR * span:
            low, high = max(low, core[0] - 0.5 * span), min(high, core[1] + 0.5 * span)
    if kept.size:
        low, high = min(low, float(kept.min())), max(high, float(kept.max()))
    short = max(least - (high - low), 0.0) / 2
    low, high = low - short, high + short
    margin = 0.06 * (high - low)
    ax.set_ylim(low - margin, high + margin)


def finite(values: Sequence[np.ndarray]) -> np.ndarray:
    """Return the finite numbers among several arrays, shape (n,)."""
    drawn = np.concatenate([np.ravel(v) for v in values]) if values else np.empty(0)
    found: np.ndarray = drawn[np.isfinite(drawn)]
    return found


def fit_t(ax: Axes, t: np.ndarray) -> None:
    """Set the shared time axis to the flight."""
    start, end = ends(t)
    ax.set_xlim(start, end if end > start else start + 1.0)


def ends(t: np.ndarray) -> tuple[float, float]:
    """Return the first and the last finite time, s; 0 where there is none."""
    found = finite([t])
    return (float(found[0]), float(found[-1])) if found.size else (0.0, 0.0)


def limits(ax: Axes, drawn: Sequence[np.ndarray], values: Sequence[float]) -> list[np.ndarray]:
    """Draw lines at `values` and return them for `fit_y`; those so far off that curves would go flat are only named."""
    found = finite(drawn)
    reach = 2.0 * np.ptp(found) if found.size else 0.0
    shown = [v for v in values if found.size and np.abs(found - v).min() <= reach]
    for value in shown:
        ax.axhline(value, label="limit", **LIMIT)
    if off := ", ".join(_signed(v) for v in values if v not in shown):
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


def column(history: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return a column to draw, shape (n,): NaN where it is absent or has diverged."""
    values = history.get(name, np.full(len(history["time_s"]), np.nan))
    return np.where(np.abs(values) < _LARGEST, values, np.nan)


def deg(history: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return a column in rad as deg, or in rad/s as deg/s; see `column`."""
    return np.rad2deg(column(history, name))
