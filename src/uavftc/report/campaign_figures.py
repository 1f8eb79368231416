"""The figures of a campaign: success, margins and their differences, metrics, sensitivity, and the map.

Importing this module imports matplotlib (0.7 s), so import it where figures are drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from uavftc.core.signals import AXES
from uavftc.report import palette, panels
from uavftc.report.campaign_map import map_figure
from uavftc.report.campaign_text import headline, success_line
from uavftc.report.palette import BLACK, DARK, GREEN, GREY, ORANGE, PURPLE, VERMILLION
from uavftc.results.single import figure_metadata, write_single

OUTCOMES = {"survived": GREEN, "degraded": ORANGE, "lost": VERMILLION, "numerical": PURPLE, "error": GREY}
POINTS = 2_000  # of a distribution drawn
_FAR_APART = 100.0  # greatest over least value from which on an axis is logarithmic
_LOST = "#ebebeb"


class Data(NamedTuple):
    """The numbers that the figures draw next to the document."""

    numbers: Callable[[str], np.ndarray]
    """Gives a column of the table, shape (cases, variants)."""
    inputs: Mapping[str, tuple[np.ndarray, list[str] | None]]
    """What the two keys of the map took, shape (cases,), and the words that the numbers stand for."""
    kinds: Mapping[str, str]
    """How each of the two was drawn, such as `log-uniform`."""


def write_figures(folder: Path, document: Mapping[str, Any], data: Data, only: Collection[str]) -> list[str]:
    """Draw what there is to draw as PNG files, of the figures with these names, and return the files' names."""
    margin = data.numbers("margin")
    some = bool(np.isfinite(margin).any())
    makers: dict[str, tuple[bool, Callable[[], Figure]]] = {
        "success": (True, lambda: success_figure(document)),
        "margins": (some, lambda: margins_figure(document, margin)),
        "metrics": (bool(document["metrics"]), lambda: metrics_figure(document, data.numbers)),
        "sensitivity": (any(document["sensitivity"]["variants"].values()), lambda: sensitivity_figure(document)),
        "map": (some and bool(document["map"]), lambda: map_figure(document, margin, data.inputs, data.kinds)),
    }
    names = []
    for name, (there, make) in makers.items():
        if not there or name not in only:
            continue
        with panels.style():
            figure = make()

            def save(partial: Path, figure: Figure = figure) -> None:
                figure.savefig(partial, metadata=figure_metadata(".png"))

            write_single(folder / f"{name}.png", save)
        names.append(f"{name}.png")
    return names


def success_figure(document: Mapping[str, Any]) -> Figure:
    """Return the share of successes of each variant with its interval, and next to it how its flights ended."""
    variants = document["variants"]
    fig = Figure(figsize=(13.0, 1.9 + 0.5 * len(variants)), layout="constrained")
    left, right = fig.subplots(1, 2, sharey=True)
    looks = _looks(document)
    at = np.arange(len(variants))[::-1]
    for y, one in zip(at, variants, strict=True):
        look = looks[one["name"]]
        low, high = (100.0 * end for end in one["interval"])
        left.plot([low, high], [y, y], color=look["color"], linewidth=3.0, solid_capstyle="butt")
        if one["success"] is not None:
            left.plot(100.0 * one["success"], y, color=look["color"], marker=look["marker"], markersize=8)
        begin = 0.0
        total = sum(one["outcomes"].values())
        for name, colour in OUTCOMES.items():
            share = 100.0 * one["outcomes"].get(name, 0) / total
            right.barh(y, share, 0.62, left=begin, color=colour, linewidth=0)
            begin += share
    left.set_yticks(at, [one["name"] for one in variants])
    left.set(xlim=(-2.0, 102.0), ylim=(-0.6, len(variants) - 0.4), xlabel="flights that succeed [%], 95 % interval")
    left.set_title("(a) how often each holds")
    right.set(xlim=(0.0, 100.0), xlabel="flights [%]")
    right.set_title("(b) how its flights end")
    right.grid(False, axis="y")
    some = [name for name in OUTCOMES if any(one["outcomes"].get(name) for one in variants)]
    handles = [Patch(facecolor=OUTCOMES[name], label=name) for name in some]
    fig.legend(handles=handles, loc="outside lower right", ncols=len(some))
    fig.suptitle(f"{headline(document)}\n{success_line(document)}", fontsize=13, parse_math=False)
    return fig


def margins_figure(document: Mapping[str, Any], margin: np.ndarray) -> Figure:
    """Return the distribution of each variant's margins, and how those of two differ on the same cases."""
    pairs = document["pairs"]
    high = max(4.6, 1.9 + 0.42 * len(pairs))
    fig = Figure(figsize=(14.0 if pairs else 8.0, high + 0.6), layout="constrained")
    axes = fig.subplots(1, 2 if pairs else 1, squeeze=False)[0]
    looks = _looks(document)
    ax = axes[0]
    ax.axvspan(-2.05, -1.0, color=_LOST, zorder=0)
    ax.axvline(0.0, color=DARK, linewidth=0.9)
    for i, one in enumerate(document["variants"]):
        _distribution(ax, margin[:, i], looks[one["name"]], one["name"])
    ax.set(xlim=(min(-1.05, float(np.nanmin(margin)) - 0.05), 1.02), ylim=(-2.0, 102.0))
    ax.set(xlabel="margin; below 0 broken, grey: lost", ylabel="flights at or below [%]")
    ax.set_title("(a) margins")
    fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=min(6, len(document["variants"])))
    if pairs:
        _differences(axes[1], pairs)
    fig.suptitle(headline(document), fontsize=13, parse_math=False)
    return fig


def _differences(ax: Axes, pairs: list[dict[str, Any]]) -> None:
    """Draw of each pair the middle 50 % and 90 % of the differences, the median, and the mean with its interval."""
    at = np.arange(len(pairs))[::-1]
    for y, one in zip(at, pairs, strict=True):
        d = one["margin"]
        if not d["flights"]:
            continue
        ax.plot([d["p05"], d["p95"]], [y, y], color=GREY, linewidth=1.4)
        ax.barh(y, d["p75"] - d["p25"], 0.5, left=d["p25"], color=palette.SKY, alpha=0.55, linewidth=0)
        ax.plot([d["median"]] * 2, [y - 0.25, y + 0.25], color=BLACK, linewidth=1.8)
        ends = d["mean_interval"] or [d["mean"]] * 2
        ax.plot(ends, [y, y], color=VERMILLION, linewidth=3.0, solid_capstyle="butt")
        ax.plot(d["mean"], y, color=VERMILLION, marker="o", markersize=5)
    ax.axvline(0.0, color=DARK, linewidth=0.9)
    ax.set_yticks(at, [f"{one['first']} - {one['second']}" for one in pairs])
    ax.set_ylim(-0.6, len(pairs) - 0.4)
    ax.set_xlabel("difference of the margins on the same case")
    ax.set_title("(b) first minus second: right of 0 the first is better")
    handles = [
        Line2D([], [], color=GREY, linewidth=1.4, label="90 % of cases"),
        Patch(facecolor=palette.SKY, alpha=0.55, label="50 %"),
        Line2D([], [], color=BLACK, linewidth=1.8, label="median"),
        Line2D([], [], color=VERMILLION, linewidth=3.0, marker="o", label="mean, 95 %"),
    ]
    ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.4, -0.13), ncols=4, fontsize=11)


def metrics_figure(document: Mapping[str, Any], numbers: Callable[[str], np.ndarray]) -> Figure:
    """Return the distribution of each metric: a row a metric, a column an axis."""
    found = {(one["name"], one["axis"]): one for one in document["metrics"]}
    names = list(dict.fromkeys(name for name, _ in found))
    axes_ = [axis for axis in AXES if any((name, axis) in found for name in names)]
    fig = Figure(figsize=(4.8 * len(axes_) + 0.6, 2.55 * len(names) + 1.2), layout="constrained")
    axes = fig.subplots(len(names), len(axes_), squeeze=False, sharey=True)
    looks = _looks(document)
    for i, name in enumerate(names):
        for j, axis in enumerate(axes_):
            ax, one = axes[i, j], found.get((name, axis))
            if one is None:
                ax.set_visible(False)
                continue
            values = numbers(f"{axis}_{name}")
            for k, variant in enumerate(document["variants"]):
                _distribution(ax, values[:, k], looks[variant["name"]], variant["name"])
            positive = values[np.isfinite(values) & (values > 0.0)]
            if len(positive) and positive.max() / np.quantile(positive, 0.01) > _FAR_APART:
                ax.set_xscale("log")
                ax.set_xlim(left=float(np.quantile(positive, 0.002)) * 0.8)
            ax.set_xlabel(f"{axis} {one['label']} [{_unit(one['unit'])}]")
        axes[i, 0].set_ylabel("flights [%]")
    axes[0, 0].set_ylim(-2.0, 102.0)
    panels.legend(fig, axes)
    what = "share of the flights that have the metric, at or below"
    fig.suptitle(f"{headline(document)}\n{what}", fontsize=13, parse_math=False)
    return fig


def _unit(text: str) -> str:
    return text.replace("^2", "$^2$")


def sensitivity_figure(document: Mapping[str, Any]) -> Figure:
    """Return the index of each key on the margin of each variant; hollow where it is no more than chance gives."""
    said, keys = document["sensitivity"]["variants"], document["sensitivity"]["order"]
    names = [name for name, one in said.items() if one]
    looks = _looks(document)
    fig = Figure(figsize=(10.5, 2.0 + 0.46 * len(keys)), layout="constrained")
    ax = fig.subplots()
    at = np.arange(len(keys))[::-1]
    step = 0.66 / max(1, len(names))
    by_index = document["sensitivity"]["method"] is not None
    for k, name in enumerate(names):
        look = looks[name]
        for y, key in zip(at, keys, strict=True):
            one = said[name].get(key)
            value = None if one is None else one["index"] if by_index else one["rank_correlation"]
            if value is None:
                continue
            filled = not by_index or value > one["chance"]
            level = y + 0.33 - step * (k + 0.5)
            ax.plot([0.0, value], [level, level], color=look["color"], linewidth=1.6 if filled else 0.6)
            face = look["color"] if filled else "white"
            ax.plot(value, level, color=look["color"], marker=look["marker"], markersize=6, markerfacecolor=face)
    ax.set_yticks(at, keys)
    ax.set_ylim(-0.6, len(keys) - 0.4)
    if by_index:
        ax.set_xlim(left=0.0)
        ax.set_xlabel("PAWN index of the margin; hollow: no more than chance gives")
    else:
        ax.set_xlabel("rank correlation with the margin")
    handles = [Line2D([], [], **{**looks[name], "linestyle": "-"}, label=name) for name in names]
    fig.legend(handles=handles, loc="outside lower center", ncols=min(5, len(names)))
    fig.suptitle(f"{headline(document)}: what the margin depends on", fontsize=13, parse_math=False)
    return fig


def _distribution(ax: Axes, values: np.ndarray, look: Mapping[str, Any], label: str) -> None:
    """Draw the share of values at or below each, in percent."""
    there = np.sort(values[np.isfinite(values)])
    if not len(there):
        return
    places = np.unique(np.linspace(0, len(there) - 1, min(POINTS, len(there))).round().astype(int))
    share = 100.0 * (places + 1) / len(there)
    style = {name: value for name, value in look.items() if name != "marker"}
    style |= {"linewidth": 2.6, "zorder": 2.0} if look["linestyle"] == palette.SOLID else {"zorder": 2.1}
    ax.step(
        np.concatenate([there[:1], there[places]]), np.concatenate([[0.0], share]), where="post", **style, label=label
    )


def _looks(document: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    names = [one["name"] for one in document["variants"]]
    return palette.controllers(names)
