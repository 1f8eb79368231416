"""Figures of several flights of one scenario, one above the other: tracking, commands, and how plants differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uavftc.core.signals import AXES, SURFACES
from uavftc.report import panels
from uavftc.report.chatter import chatter
from uavftc.report.distance import ANGLES, RATES, attitude_difference, rate_difference, rows_in_common
from uavftc.report.figures import BAND_DEG, REFERENCE, History, deg, limits_deg, merged, name_panel
from uavftc.report.panels import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION
from uavftc.results.context import FaultWindow, FigureContext

Key = tuple[str, str]
"""(plant, controller)."""

_COLOURS = (BLUE, VERMILLION, PURPLE, GREEN, ORANGE, SKY)
_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)))


def write_overlays(folder: Path, histories: Mapping[Key, History], context: FigureContext) -> list[Path]:
    """Write tracking.png, commands.png and, of two plants or more, difference.png; return their paths.

    Parameters
    ----------
    folder
        Where to write; made if it is missing (its parent must exist).
    histories
        (plant, controller) to published columns (`signals.COLUMNS`), sampled at the same times; one may end early.
    context
        Title, limits and faults; the other fields are not used.
    """
    draw: dict[str, Callable[[Mapping[Key, History], FigureContext], Figure]] = {
        "tracking": tracking, "commands": commands
    }  # fmt: skip
    if any(_pairs(histories)):
        draw["difference"] = difference
    folder.mkdir(exist_ok=True)
    paths = []
    with panels.style():
        for name, figure in draw.items():
            paths.append(folder / f"{name}.png")
            figure(histories, context).savefig(paths[-1])
    return paths


def looks(keys: Sequence[Key]) -> dict[Key, dict[str, Any]]:
    """Return how each flight is drawn: the colour shows what there is more than one of, the dashes show the plant.

    With only one controller (or one plant), colour and dashes both show the plant (the controller).
    """
    plants, controllers = (list(dict.fromkeys(key[i] for key in keys)) for i in (0, 1))
    by = 0 if len(controllers) == 1 else 1
    colours = dict(zip((plants, controllers)[by], cycle(_COLOURS)))
    dashes = dict(zip(controllers if len(plants) == 1 else plants, cycle(_DASHES)))
    # What is drawn later lies above and is thinner, so that curves which coincide stay visible, all of them.
    return {
        (plant, controller): {
            "color": colours[(plant, controller)[by]],
            "linestyle": dashes[controller if len(plants) == 1 else plant],
            "linewidth": 3.4 * 0.66 ** controllers.index(controller) * 0.6 ** plants.index(plant),
            "zorder": 2.1 + 0.1 * plants.index(plant),
            "label": f"{plant}, {controller}",
        }
        for plant, controller in keys
    }


def tracking(histories: Mapping[Key, History], context: FigureContext) -> Figure:
    """Attitude of every flight against its reference, from trim, left; the errors against the 0.02 deg band, right."""
    fig, axes, look = _figure(histories, context, 2)
    longest = max(histories.values(), key=lambda history: len(history["time_s"]))
    for i, angle in enumerate(ANGLES):
        left, right = axes[i]
        drawn = []
        if context.controlled[i]:
            right.set_yscale("log")
        greatest = 1.0
        for key, history in histories.items():
            t, actual = history["time_s"], deg(history, f"{angle}_rad")
            if not context.controlled[i]:
                actual = np.unwrap(actual, period=360.0)
            drawn.append(panels.curve(left, t, actual - _first(actual), **look[key]))
            if not context.controlled[i]:
                continue
            error = np.abs(deg(history, f"{angle}_ref_rad") - actual)
            panels.curve(right, t, np.maximum(error, 1e-6), **look[key])
            greatest = max(greatest, float(np.max(error, initial=0.0, where=np.isfinite(error))))
        if not context.controlled[i]:
            panels.fit_y(left, drawn, least=0.5)
            name_panel(left, 2 * i, f"{AXES[i]} angle, from trim, not controlled", rf"$\{angle}$ [deg]")
            name_panel(right, 2 * i + 1, f"{AXES[i]} error", "")
            panels.absent(right, "not controlled")
            continue
        reference = deg(longest, f"{angle}_ref_rad") - _first(deg(longest, f"{angle}_rad"))
        drawn.append(panels.curve(left, longest["time_s"], reference, label="reference", **REFERENCE))
        panels.fit_y(left, drawn, least=0.5)
        name_panel(left, 2 * i, f"{AXES[i]} angle, from trim", rf"$\{angle}$ [deg]")
        right.axhspan(1e-9, BAND_DEG, color=GREEN, alpha=0.15, linewidth=0, label=f"within {BAND_DEG} deg")
        right.set_ylim(1e-3, 2.0 * greatest)
        name_panel(right, 2 * i + 1, f"{AXES[i]} error", "|error| [deg]")
        _shade((left, right), context.faults)
    panels.legends(axes)
    return fig


def commands(histories: Mapping[Key, History], context: FigureContext) -> Figure:
    """Controller output v2 of every flight, one panel a surface, with its limits."""
    fig, axes, look = _figure(histories, context, 1)
    for i, surface in enumerate(SURFACES):
        ax = axes[i, 0]
        if not context.controlled[i]:
            name_panel(ax, i, f"{surface}, commanded", "")
            panels.absent(ax, f"no {surface}")
            continue
        drawn = [
            chatter(ax, history["time_s"], deg(history, f"{surface}_cmd_rad"), **look[key])
            for key, history in histories.items()
        ]
        limits = panels.limits(ax, drawn, limits_deg(context, surface))
        panels.fit_y(ax, [*drawn, *limits], least=0.2)
        panels.cut(ax, drawn, [float(limit[0]) for limit in limits])
        name_panel(ax, i, f"{surface}, commanded", "$v_2$ [deg]")
        _shade((ax,), [fault for fault in context.faults if fault.surface == surface])
    panels.legends(axes, columns=3)
    return fig


def difference(histories: Mapping[Key, History], context: FigureContext) -> Figure:
    """Attitude, left, and body rates, right, on one plant less those on another, as long as both flew."""
    fig, axes, _ = _figure(histories, context, 2)
    pairs = _pairs(histories)
    names = [f"{a[0]} − {b[0]}: {a[1]}" for a, b in pairs]
    styles = [
        {"color": colour, "linestyle": dash, "linewidth": 3.4 * 0.66**i, "label": name}
        for i, (colour, dash, name) in enumerate(zip(cycle(_COLOURS), cycle(_DASHES), names))
    ]
    for i, (angle, rate) in enumerate(zip(ANGLES, RATES, strict=True)):
        left, right = axes[i]
        drawn: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        for (a, b), look in zip(pairs, styles, strict=True):
            one, other = histories[a], histories[b]
            t = one["time_s"][: rows_in_common(one, other)]
            curves = attitude_difference(one, other, angle), rate_difference(one, other, rate)
            for ax, y, kept in zip((left, right), curves, drawn, strict=True):
                kept.append(chatter(ax, t, y, **look))
        panels.fit_y(left, drawn[0], least=0.02)
        panels.fit_y(right, drawn[1], least=0.02)
        name_panel(left, 2 * i, f"{AXES[i]} angle, difference", rf"$\Delta\{angle}$ [deg]")
        name_panel(right, 2 * i + 1, f"{AXES[i]} rate, difference", rf"$\Delta {rate}$ [deg/s]")
        _shade((left, right), context.faults)
    panels.legends(axes, columns=1)
    return fig


def _pairs(histories: Mapping[Key, History]) -> list[tuple[Key, Key]]:
    """Return the flights of the same controller on two plants."""
    return [(a, b) for a, b in combinations(histories, 2) if a[1] == b[1]]


def _figure(
    histories: Mapping[Key, History], context: FigureContext, columns: int
) -> tuple[Figure, np.ndarray, dict[Key, dict[str, Any]]]:
    fig, axes = panels.new_figure(context.title, 3, columns, (11.0, 9.0))
    panels.fit_t(axes[0, 0], max((history["time_s"] for history in histories.values()), key=len))
    return fig, axes, looks(list(histories))


def _first(values: np.ndarray) -> float:
    return float(values[0]) if len(values) and np.isfinite(values[0]) else 0.0


def _shade(axes: Sequence[Axes], faults: Sequence[FaultWindow]) -> None:
    for ax in axes:
        panels.shade(ax, merged(faults), name="fault on a surface", written=False)
