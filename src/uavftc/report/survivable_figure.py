"""The figure of `uavftc survivable`: what is attainable against the severity of the fault, and at which airspeeds.

Importing this module imports matplotlib (0.7 s), so import it where the figure is drawn.
"""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from uavftc.report import panels
from uavftc.report.palette import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILLION
from uavftc.results.single import figure_metadata, write_single

LOOKS = {"roll": (BLUE, "-"), "pitch": (ORANGE, "--"), "yaw": (GREEN, "-.")}
DRAWN = (0.0, 0.3, 0.6, 1.0)
"""Shares of the fault whose moments are outlined."""
BENEATH: dict[str, Any] = {
    "loc": "upper center",
    "bbox_to_anchor": (0.5, -0.17),
    "columnspacing": 1.2,
    "handlelength": 1.5,
}
NONE = "none at the reference"


def write_survivable_figure(file: Path, document: dict[str, Any]) -> None:
    """Draw the document of `uavftc.jobs.survivable.document.document_of` to a PNG file."""
    with panels.style():
        figure = survivable_figure(document)
        write_single(file, lambda partial: figure.savefig(partial, metadata=figure_metadata(file.suffix)))


def survivable_figure(document: dict[str, Any]) -> Figure:
    """Return bank, pitch, authority and moments against severity, and the airspeeds, as far as there are any."""
    severity, speeds = document["severity"], document["airspeeds"]
    rows: list[list[str]] = []
    if severity is not None:
        if any(point["bank_rad"] or point["pitch_rad"] for point in severity["points"]):
            rows.append(["bank", "pitch"])
        rows.append(["authority", "moments"])
    if speeds is not None:
        rows.append(["speeds", "speeds"])
    heights = [0.32 if row[0] == "speeds" else 1.0 for row in rows]
    fig = Figure(figsize=(15.0, 1.4 + 4.9 * sum(heights)), layout="constrained")
    fig.get_layout_engine().set(w_pad=0.12, h_pad=0.1)  # type: ignore[union-attr, call-arg]
    fig.suptitle(_title(document), fontsize=14, fontweight="bold", parse_math=False)
    axes = fig.subplot_mosaic(rows, height_ratios=heights)  # type: ignore[arg-type]
    letters = iter("abcde")
    reference = document["phases"][document["limiting"]]["reference"]
    for name in ("bank", "pitch"):
        if name in axes:
            other = "pitch" if name == "bank" else "bank"
            held = f"{math.degrees(reference[f'{other}_rad']):.3g} deg of {other}"
            axes[name].set_title(f"({next(letters)}) {name} that can be steady, at {held}")
            _span(axes[name], severity, name, reference)
    if severity is not None:
        axes["authority"].set_title(f"({next(letters)}) authority left, of that without the fault")
        _authority(axes["authority"], severity)
        axes["moments"].set_title(f"({next(letters)}) attainable moments; balanced where 0, 0 is inside")
        _moments(axes["moments"], severity)
    if speeds is not None:
        axes["speeds"].set_title(f"({next(letters)}) airspeeds at which the reference has a steady state")
        _speeds(axes["speeds"], speeds, document["airspeed_mps"])
    return fig


def _title(document: dict[str, Any]) -> str:
    phase = document["phases"][document["limiting"]]
    answer = "a steady state exists" if phase["survivable"] else "no steady state"
    head = f"{document['scenario']}: {Path(document['aircraft']).name}, {document['plant']}"
    what = ", ".join(phase["active"]) or "no fault"
    when = f"{phase['start_s']:g} to {phase['end_s']:g} s: {answer} at the reference"
    return "\n".join([f"{head}, {when}", *textwrap.wrap(what, 110)[:2]])


def _span(ax: Axes, severity: dict[str, Any], name: str, reference: dict[str, float]) -> None:
    """Draw the least and greatest angle that has a steady state, and the reference."""
    points = severity["points"]
    share = np.array([point["share"] for point in points])
    edges = np.concatenate([share[:1], 0.5 * (share[1:] + share[:-1]), share[-1:]])
    at, label = math.degrees(reference[f"{name}_rad"]), "steady, airspeed held"
    for k, point in enumerate(points):
        for piece in point[f"{name}_rad"]:
            low, high = map(math.degrees, piece)
            ax.fill_between(edges[k : k + 2], low, high, color=SKY, alpha=0.45, linewidth=0, label=label)
            ax.plot([share[k]] * 2, [low, high], color=BLUE, marker="o", markersize=4, linewidth=1.0)
            label = ""
    ax.axhline(at, color=BLACK, linestyle="--", label=f"reference, {at:.3g} deg")
    ax.set_ylabel(f"{name} [deg]")
    _shares(ax, severity)
    low, high = ax.get_ylim()
    room = max(0.15 * (high - low), 4.0 - 0.5 * (high - low))
    ax.set_ylim(low - room, high + room)
    ax.legend(**BENEATH, ncols=3)


def _authority(ax: Axes, severity: dict[str, Any]) -> None:
    """Draw the weaker side of each axis."""
    points = severity["points"]
    share = np.array([point["share"] for point in points])
    for axis, (colour, line) in LOOKS.items():
        left = [math.nan if point["authority"] is None else _weaker(point["authority"][axis]) for point in points]
        ax.plot(share, left, color=colour, linestyle=line, marker="o", markersize=4, label=axis)
    ax.set_ylabel("left of the weaker side [%]")
    ax.set_ylim(-5.0, max(110.0, ax.get_ylim()[1]))
    _shares(ax, severity)
    ax.legend(**BENEATH, ncols=4)


def _weaker(authority: dict[str, float | None]) -> float:
    sides = [authority[f"{side}_share"] for side in ("negative", "positive")]
    return math.nan if None in sides else 100.0 * min(side for side in sides if side is not None)


def _shares(ax: Axes, severity: dict[str, Any]) -> None:
    """Set the axis of the severity, and shade where there is no steady state at the reference."""
    ax.set_xlabel("severity: 0 without the fault, 1 as in the scenario")
    ax.set_xlim(-0.02, 1.02)
    points = severity["points"]
    share = np.array([point["share"] for point in points])
    edges = np.concatenate([share[:1], 0.5 * (share[1:] + share[:-1]), [1.02]])
    if (ends := severity["ends_between"]) is not None:  # found more closely than by the shares tried
        first = next(k for k, point in enumerate(points) if not point["survivable"])
        edges[first] = ends[0]
        ax.axvline(ends[0], color=VERMILLION, linewidth=1.2)
    label = NONE
    for k, point in enumerate(points):
        if not point["survivable"]:
            span = edges[k : k + 2]
            ax.axvspan(*span, color=VERMILLION, alpha=0.08, linewidth=0, label=label, zorder=0)
            label = ""


def _moments(ax: Axes, severity: dict[str, Any]) -> None:
    """Draw what roll and yaw can be made, at some shares of the fault."""
    points = severity["points"]
    for point in (point for point in points if min(abs(point["share"] - share) for share in DRAWN) < 1e-9):
        corners = np.degrees(np.array(point["roll_yaw_radps2"] or [[0.0, 0.0]], dtype=float))
        corners = np.vstack([corners, corners[:1]])
        part = point["share"]
        colour = tuple((1.0 - part) * np.array([0.0, 0.447, 0.698]) + part * np.array([0.835, 0.369, 0.0]))
        ax.plot(corners[:, 0], corners[:, 1], color=colour, label=f"{part:.2g}", marker="o", markersize=3.5)
    ax.plot(0.0, 0.0, marker="+", markersize=13, markeredgewidth=2.2, color=BLACK, linestyle="none")
    ax.set_xlabel(r"roll, $\dot p$ [deg/s$^2$]")
    ax.set_ylabel(r"yaw, $\dot r$ [deg/s$^2$]")
    ax.legend(**BENEATH, ncols=len(DRAWN), title="severity")


COLOURS = {"steady": GREEN, "attitude": SKY, None: VERMILLION}
LABELS = {"steady": "steady", "attitude": "attitude steady, airspeed changes", None: NONE}


def _speeds(ax: Axes, speeds: dict[str, Any], here: float) -> None:
    """Draw at which airspeeds there is a steady state, with the faults and without."""
    v = np.array([point["airspeed_mps"] for point in speeds["points"]])
    edges = np.concatenate([v[:1], 0.5 * (v[1:] + v[:-1]), v[-1:]])
    kinds = []
    for y, key in ((1, "level_without_faults"), (0, "level")):
        for i, point in enumerate(speeds["points"]):
            kinds.append(point[key])
            ax.barh(y, edges[i + 1] - edges[i], 0.6, left=edges[i], color=COLOURS[point[key]], alpha=0.75, linewidth=0)
    ax.axvline(here, color=BLACK, linestyle="--")
    ax.set_yticks([1, 0], ["without faults", "as in the phase"])
    ax.set_ylim(-0.5, 1.5)
    ax.set_xlim(v[0], v[-1])
    ax.grid(False, axis="y")
    ax.set_xlabel("airspeed [m/s]; dashed: that of the scenario")
    shown = [Patch(facecolor=COLOURS[k], alpha=0.75, label=LABELS[k]) for k in COLOURS if k in kinds]
    ax.legend(handles=shown, loc="upper center", bbox_to_anchor=(0.5, -0.5), ncols=3)
