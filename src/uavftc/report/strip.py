"""What happened in a flight, over its panels: a list of the windows by number, a strip of bars, and shaded panels.

Each window has a number, a colour by its kind and a place in the list above the panels, which names it. The strip above
each column of panels has all of them, aligned with its time axis; a panel shades those that concern what it shows.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from uavftc.report.palette import BLACK, KINDS, WHITE
from uavftc.report.panels import fit_t, name_off_scale, width_of
from uavftc.report.series import ends
from uavftc.results.context import FigureContext
from uavftc.results.windows import FlightWindow

_SIZE, _SMALL = 10.5, 9.0  # of a text, points
_TITLES = 14.0, 11.5
_BOLD = 1.17  # times as wide
_LANE_IN, _LINE_IN = 0.19, 0.22  # height of a lane of the strip and of a line of the list, inches
_MARGIN_IN = 1.05  # of a column of panels, left and right of its axes, inches
_PANEL = 0.68  # share of the height of a row of panels that its axes have
_SECOND = 0.5  # where the second column of the list begins, of its width
_LISTED, _LANES = 16, 8  # windows listed, and lanes of the strip, at most
_ALPHA = (0.15, 0.30)  # of a panel's windows by turns, so that consecutive ones are told apart
_WHOLE = 0.09  # of one that lasts from end to end
_LINES = 3  # of a label in a panel
_PLAIN = {
    "fault": "fault on a surface", "engine": "fault of an engine", "damage": "damage", "air": "moving air",
    "disturbance": "disturbance", "sensor": "error of a sensor",
}  # fmt: skip
TOLD = "controller told"
_LIMITING: dict[str, Any] = {"color": BLACK, "linewidth": 1.0, "linestyle": (0, (6, 1.5, 1, 1.5)), "zorder": 4}


class Entry(NamedTuple):
    """An entry of the list."""

    sign: str
    """The number, or what stands for it."""
    text: str
    colour: str


class Bar(NamedTuple):
    """A window as far as it lies on the time axis, and the lane in which it meets no other."""

    number: int
    window: FlightWindow
    start: float
    end: float
    lane: int


def new_figure(
    context: FigureContext, t: np.ndarray, rows: int, columns: int, size: tuple[float, float]
) -> tuple[Figure, np.ndarray]:
    """Return a figure and its axes, shape (rows, columns), which share the time axis; above them list and strip.

    Parameters
    ----------
    context
        The title, the windows and the limiting moment.
    t
        The times of the longest flight drawn, s, shape (n,).
    size
        Of the figure without list and strip, inches.
    """
    fig = Figure(layout="constrained")
    start, end = ends(t)
    point = (end - start) / (72 * (size[0] / columns - _MARGIN_IN))
    shown = _bars(list(enumerate(context.windows, 1)), start, end, point)
    lines = _lines(context, shown, end, size[0])
    lanes = min(max((bar.lane + 1 for bar in shown), default=0), _LANES)
    heights = [_LINE_IN * len(lines)] if lines else []
    heights += [_LANE_IN * lanes] if lanes else []
    title, letters = _folded(context.title, 72 * (size[0] - 0.4))
    more = 0.016 * letters * (len(title) - 1)
    fig.set_size_inches(size[0], round(size[1] + more + sum(heights) + 0.06 * len(heights), 2))
    fig.get_layout_engine().set(w_pad=0.08, h_pad=0.05)  # type: ignore[union-attr, call-arg]
    fig.suptitle("\n".join(title), fontsize=letters, fontweight="bold", parse_math=False)
    above = len(heights)
    grid = fig.add_gridspec(above + rows, columns, height_ratios=[*heights, *[_PANEL * size[1] / rows] * rows])
    axes = np.empty((rows, columns), dtype=object)
    for i in range(rows):
        for j in range(columns):
            share = axes[0, 0] if i + j else None
            axes[i, j] = fig.add_subplot(grid[above + i, j], sharex=share)
            axes[i, j].tick_params(labelbottom=i == rows - 1)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
        ax.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=[1, 2, 5, 10]))
    fit_t(axes[0, 0], t)
    if lines:
        _list(fig.add_subplot(grid[0, :]), lines)
    for j in range(columns if lanes else 0):
        _strip(fig.add_subplot(grid[above - 1, j], sharex=axes[0, 0]), shown, context, lanes)
    return fig, axes


def mark(ax: Axes, context: FigureContext, *names: str, written: bool = False, plain: bool = False) -> None:
    """Shade the windows that concern one of these signals, with their numbers, and mark the limiting moment.

    Call it when the y-axis is set: it is made higher for what is written at its top, and what is off scale is named.
    With `written`, the label of a window is there too where it fits. With `plain`, nothing is, windows that begin and
    end together are shaded once, and the legend says what is shaded.
    """
    t0, t1 = ax.get_xlim()
    spec = ax.get_subplotspec()
    width, height = _points(ax)
    point = (t1 - t0) / width
    windows = context.concerning(*names)
    if plain:
        windows = list({(w.kind, w.start_s, w.end_s): (i, w) for i, w in windows}.values())
    bars = _bars(windows, t0, t1, point)
    alone = all(bar.lane == 0 for bar in bars)
    lines = 0
    for k, bar in enumerate(bars):
        colour, dark = KINDS[bar.window.kind]
        alpha = _ALPHA[k % 2] * (0.6 if bar.window.kind == "disturbance" else 1.0)
        if bar.start <= t0 and bar.end >= t1:
            alpha = _WHOLE
        name = _PLAIN[bar.window.kind] if plain else None
        ax.axvspan(bar.start, bar.end, color=colour, alpha=alpha, linewidth=0, zorder=0, label=name)
        for edge in (bar.start, bar.end):
            if t0 < edge < t1:
                ax.axvline(edge, color=dark, alpha=0.55, linewidth=0.8, zorder=1)
        if plain:
            continue
        room = int(0.88 * (bar.end - bar.start) / point / 5.3)  # characters of 9 points
        label = _wrapped(f"{bar.number}: {bar.window.label}", room) if written and alone and room >= 6 else ""
        text, y = label or f"{bar.number}", 0.985 - bar.lane * 1.25 * _SIZE / (0.75 * height)
        lines = max(lines, bar.lane + 1 + text.count("\n"))
        if label:
            place: Any = {"x": (bar.start + bar.end) / 2, "ha": "center"}
        else:
            place = {"x": bar.start + 3.0 * point, "ha": "left", "fontweight": "bold"}
        ax.text(
            y=y, s=text, transform=ax.get_xaxis_transform(), va="top", fontsize=_SMALL + 0.5, color=dark,
            parse_math=False, linespacing=1.05, zorder=5, **place,
        )  # fmt: skip
        told = bar.window.known_from_s
        if told is not None and t0 <= told <= t1:
            ax.axvline(told, color=dark, linewidth=1.3, linestyle=":", zorder=1)
            look: Any = {"marker": "v", "markersize": 8, "color": dark, "linestyle": "none", "clip_on": False}
            ax.plot([told], [1.0], transform=ax.get_xaxis_transform(), label=TOLD, zorder=5, **look)
    if lines and spec is not None:
        _lift(ax, min((0.2 + 1.25 * _SIZE * lines) / (0.75 * height), 0.5))
    _limiting(ax, context)
    name_off_scale(ax)


def _limiting(ax: Axes, context: FigureContext) -> None:
    """Mark the moment that decided the verdict."""
    if context.limiting is not None and ax.get_xlim()[0] <= context.limiting[1] <= ax.get_xlim()[1]:
        at = context.limiting[1]
        ax.axvline(at, **_LIMITING)
        look: Any = {"marker": "v", "markersize": 7, "color": BLACK, "linestyle": "none", "clip_on": False, "zorder": 5}
        ax.plot([at], [1.0], transform=ax.get_xaxis_transform(), **look)


def _folded(title: str, room: float) -> tuple[list[str], float]:
    """Return the lines of a title, none wider than the room, and the size of its letters, smaller if they are many."""
    for size in _TITLES:
        lines: list[str] = []
        for part in title.split("\n"):
            lines.append("")
            for word in part.split(" "):
                longer = f"{lines[-1]} {word}" if lines[-1] else word
                if lines[-1] and _BOLD * width_of(longer, size) > room:
                    lines.append(word)
                else:
                    lines[-1] = longer
        if len(lines) <= 2:
            break
    return lines, size


def _points(ax: Axes) -> tuple[float, float]:
    """Return about how wide and high the axes are, points."""
    spec, size = ax.get_subplotspec(), ax.figure.get_size_inches()  # type: ignore[union-attr]
    if spec is None:
        return float(72 * (size[0] - _MARGIN_IN)), float(72 * _PANEL * size[1])
    grid = spec.get_gridspec()
    heights = np.asarray(grid.get_height_ratios(), dtype=float)
    height = heights[spec.rowspan.start : spec.rowspan.stop].sum() / heights.sum()
    return float(72 * (size[0] / grid.ncols - _MARGIN_IN)), float(72 * height * size[1])


def _lift(ax: Axes, share: float) -> None:
    """Leave a share of the height of the axes free at their top."""
    transform = ax.yaxis.get_transform()
    low, high = transform.transform(np.array(ax.get_ylim()))
    ax.set_ylim(top=float(transform.inverted().transform(np.array([low + (high - low) / (1.0 - share)]))[0]))


def _bars(windows: Sequence[tuple[int, FlightWindow]], t0: float, t1: float, point: float) -> list[Bar]:
    """Return the windows within [t0, t1), cut to it, each in the first lane that is free there.

    A bar with no room for its number has it behind it; a point of the figure is `point` s.
    """
    free: list[float] = []
    bars = []
    for number, window in windows:
        start, end = max(window.start_s, t0), min(window.end_s, t1)
        if end <= start:
            continue
        lane = next((k for k, until in enumerate(free) if until <= start + 1e-9), len(free))
        needed = width_of(f"{number}", _SMALL) * point
        free[lane : lane + 1] = [end if needed <= end - start else end + needed + 4.0 * point]
        bars.append(Bar(number, window, start, end, min(lane, _LANES - 1)))
    return bars


def _strip(ax: Axes, bars: Sequence[Bar], context: FigureContext, lanes: int) -> None:
    """Draw the bars above a column of panels: the number, and the name where it fits; a line where it is known."""
    t0, t1 = ax.get_xlim()
    scale = (72 * (ax.figure.get_size_inches()[0] / ax.get_subplotspec().get_gridspec().ncols - _MARGIN_IN)) / (t1 - t0)  # type: ignore[union-attr]
    ax.set_ylim(lanes, 0)
    ax.set_yticks([])
    ax.grid(False)
    ax.tick_params(bottom=False, labelbottom=False)
    for spine in ax.spines.values():
        spine.set_visible(False)
    for bar in bars:
        colour, dark = KINDS[bar.window.kind]
        box = Rectangle((bar.start, bar.lane + 0.06), bar.end - bar.start, 0.88, facecolor=colour, alpha=0.6)
        ax.add_patch(box)
        ax.vlines([bar.start, bar.end], bar.lane + 0.06, bar.lane + 0.94, color=dark, linewidth=0.8)
        number, text = f"{bar.number}", f"{bar.number}  {_named(bar.window)}"
        length = scale * (bar.end - bar.start)
        x, ha = bar.end + 2.0 / scale, "left"
        if width_of(text, _SMALL) <= length - 6.0:
            x = bar.start + 3.0 / scale
        elif width_of(text := number, _SMALL) <= length:
            x, ha = (bar.start + bar.end) / 2, "center"
        look: Any = {"fontsize": _SMALL, "va": "center", "color": BLACK, "parse_math": False}
        ax.text(x, bar.lane + 0.5, text, ha=ha, clip_on=True, **look)
        told, until = bar.window.known_from_s, bar.window.known_until_s
        if told is not None and told < t1:
            end = min(bar.end if until is None else until, t1)
            ax.plot([told, end], [bar.lane + 0.94] * 2, color=BLACK, linewidth=2.0, solid_capstyle="butt")
    _limiting(ax, context)


def _lines(context: FigureContext, bars: Sequence[Bar], end: float, width_in: float) -> list[list[Entry]]:
    """Return the lines of the list, each with one or two entries; the flight ends at `end`, s."""
    found = [(f"{b.number}", _named(b.window), f" ({_when(b.window, end)})", KINDS[b.window.kind].colour) for b in bars]
    if len(found) > _LISTED:
        rest = len(found) - _LISTED + 1
        found = [*found[: _LISTED - 1], ("...", f"and {rest} more windows: scenario.yaml", "", WHITE)]
    if context.limiting is not None:
        name, at = context.limiting
        found.append(("\N{BLACK DOWN-POINTING TRIANGLE}", f"limiting: {name}", f" ({at:g} s)", WHITE))
    width = 72 * (width_in - 1.3)
    half = (_SECOND - 0.05) * width - 6.0
    fits = all(width_of(name + when, _SIZE) <= half for _, name, when, _ in found)
    columns = 2 if fits or len(found) > 4 else 1
    room = half if columns == 2 else half + (1.0 - _SECOND) * width
    texts = [_cut(name, room - width_of(when, _SIZE)) + when for _, name, when, _ in found]
    entries = [Entry(sign, text, colour) for (sign, _, _, colour), text in zip(found, texts, strict=True)]
    rows = -(-len(entries) // columns)
    return [entries[i::rows] for i in range(rows)]


def _list(ax: Axes, lines: Sequence[Sequence[Entry]]) -> None:
    """Draw the list into axes of its own."""
    ax.set_axis_off()
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(len(lines), 0)
    for i, line in enumerate(lines):
        for j, entry in enumerate(line):
            look: Any = {"va": "center_baseline", "fontsize": _SIZE, "parse_math": False}
            box = {"boxstyle": "round,pad=0.18", "facecolor": entry.colour, "edgecolor": "none", "alpha": 0.6}
            ax.text(_SECOND * j + 0.02, i + 0.5, entry.sign, ha="right", bbox=box, **look)
            ax.text(_SECOND * j + 0.03, i + 0.5, entry.text, ha="left", **look)


def _when(window: FlightWindow, end: float) -> str:
    """Return when a window is, and from when on the controller knows of it; `end` is that of the flight, s."""
    if window.end_s < end:
        text = f"{window.start_s:g} to {window.end_s:g} s"
    else:
        text = f"from {window.start_s:g} s" if window.start_s > 0.0 else "all flight"
    return text if window.known_from_s is None else f"{text}, known from {window.known_from_s:g} s"


def _named(window: FlightWindow) -> str:
    return window.name.replace("^2", "\N{SUPERSCRIPT TWO}")


def named(window: FlightWindow, end: float) -> str:
    """Return what a list calls a window, with its time; the flight ends at `end`, s."""
    return f"{_named(window)} ({_when(window, end)})"


def _cut(text: str, room: float) -> str:
    """Return as much of a text as has room, points."""
    if width_of(text, _SIZE) <= room:
        return text
    while text and width_of(f"{text}...", _SIZE) > room:
        text = text[:-1]
    return f"{text.rstrip(' .,')}..."


def _wrapped(label: str, room: int) -> str:
    """Return a label in lines of so many characters, or nothing if it does not fit."""
    parts = label.replace(" = ", "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}").split("\n")
    lines = [line for part in parts for line in textwrap.wrap(part, room, break_long_words=False)]
    if max(map(len, lines), default=0) > 1.15 * room or len(lines) > _LINES:
        return ""
    return "\n".join(lines)
