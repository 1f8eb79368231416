"""Figures of several flights of one scenario, one above the other: tracking, commands, and how plants differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from uavftc.core.signals import ANGLES, AXES, RATES, SURFACES
from uavftc.report import palette, panels
from uavftc.report.chatter import chatter
from uavftc.report.distance import attitude_difference, rate_difference, rows_in_common
from uavftc.report.drawn import History
from uavftc.report.figures import BAND_DEG, TURN, limits_deg
from uavftc.report.palette import GREEN, REFERENCE, THINNEST, WIDEST, looks
from uavftc.report.panels import letters
from uavftc.report.series import deg, wound_up
from uavftc.report.strip import mark, new_figure
from uavftc.results.context import FigureContext

Key = tuple[str, str]
"""(plant, controller)."""

_MARKERS = 8  # of a curve


def write_overlays(folder: Path, histories: Mapping[Key, History], context: FigureContext) -> list[Path]:
    """Write tracking.png, commands.png and, of two plants or more, difference.png; return their paths.

    Parameters
    ----------
    folder
        Where to write; made if it is missing (its parent must exist).
    histories
        (plant, controller) to published columns (`signals.COLUMNS`), sampled at the same times; one may end early.
    context
        Title, limits and windows; a limiting moment and a twin, which are those of one flight, are not drawn.
    """
    folder.mkdir(exist_ok=True)
    paths = []
    for name, draw in drawings(histories, context).items():
        paths.append(folder / f"{name}.png")
        with panels.style():
            draw().savefig(paths[-1])
    return paths


def drawings(histories: Mapping[Key, History], context: FigureContext) -> dict[str, Callable[[], Figure]]:
    """Return what draws each figure, by its name, within `panels.style()`; arguments as those of `write_overlays`."""
    plants = list(dict.fromkeys(plant for plant, _ in histories))
    title = context.title if len(plants) > 1 else f"{context.title}, {plants[0]}"
    context = replace(context, title=title, limiting=None, twin=None)
    found: dict[str, Callable[[Mapping[Key, History], FigureContext], Figure]] = {
        "tracking": tracking, "commands": commands
    }  # fmt: skip
    if any(_pairs(histories)):
        found["difference"] = difference
    return {name: partial(draw, histories, context) for name, draw in found.items()}


def tracking(histories: Mapping[Key, History], context: FigureContext) -> Figure:
    """Attitude of every flight against its reference, from trim, left; the errors against the 0.02 deg band, right."""
    fig, axes, look = _figure(histories, context, 2)
    longest = max(histories.values(), key=lambda history: len(history["time_s"]))
    for i, angle in enumerate(ANGLES):
        left, right = axes[i]
        turn = TURN if angle == "psi" else None
        drawn = []
        if context.controlled[i]:
            right.set_yscale("log")
        greatest = 1.0
        for key, history in histories.items():
            t, actual = history["time_s"], deg(history, f"{angle}_rad")
            if not context.controlled[i]:
                actual = np.unwrap(actual, period=TURN)
            drawn.append(panels.curve(left, t, actual - _first(actual), turn=turn, **look[key]))
            if not context.controlled[i]:
                continue
            error = np.abs(deg(history, f"{angle}_ref_rad") - actual)
            panels.curve(right, t, np.maximum(error, 1e-6), **look[key])
            greatest = max(greatest, float(np.max(error, initial=0.0, where=np.isfinite(error))))
        if not context.controlled[i]:
            panels.fit_y(left, drawn, least=0.5)
            letters(left, 2 * i, f"{AXES[i]} angle, from trim, not controlled", rf"$\{angle}$ [deg]")
            letters(right, 2 * i + 1, f"{AXES[i]} error", "")
            panels.absent(right, "not controlled")
            mark(left, context, angle)
            continue
        reference = deg(longest, f"{angle}_ref_rad") - _first(deg(longest, f"{angle}_rad"))
        drawn.append(panels.curve(left, longest["time_s"], reference, label="reference", **REFERENCE))
        panels.fit_y(left, drawn, least=0.5)
        letters(left, 2 * i, f"{AXES[i]} angle, from trim", rf"$\{angle}$ [deg]")
        right.axhspan(1e-9, BAND_DEG, color=GREEN, alpha=0.15, linewidth=0, label=f"within {BAND_DEG} deg")
        right.set_ylim(1e-3, 2.0 * greatest)
        letters(right, 2 * i + 1, f"{AXES[i]} error", "|error| [deg]")
        for ax in (left, right):
            mark(ax, context, angle)
    panels.legend(fig, axes)
    return fig


def commands(histories: Mapping[Key, History], context: FigureContext) -> Figure:
    """Controller output v2 of every flight, one panel a surface, with its limits."""
    fig, axes, look = _figure(histories, context, 1)
    for i, surface in enumerate(SURFACES):
        ax = axes[i, 0]
        if not context.controlled[i]:
            letters(ax, i, f"{surface}, commanded", "")
            panels.absent(ax, f"no {surface}")
            continue
        drawn, shown = [], []
        limits = limits_deg(context, surface)
        for key, history in histories.items():
            drawn.append(chatter(ax, history["time_s"], deg(history, f"{surface}_cmd_rad"), **look[key]))
            shown += wound_up(drawn[-1], [deg(history, f"{surface}_rad")], limits)
        panels.fit_y(ax, shown, least=0.2, keep=panels.limits(ax, shown, limits))
        letters(ax, i, f"{surface}, commanded", "$v_2$ [deg]")
        mark(ax, context, surface)
    panels.legend(fig, axes)
    return fig


def difference(histories: Mapping[Key, History], context: FigureContext) -> Figure:
    """Attitude, left, and body rates, right, on one plant less those on another, as long as both flew."""
    fig, axes, _ = _figure(histories, context, 2)
    pairs = _pairs(histories)
    names = [f"{a[0]} − {b[0]}: {a[1]}" for a, b in pairs]
    looked = palette.controllers([a[1] for a, _ in pairs]) if len({a[1] for a, _ in pairs}) == len(pairs) else None
    looked = palette.in_order(names) if looked is None else dict(zip(names, looked.values(), strict=True))
    styles = [
        {**looked[name], "marker": None, "linewidth": max(THINNEST, WIDEST - 0.5 * i), "label": name}
        for i, name in enumerate(names)
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
        letters(left, 2 * i, f"{AXES[i]} angle, difference", rf"$\Delta\{angle}$ [deg]")
        letters(right, 2 * i + 1, f"{AXES[i]} rate, difference", rf"$\Delta {rate}$ [deg/s]")
        mark(left, context, angle)
        mark(right, context, rate)
    panels.legend(fig, axes)
    return fig


def _pairs(histories: Mapping[Key, History]) -> list[tuple[Key, Key]]:
    """Return the flights of the same controller on two plants."""
    return [(a, b) for a, b in combinations(histories, 2) if a[1] == b[1]]


def _figure(
    histories: Mapping[Key, History], context: FigureContext, columns: int
) -> tuple[Figure, np.ndarray, dict[Key, dict[str, Any]]]:
    longest = max((history["time_s"] for history in histories.values()), key=len)
    fig, axes = new_figure(context, longest, 3, columns, (11.0, 9.0))
    look = looks(list(histories))
    step = max(1, min(len(longest), panels.THINNED) // _MARKERS)
    for i, one in enumerate(look.values()):
        one["markevery"] = (int(step * (i + 0.5) / len(look)), step)
    return fig, axes, look


def _first(values: np.ndarray) -> float:
    return float(values[0]) if len(values) and np.isfinite(values[0]) else 0.0
