"""The figure of a whole flight on one page: attitude, effectors, air, way flown, and how it ended.

Of one fixed size and small, for a page that shows many of them. What happened has its number in the list at the top and
in the panels that it concerns, as in the other figures.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from uavftc.core.signals import AXES, SURFACES
from uavftc.report import panels, series
from uavftc.report.drawn import Drawn, History
from uavftc.report.palette import ACTUAL, BLACK, COMMAND, DARK, DEFLECTION, KINDS, REFERENCE, THREE
from uavftc.report.series import column, deg
from uavftc.report.strip import mark, named, width_of
from uavftc.results.context import FigureContext
from uavftc.results.windows import ANGLES, RATES

SIZE_IN, DPI = (9.0, 6.0), 100
STYLE: dict[str, Any] = {
    "figure.dpi": DPI, "savefig.dpi": DPI, "font.size": 7.5, "axes.titlesize": 8, "axes.labelsize": 7.5,
    "axes.titlepad": 3, "axes.labelpad": 2, "xtick.labelsize": 7, "ytick.labelsize": 7, "legend.fontsize": 7,
    "axes.titley": 1.0, "lines.linewidth": 1.2, "axes.linewidth": 0.7, "xtick.major.pad": 2, "ytick.major.pad": 2,
}  # fmt: skip
"""Of `panels.style`: for a figure this small."""

_MEMBERS = 2  # effectors of an axis that are drawn one by one
_LISTED, _LIST = 4, 8.0  # windows named at the top, and their size, points
_COLOURS = {"survived": "#00704f", "degraded": "#8a5a00", "lost": "#a03000", "numerical": "#7a3070"}
_LOOKS = {"linewidth": 1.2}  # of what the other figures draw wide


def overview(history: History, context: FigureContext) -> Figure:
    """Return the figure of a flight; draw and save it within `panels.style(STYLE)`.

    Parameters
    ----------
    history
        Published columns, name to shape (n,), SI and rad, NaN where there is none.
    context
        Title, how it ended, limits, effectors, windows.
    """
    flight, limiting = Drawn(history, context), context.limiting
    context = replace(context, limiting=None)  # the mark of the other figures is too large here
    fig = Figure(figsize=SIZE_IN)
    lines = _head(fig, context, series.ends(flight.t)[1])
    grid = fig.add_gridspec(
        3, 3, left=0.058, right=0.988, bottom=0.105, top=0.915 - 0.033 * lines, wspace=0.22, hspace=0.30
    )
    axes = np.array([[fig.add_subplot(grid[i, j]) for j in range(3)] for i in range(3)])
    timed = [*axes[:, 0], *axes[:, 1], *axes[:2, 2]]
    for ax in timed:
        panels.fit_t(ax, flight.t)
        ax.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=[1, 2, 5, 10]))
    for i in range(3):
        _attitude(axes[i, 0], flight, context, i)
        _surface(axes[i, 1], flight, context, i)
    if np.isfinite(column(history, "airspeed_mps")).any():
        _speed(axes[0, 2], flight, context)
        _flow(axes[1, 2], flight, context)
        _way(axes[2, 2], flight, context)
    else:  # a plant of rotation alone
        timed.append(axes[2, 2])
        panels.fit_t(axes[2, 2], flight.t)
        for i in range(3):
            _rate(axes[i, 2], flight, context, i)
    for ax in timed:
        if limiting is not None and ax.get_xlim()[0] <= limiting[1] <= ax.get_xlim()[1]:
            _limiting(ax, limiting[1])
        last = ax in (axes[2, 0], axes[2, 1], axes[2, 2])
        ax.tick_params(labelbottom=last)
        if last:
            ax.set_xlabel("time [s]")
    if timed[-1] is axes[1, 2]:  # its neighbour below has another axis
        axes[1, 2].tick_params(labelbottom=True)
    _legend(fig, axes)
    return fig


def _head(fig: Figure, context: FigureContext, end: float) -> int:
    """Write the title, how the flight ended, and what happened in it; return the lines that this took."""
    title = context.title.partition("\n")[0]
    fig.text(0.012, 0.985, title, fontsize=10, fontweight="bold", va="top", parse_math=False)
    because = ""
    if context.ending is not None:
        outcome, text = context.ending
        text, _, because = text.partition(": ")
        colour = _COLOURS.get(outcome, DARK)
        box: Any = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": colour}
        place: Any = {"va": "top", "ha": "right", "color": colour, "parse_math": False, "bbox": box}
        fig.text(0.988, 0.983, text, fontsize=9.5, fontweight="bold", **place)
    shown = [(i, w) for i, w in enumerate(context.windows, 1) if w.start_s < end or end == 0.0]
    rest, shown = len(shown) - _LISTED, shown[:_LISTED]
    columns = 1 if len(shown) == 1 else 2
    for k, (number, window) in enumerate(shown):
        x, y = 0.022 + 0.488 * (k % columns), 0.940 - 0.033 * (k // columns)
        sign = {"boxstyle": "round,pad=0.15", "facecolor": KINDS[window.kind].colour, "edgecolor": "none", "alpha": 0.6}
        look: Any = {"fontsize": _LIST, "va": "top", "parse_math": False}
        more = f"  (and {rest} more)" if k == _LISTED - 1 and rest > 0 else ""
        fig.text(x, y, f"{number}", ha="right", bbox=sign, **look)
        text = _short(named(window, end), 570 / columns - width_of(more, _LIST))
        fig.text(x + 0.009, y, text + more, ha="left", **look)
    lines = -(-len(shown) // columns)
    if because:
        text = _short(because, 630)
        fig.text(0.013, 0.940 - 0.033 * lines, text, fontsize=_LIST, va="top", color=_COLOURS["lost"], parse_math=False)
        lines += 1
    return lines


def _short(text: str, room: float) -> str:
    """Return as much of a text of the list as has room, points."""
    kept = text
    while kept and width_of(kept if kept == text else f"{kept}...", _LIST) > room:
        kept = kept[:-1]
    return kept if kept == text else f"{kept.rstrip(' .,')}..."


def _attitude(ax: Axes, flight: Drawn, context: FigureContext, i: int) -> None:
    """Draw an angle, its reference, and what the controller is shown of it."""
    angle = ANGLES[i]
    turn = 360.0 if angle == "psi" and context.controlled[i] else None

    def read(history: History) -> np.ndarray:
        values = deg(history, f"{angle}_rad")
        return values if context.controlled[i] else np.unwrap(values, period=360.0)

    drawn = flight.curve(ax, read, turn=turn, label="actual", **ACTUAL | _LOOKS)
    name = f"{AXES[i]} [deg]"
    if context.controlled[i]:
        drawn += flight.measured(ax, f"{angle}_meas_rad", turn=turn)
        look = REFERENCE | {"linewidth": 1.0}
        drawn.append(panels.curve(ax, flight.t, deg(flight.history, f"{angle}_ref_rad"), label="reference", **look))
    else:
        name = f"{AXES[i]} [deg], not controlled"
    panels.fit_y(ax, drawn, least=0.5)
    ax.set_title(name)
    mark(ax, context, angle)


def _rate(ax: Axes, flight: Drawn, context: FigureContext, i: int) -> None:
    """Draw a body rate, and what the outer loop commands."""
    rate = RATES[i]
    drawn = flight.curve(ax, lambda history: deg(history, f"{rate}_radps"), label="actual", **ACTUAL | _LOOKS)
    drawn += flight.measured(ax, f"{rate}_meas_radps")
    if context.controlled[i]:
        look = REFERENCE | {"linewidth": 1.0}
        drawn.append(panels.curve(ax, flight.t, deg(flight.history, f"{rate}_ref_radps"), label="reference", **look))
    panels.fit_y(ax, drawn, least=0.2)
    ax.set_title(f"{AXES[i]} rate [deg/s]")
    mark(ax, context, rate)


def _surface(ax: Axes, flight: Drawn, context: FigureContext, i: int) -> None:
    """Draw commands and deflections of the effectors of an axis: of its surface about trim, of others as they count."""
    surface = SURFACES[i]
    if not context.controlled[i]:
        ax.set_title(surface)
        panels.absent(ax, f"no {surface}")
        mark(ax, context)
        return
    names = [name for name in context.effectors.get(surface, ()) if f"{name}_cmd_rad" in flight.history]
    if not 0 < len(names) <= _MEMBERS:
        names = [surface]
    drawn: list[np.ndarray] = []
    kept: list[np.ndarray] = []
    for k, name in enumerate(names):
        commanded = deg(flight.history, f"{name}_cmd_rad")
        label = "command" if k == 0 else f"_{name}"
        colours = ({}, {"color": THREE[2]["color"]})[k]
        panels.curve(ax, flight.t, commanded, **COMMAND | {"linewidth": 2.0, "alpha": (1.0, 0.5)[k], "label": label})
        deflected = flight.curve(
            ax, lambda history, name=name: deg(history, f"{name}_rad"),  # type: ignore[misc]
            label="reached" if k == 0 else f"reached, {_side(name)}", **DEFLECTION | {"linewidth": 1.1} | colours,
        )  # fmt: skip
        bounds = [np.rad2deg(v) for v in context.limits_rad.get(name) or () if np.isfinite(v)]
        now = [*series.wound_up(commanded, deflected, bounds), *deflected]
        kept += panels.limits(ax, now, bounds)
        drawn += now
    panels.fit_y(ax, drawn, least=0.2, keep=kept)
    title = ", ".join(names).replace("_", " ")
    if len(names) > 1 and all(surface in name for name in names):
        title = f"{surface}s"
    ax.set_title(f"{title} [deg]")
    mark(ax, context, *names)
    ax.set_title(ax.get_title(loc="right"), loc="right", fontsize=6, color=DARK)


def _side(name: str) -> str:
    """Return a name of an effector without that of the axis."""
    for surface in SURFACES:
        name = name.replace(f"_{surface}", "").replace(f"{surface}_", "")
    return name.replace("_", " ")


def _speed(ax: Axes, flight: Drawn, context: FigureContext) -> None:
    """Draw the airspeed, or where the air moves how it changes, with the wind: to the north, to the east, down."""
    speed = column(flight.history, "airspeed_mps")
    if "air" not in context.has:
        drawn = flight.curve(ax, lambda history: column(history, "airspeed_mps"), **ACTUAL | _LOOKS)
        ax.set_title("airspeed [m/s]")
    else:
        first = float(series.finite([speed])[0])
        drawn = flight.curve(ax, lambda history: column(history, "airspeed_mps") - first, **ACTUAL | _LOOKS)
        looks = [{**THREE[1], "linewidth": 0.9}, {**THREE[2], "linewidth": 0.9}, {"color": DARK, "linewidth": 0.9}]
        for part, look in zip(("north", "east", "down"), looks, strict=True):
            values = column(flight.history, f"wind_{part}_mps")
            drawn.append(panels.curve(ax, flight.t, values, label=part[0].upper(), **look))
        ax.set_title(f"airspeed \N{MINUS SIGN} {first:.3g}, wind [m/s]")
    panels.fit_y(ax, drawn, least=1.0)
    mark(ax, context, "airspeed")
    if "air" in context.has:
        _legend_in(ax)


def _flow(ax: Axes, flight: Drawn, context: FigureContext) -> None:
    """Draw the flow angles, or where an engine fails the thrust of each."""
    engines = [name for name in flight.history if name.endswith("_thrust_n")] if "engine" in context.has else []
    if engines:
        drawn = []
        for name, look in zip(engines, THREE, strict=False):
            label = name.removesuffix("_thrust_n").replace("_", " ")
            drawn.append(panels.curve(ax, flight.t, column(flight.history, name), label=label, **look))
        ax.set_title("thrust [N]")
        panels.fit_y(ax, drawn, least=10.0)
        mark(ax, context, "throttle")
        _legend_in(ax)
        return
    drawn = []
    for name, label, look in zip(("alpha", "beta"), (r"$\alpha$", r"$\beta$"), THREE, strict=False):
        drawn += flight.curve(ax, lambda history, name=name: deg(history, f"{name}_rad"), label=label, **look)  # type: ignore[misc]
    ax.set_title("flow angles [deg]")
    panels.fit_y(ax, drawn, least=0.5)
    mark(ax, context, "alpha", "beta")
    _legend_in(ax)


def _way(ax: Axes, flight: Drawn, context: FigureContext) -> None:
    """Draw the way flown: to the east and up over that to the north; of a history without it, the altitude."""
    height = column(flight.history, "altitude_m")
    if "north_m" not in flight.history:
        panels.fit_t(ax, flight.t)
        panels.fit_y(ax, [panels.curve(ax, flight.t, height, **ACTUAL | _LOOKS)], least=2.0)
        ax.set_title("altitude [m]")
        ax.set_xlabel("time [s]")
        mark(ax, context, "altitude")
        return
    north, east = column(flight.history, "north_m"), column(flight.history, "east_m")
    up = height - series.finite([height])[0]
    drawn = [
        panels.curve(ax, north, up, label="up", **THREE[0]),
        panels.curve(ax, north, east, label="east", **THREE[1]),
    ]
    panels.fit_y(ax, drawn, least=4.0)
    ax.set_title("way flown [m]")
    ax.set_xlabel("way to the north [m]")
    _legend_in(ax)


def _limiting(ax: Axes, at: float) -> None:
    """Mark the moment that decided the verdict, s."""
    ax.axvline(at, color=BLACK, linewidth=0.8, linestyle=(0, (1, 2)), zorder=1.7)
    look: Any = {"marker": "v", "markersize": 4, "color": BLACK, "linestyle": "none", "clip_on": False, "zorder": 5}
    ax.plot([at], [1.0], transform=ax.get_xaxis_transform(), label="limiting moment", **look)


def _legend_in(ax: Axes) -> None:
    """Put a small legend above a panel, on the right, or inside where something else stands there."""
    look: Any = {"borderpad": 0.1, "handlelength": 1.3, "handletextpad": 0.4, "columnspacing": 0.8, "fontsize": 7}
    own = [one for one in ax.get_legend_handles_labels()[0] if one.get_label() != panels.WITHOUT]  # that is beneath all
    if ax.get_title(loc="right"):
        ax.legend(handles=own, loc="lower right", ncols=3, frameon=True, framealpha=0.75, edgecolor="none", **look)
    else:
        ax.legend(handles=own, loc="lower right", bbox_to_anchor=(0.985, 0.99), borderaxespad=0.0, ncols=3, **look)


def _legend(fig: Figure, axes: np.ndarray) -> None:
    """Put beneath the figure what is drawn in the first two columns, each label once."""
    entries: dict[str, Any] = {}
    for ax in axes[:, :2].ravel():
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    look: Any = {"ncols": len(entries), "columnspacing": 1.4, "handlelength": 2.2, "borderpad": 0.1}
    fig.legend(list(entries.values()), list(entries), loc="lower center", bbox_to_anchor=(0.5, 0.002), **look)
