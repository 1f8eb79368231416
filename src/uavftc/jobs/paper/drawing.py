"""How the figures of the paper are drawn: saturation curves, tracking, control outputs, estimates."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from uavftc.analysis.metrics import CONVERGENCE_BAND_DEG
from uavftc.analysis.smooth_saturation import saturated, smooth
from uavftc.core.signals import ANGLES, AXES, RATES, SURFACES
from uavftc.jobs.campaign.pool import Flown
from uavftc.jobs.paper.captions import HEADINGS
from uavftc.report import panels
from uavftc.report.chatter import chatter
from uavftc.report.distance import attitude_difference
from uavftc.report.palette import BLACK, BLUE, DARK, DASHED, DOTTED, PURPLE, THREE, VERMILLION
from uavftc.report.panels import IDLE_DEGPS
from uavftc.report.series import column, deg
from uavftc.report.strip import mark
from uavftc.results.context import FigureContext
from uavftc.results.windows import windows_of

WIDTH_IN = 170 / 25.4  # text width of a page
_SAME_DEG = 1e-4  # curves nearer than this are the same to the eye, on every scale drawn
_PLANTS = {"jsbsim": "JSBSim", "analytic": "analytic model"}
_REFERENCE: dict[str, Any] = {"color": BLACK, "linestyle": (0, (2, 2)), "linewidth": 0.7, "zorder": 3}

Key = tuple[str, str]
"""(scenario, controller)."""


class Curve(NamedTuple):
    """One of the flights of a tracking figure, and how it is drawn."""

    key: Key
    label: str
    look: dict[str, Any]


class Panel(NamedTuple):
    """One of the four panels of a figure: a flight, one of its loops, and the title."""

    key: Key
    inner: bool
    title: str


def figure_2(h: Callable[[np.ndarray, float, float], np.ndarray] = smooth) -> Figure:
    """Return Figure 2: sat(v) and its smooth stand-in h(v, u_min, u_max), for u_max = 1 and u_min = -0.5."""
    fig = Figure(figsize=(WIDTH_IN, 2.9), layout="constrained")
    fig.suptitle(f"Figure 2. {HEADINGS[2]}".replace("v2", "$v_2$").removesuffix("."), fontsize=8.5)
    ax = fig.subplots()
    v = np.linspace(-2.0, 2.0, 801)
    ax.plot(v, saturated(v, -0.5, 1.0), color=BLUE, linewidth=1.6, label="sat($v_2$)")
    ax.plot(v, h(v, -0.5, 1.0), color=VERMILLION, linestyle=DASHED, linewidth=1.6, label="h($v_2$)")
    for limit, end, offset, edge in ((1.0, "max", 3, "bottom"), (-0.5, "min", -3, "top")):
        ax.axhline(limit, color=DARK, linestyle=DOTTED, linewidth=0.8, zorder=1)
        name = rf"$u_{{2\,\mathrm{{{end}}}}}$ = {limit:g}".replace("-", "\N{MINUS SIGN}")
        ax.annotate(name, (0.0, limit), xytext=(0, offset), textcoords="offset points", ha="center", va=edge)
    ax.set(xlim=(-2.0, 2.0), ylim=(-0.75, 1.25), xlabel="$v_2$ [-]", ylabel="sat($v_2$), h($v_2$) [-]")
    ax.legend(loc="center right")
    return fig


def tracking(number: int, flown: Mapping[Key, Flown], curves: list[Curve]) -> Figure:
    """Return Figure 3, 6 or 9: the attitude against its reference, and next to it the error on a logarithmic scale."""
    fig, axes = _figure(number, flown[curves[0].key], 3, 5.9)
    for i, (angle, axis) in enumerate(zip(ANGLES, AXES, strict=True)):
        left, right = axes[i]
        drawn = []
        for key, label, look in curves:
            history = _history(flown[key])
            t, actual = history["time_s"], deg(history, f"{angle}_rad")
            text = label + _coincides(flown, key, curves)
            drawn.append(panels.curve(left, t, actual, label=text, **look))
            error = np.abs(deg(history, f"{angle}_ref_rad") - actual)
            panels.curve(right, t, np.maximum(error, 1e-6), **look)
        first = _history(flown[curves[0].key])
        drawn.append(
            panels.curve(left, first["time_s"], deg(first, f"{angle}_ref_rad"), label="reference", **_REFERENCE)
        )
        panels.fit_y(left, drawn, least=0.5)
        band = f"error within {CONVERGENCE_BAND_DEG} deg"
        right.axhspan(1e-9, CONVERGENCE_BAND_DEG, color=PURPLE, alpha=0.15, linewidth=0, label=band)
        right.set_yscale("log")
        right.set_ylim(1e-4, 10.0)
        for ax in (left, right):
            mark(ax, _windows(flown[curves[0].key]), angle, plain=True)
        left.set_title(f"({'abc'[i]}) {axis.capitalize()} angle")
        left.set_ylabel(rf"$\{angle}$ [deg]")
        right.set_title(f"{axis.capitalize()} error")
        right.set_ylabel(rf"$|\{angle}_c - \{angle}|$ [deg]")
    _legend(fig, axes, columns=4 if len(curves) == 2 else 3)
    return fig


def control(number: int, flown: Mapping[Key, Flown], four: tuple[Panel, ...]) -> Figure:
    """Return Figure 4, 7 or 10: what the outer loop commands, deg/s, and what the inner loop commands, rad."""
    fig, axes = _figure(number, flown[four[0].key], 2, 4.3)
    labels = ("$p_c$, aileron", "$q_c$, elevator", "$r_c$, rudder")
    for i, (ax, panel) in enumerate(zip(axes.flat, four, strict=True)):
        flight = flown[panel.key]
        history = _history(flight)
        if panel.inner:
            values = [column(history, f"{surface}_cmd_rad") for surface in SURFACES]
        else:
            values = [deg(history, f"{rate}_ref_radps") for rate in RATES]
        drawn = _three(ax, history["time_s"], values, labels)
        limits = np.unique(flight.scenario.limits_rad()) if panel.inner else np.empty(0)
        limits = limits[np.isfinite(limits)]
        for limit in limits:
            ax.axhline(limit, color=DARK, linestyle=DOTTED, linewidth=0.9, label="saturation limit")
        panels.fit_y(ax, drawn, least=0.05, keep=[limits])
        panels.cut(ax, list(limits))
        _name(ax, i, panel, flight, "$v_2$ [rad]" if panel.inner else "$v_1$ [deg/s]")
    for inner in (False, True):
        _same_scale([ax for ax, panel in zip(axes.flat, four, strict=True) if panel.inner == inner])
    for ax, panel in zip(axes.flat, four, strict=True):
        mark(ax, _windows(flown[panel.key]), *SURFACES, plain=True)
    _legend(fig, axes, columns=3)
    return fig


def estimates(number: int, flown: Mapping[Key, Flown], four: tuple[Panel, ...]) -> Figure:
    """Return Figure 5, 8 or 11: the disturbance estimates of the outer loop, deg/s, and of the inner one, deg/s^2."""
    fig, axes = _figure(number, flown[four[0].key], 2, 4.3)
    for i, (ax, panel) in enumerate(zip(axes.flat, four, strict=True)):
        flight = flown[panel.key]
        history = _history(flight)
        if panel.inner:
            values = [deg(history, f"f_hat_{rate}_radps2") for rate in RATES]
        else:
            values = [deg(history, f"d1_hat_{angle}_radps") for angle in ANGLES]
        size = np.abs(np.nan_to_num(np.array(values))).max(axis=0, initial=0.0)
        idle = not panel.inner and float(size.max()) < IDLE_DEGPS
        drawn = _three(ax, history["time_s"], values, AXES, draw=panels.curve if idle else chatter)
        panels.fit_y(ax, drawn, least=0.2)
        if idle:
            panels.note(ax, panels.idle(size.max(), "deg/s"), height=0.78)
        elif size.max() > 8.0 * (usual := max(float(np.quantile(size, 0.9)), 0.1)):  # it would flatten all else
            panels.cut(ax, (-usual, usual))
        mark(ax, _windows(flight), *SURFACES, plain=True)
        _name(ax, i, panel, flight, r"$\hat f$ [deg/s$^2$]" if panel.inner else r"$\hat d_1$ [deg/s]")
    _legend(fig, axes, columns=3)
    return fig


def _figure(number: int, flight: Flown, rows: int, height_in: float) -> tuple[Figure, np.ndarray]:
    fig = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    fig.suptitle(
        f"Figure {number}. {HEADINGS[number].removesuffix('.')} ({_PLANTS[flight.scenario.plant]})", fontsize=8.5
    )
    axes = fig.subplots(rows, 2, sharex=True)
    axes[0, 0].set_xlim(0.0, flight.scenario.duration_s)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
        ax.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 5, 10]))
    return fig, axes


def _three(
    ax: Axes,
    t: np.ndarray,
    values: list[np.ndarray],
    labels: tuple[str, ...],
    draw: Callable[..., np.ndarray] = chatter,
) -> list[np.ndarray]:
    """Draw the curves of roll, pitch and yaw."""
    return [
        draw(ax, t, y, **look, linewidth=width, label=label)
        for y, label, look, width in zip(values, labels, THREE, (1.5, 1.2, 1.2), strict=True)
    ]


def _name(ax: Axes, index: int, panel: Panel, flight: Flown, unit: str) -> None:
    lost = "" if flight.outcome.completed else f", lost at {flight.outcome.ended_at_s:.1f} s"
    ax.set_title(f"({'abcd'[index]}) {panel.title}{lost}")
    ax.set_ylabel(unit)


def _coincides(flown: Mapping[Key, Flown], key: Key, curves: list[Curve]) -> str:
    """Return a remark on a curve that looks the same as the first one."""
    first = curves[0]
    if key == first.key:
        return ""
    one, other = _history(flown[first.key]), _history(flown[key])
    apart = max(float(np.max(np.abs(attitude_difference(one, other, angle)), initial=0.0)) for angle in ANGLES)
    return f" (coincides{f' with {first.label}' if len(curves) > 2 else ''})" if apart < _SAME_DEG else ""


def _windows(flight: Flown) -> FigureContext:
    """Return what is shaded in the panels of a flight."""
    return FigureContext("", windows=windows_of(flight.scenario, flight.layout))


def _same_scale(axes: list[Axes]) -> None:
    ends = np.array([ax.get_ylim() for ax in axes])
    for ax in axes:
        ax.set_ylim(ends[:, 0].min(), ends[:, 1].max())


def _legend(fig: Figure, axes: np.ndarray, columns: int) -> None:
    """Put one legend for all panels beneath them, each label once."""
    entries: dict[str, Any] = {}
    for ax in axes.flat:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    fig.legend(list(entries.values()), list(entries), loc="outside lower center", ncols=columns, handlelength=2.6)


def _history(flight: Flown) -> dict[str, np.ndarray]:
    assert flight.history is not None, "the figures need the histories"
    return flight.history
