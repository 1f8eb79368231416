"""The figure of a design: where the poles are, what each axis has and needs, and which surface moves what.

Importing this module imports matplotlib (0.7 s), so import it where the figure is drawn.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from uavftc.core.signals import AXES, SURFACES
from uavftc.report import panels
from uavftc.report.effectors_text import effect_text, has_table, weight_text
from uavftc.report.fleet_table import times
from uavftc.report.palette import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILLION
from uavftc.results.single import figure_metadata, write_single

LINEAR = 0.01  # 1/s and rad/s: closer to the origin the axes are linear, beyond logarithmic
FULL = 0.55  # of the greatest colour: numbers stay readable on it


def write_design_figure(file: Path, document: dict[str, Any]) -> None:
    """Draw the document of `uavftc.jobs.design.document.design_document` to a file whose ending says the format."""
    with panels.style({"svg.hashsalt": "uavftc"}):  # so that the same design gives the same bytes
        figure = design_figure(document)
        write_single(file, lambda partial: figure.savefig(partial, metadata=figure_metadata(file.suffix)))


def design_figure(document: dict[str, Any]) -> Figure:
    """Return poles (longitudinal, lateral), authority, B and, where there are more than three, each effector, drawn."""
    trim = document["trim"]
    effectors = document["effectors"] if has_table(document["effectors"]) else []
    fig = Figure(figsize=(13.0, 13.2 if effectors else 9.6), layout="constrained")
    fig.get_layout_engine().set(w_pad=0.12, h_pad=0.1)  # type: ignore[union-attr, call-arg]
    title = f"{document['aircraft']} at {trim['airspeed_mps']:g} m/s, {trim['altitude_m']:g} m: {document['verdict']}"
    fig.suptitle("\n".join([title, *document["reasons"]]), fontsize=14, fontweight="bold", parse_math=False)
    rows: list[Any] = [["longitudinal", "lateral"], ["authority", "matrix"], ["effectors"] * 2][: 3 if effectors else 2]
    heights = (1.25, 1.0, 1.0)[: len(rows)]
    axes = fig.subplot_mosaic(rows, height_ratios=heights)
    longitudinal, lateral, authority, matrix = (axes[name] for name in (*rows[0], *rows[1]))
    for letter, ax, motion in (("a", longitudinal, "longitudinal"), ("b", lateral, "lateral")):
        _poles(ax, document, motion)
        ax.set_title(f"({letter}) {motion} modes")
    _authority(authority, document)
    _matrix(matrix, document)
    if effectors:
        _effectors(axes["effectors"], effectors)
    handles, labels = longitudinal.get_legend_handles_labels()
    longitudinal.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=3)
    return fig


def _poles(ax: Axes, document: dict[str, Any], motion: str) -> None:
    """Draw the modes of one motion with their names, and the poles of the inner loop, on logarithmic axes."""
    own = [mode for mode in document["modes"] if mode["motion"] == motion]
    loop = {"A_m": (BLUE, "+"), "A_s": (VERMILLION, "x")}
    poles = {name: np.array([complex(*pair) for pair in document[f"eigenvalues_{name}"]]) for name in loop}
    values = np.array([complex(*mode["eigenvalue"]) for mode in own])
    everything = np.concatenate([values, *poles.values()])
    for name, (colour, marker) in loop.items():
        upper = poles[name][poles[name].imag >= 0.0]
        ax.plot(
            upper.real, upper.imag, linestyle="none", marker=marker, markersize=11, markeredgewidth=2.2, color=colour,
            label=f"${name}$ of the inner loop", zorder=3,
        )  # fmt: skip
    ax.plot(
        values.real, values.imag, linestyle="none", marker="o", markersize=8, color=BLACK, label="aircraft", zorder=4
    )
    left, right = 8.0 * min(everything.real.min(), -1.0), max(8.0 * everything.real.max(), 0.03)
    top = 30.0 * max(everything.imag.max(), 0.1)
    ax.set_xscale("symlog", linthresh=LINEAR, linscale=0.5)
    ax.set_yscale("symlog", linthresh=LINEAR, linscale=0.5)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "\N{MINUS SIGN}"))
        axis.set_minor_locator(NullLocator())
    ax.set_xlim(left, right)
    ax.set_ylim(-8.0 * LINEAR, top)  # the lower half plane mirrors the upper one; below zero there is room for names
    ax.set_yticks([0.0, *(v for v in 10.0 ** np.arange(-2, 4) if v < top)])
    ax.axvspan(0.0, right, color=VERMILLION, alpha=0.08, linewidth=0, zorder=0)
    ax.axvline(0.0, color="#555555", linewidth=1.0)
    ax.axhline(0.0, color="#555555", linewidth=1.0)
    ax.set_xlabel("real part [1/s]")
    ax.set_ylabel("imaginary part [rad/s]")
    real = 0
    for mode in sorted(own, key=lambda mode: mode["eigenvalue"][0]):
        x, y = mode["eigenvalue"]
        offset, vertical = (0, 13), "bottom"
        if not y:  # on the axis: above and beneath in turn, clear of each other and of the crosses
            offset, vertical = ((0, 16), "bottom") if real % 2 == 0 else ((0, -16), "top")
            real += 1
        ax.annotate(
            _label(mode), (x, y), xytext=offset, textcoords="offset points", ha="center", va=vertical, fontsize=11,
            linespacing=1.1, annotation_clip=False,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "alpha": 0.8, "linewidth": 0},
        )  # fmt: skip


def _label(mode: dict[str, Any]) -> str:
    name = mode["name"].replace(" (", "\n(")
    if mode["eigenvalue"][1]:
        return f"{name}\n{mode['natural_frequency_radps']:.3g} rad/s, ζ = {mode['damping']:.2f}"
    time = mode["time_constant_s"]
    if time is None:
        return name
    return f"{name}\n{'T' if time > 0 else 'grows, T'} = {abs(time):.3g} s"


def _authority(ax: Axes, document: dict[str, Any]) -> None:
    """Draw the deflection that each axis has, and within it what the step needs at once and to be held."""
    authority = document["authority"]
    step = math.degrees(max(authority["step_rad"]))
    ax.set_title(f"(c) authority, available over needed, for {step:g} deg")
    ax.set_xlabel("deflection to the nearer limit [deg]")
    ax.set_yticks(range(3), [f"{axis}\n({surface})" for axis, surface in zip(AXES, SURFACES, strict=True)])
    ax.set_ylim(2.6, -0.6)
    ax.grid(False, axis="y")
    if all(authority[axis] is None for axis in AXES):
        panels.note(ax, "not every axis answers to its surface")
        return
    nothing = {"available_rad": 0.0, "first_rad": 0.0, "steady_rad": 0.0}
    has, first, steady = (
        np.degrees([(authority[axis] or nothing)[f"{name}_rad"] for axis in AXES])
        for name in ("available", "first", "steady")
    )
    ax.barh(range(3), has, 0.7, color="#dddddd", label="available")
    ax.barh(range(3), first, 0.36, color=BLUE, label="needed at once")
    ax.barh(range(3), steady, 0.36, left=first, color=ORANGE, label="needed to hold the bank")
    widest = min(np.max(np.maximum(has, first + steady)), max(3.0 * np.max(has), 0.1))
    for j, axis in enumerate(AXES):
        if authority[axis] is None:
            ax.text(0.0, j, f" no {SURFACES[j]}: left to the airframe", va="center", color="#555555", zorder=5)
            continue
        ratio, end = authority[axis]["ratio"], min(max(has[j], first[j] + steady[j]), widest)
        colour = BLACK if ratio >= 1.0 else VERMILLION
        ax.text(end, j, f" {times(ratio)}", va="center", fontweight="bold", color=colour, zorder=5)
    ax.set_xlim(0.0, 1.35 * widest)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, columnspacing=1.2, handlelength=1.4)


def _matrix(ax: Axes, document: dict[str, Any]) -> None:
    """Write B, coloured by how much of an axis' own surface each of the others amounts to."""
    B = np.array(document["B"])
    own = np.maximum(np.abs(np.diag(B)), 1e-3 * max(np.max(np.abs(B)), 1e-12))
    share = np.minimum(np.abs(B) / own[:, None], 1.0)
    found = document["controllability"]
    condition = "none" if found["condition"] is None else f"{found['condition']:.3g}"
    ax.set_title(f"(d) B, 1/s$^2$ per rad: condition {condition}, rank {found['rank']} of {found['axes']}")
    ax.set_aspect("auto")
    for i, j in np.ndindex(3, 3):
        colour = GREEN if i == j else SKY
        ax.add_patch(_cell(i, j, colour, FULL * share[i, j]))
        text = f"{B[i, j]:.3g}" if abs(B[i, j]) >= 5e-4 else "0"
        ax.text(j, i, text.replace("-", "\N{MINUS SIGN}"), ha="center", va="center", fontsize=14)
    ax.set_xlim(-0.5, 2.5)
    ax.set_ylim(2.5, -0.5)
    ax.set_xticks(range(3), list(SURFACES))
    ax.set_yticks(range(3), [rf"$\dot {rate}$" for rate in "pqr"])
    ax.tick_params(length=0)
    ax.grid(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)


def _effectors(ax: Axes, effectors: list[dict[str, Any]]) -> None:
    """Write what each effector does at full deflection, coloured by its share of the strongest about the axis."""
    reach = np.array([max(map(abs, e["limits_rad"])) for e in effectors])
    full = np.array([[e["B"][f"{rate}_dot"] for e in effectors] for rate in "pqr"]) * reach
    strongest = np.maximum(np.max(np.abs(full), axis=1), 1e-12)
    ax.set_title("(e) what each effector does at its further limit, rad/s$^2$; below it, deflection per axis command")
    size = 13 if len(effectors) <= 8 else max(8, 18 - len(effectors) // 2)
    for i, j in np.ndindex(full.shape):
        colour = ORANGE if full[i, j] < 0.0 else BLUE
        ax.add_patch(_cell(i, j, colour, FULL * abs(full[i, j]) / strongest[i]))
        weight = weight_text(effectors[j]["per_axis_command"][AXES[i]])
        ax.text(j, i - 0.12, _minus(effect_text(full[i, j], strongest[i])), ha="center", va="center", fontsize=size)
        ax.text(j, i + 0.26, _minus(weight), ha="center", va="center", fontsize=size - 3, color="#555555")
    ax.set_xlim(-0.5, len(effectors) - 0.5)
    ax.set_ylim(2.5, -0.5)
    turned = {"rotation": 20, "ha": "right"} if max(len(e["name"]) for e in effectors) * len(effectors) > 100 else {}
    ax.set_xticks(range(len(effectors)), [e["name"] for e in effectors], **turned)  # type: ignore[arg-type]
    ax.set_yticks(range(3), [f"{axis}, $\\dot {rate}$" for axis, rate in zip(AXES, "pqr", strict=True)])
    ax.tick_params(length=0)
    ax.grid(False)
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)


def _minus(text: str) -> str:
    return "\N{EN DASH}" if text == "-" else text.replace("-", "\N{MINUS SIGN}")


def _cell(row: int, column: int, colour: str, alpha: float) -> Any:
    from matplotlib.patches import Rectangle  # noqa: PLC0415

    return Rectangle((column - 0.48, row - 0.46), 0.96, 0.92, facecolor=colour, alpha=alpha, linewidth=0)
