"""The figures of one flight, in the order of the paper: tracking, control outputs, estimates; and the air.

Drawn with matplotlib's object interface, which touches neither a display nor the user's settings. Importing this
module imports matplotlib (0.7 s), so import it where figures are drawn.
"""

from __future__ import annotations

import string
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uavftc.analysis.metrics import CONVERGENCE_BAND_DEG as BAND_DEG
from uavftc.core.signals import AXES, SURFACES
from uavftc.report import panels
from uavftc.report.panels import BLACK, BLUE, GREEN, PURPLE, SKY, VERMILLION
from uavftc.report.signals_figure import custom
from uavftc.results.context import FaultWindow, FigureContext

ANGLES, RATES = ("phi", "theta", "psi"), ("p", "q", "r")
_LARGEST = 1e9  # beyond it, the end of a diverged flight is not drawn: it would overflow the axes
_LETTERS = string.ascii_letters
REFERENCE = {"color": BLACK, "linestyle": (0, (5, 3)), "linewidth": 1.3, "zorder": 3}

History = Mapping[str, np.ndarray]


def write_figures(folder: Path, history: History, context: FigureContext) -> list[Path]:
    """Write tracking.png, control.png, estimates.png; with an airspeed air.png, with own signals custom.png.

    Parameters
    ----------
    folder
        Where to write; made if it is missing (its parent must exist).
    history
        Published columns (`signals.COLUMNS`), name to shape (n,), SI and rad, NaN where there is none; a column that
        is absent is drawn as empty.
    """
    draw: dict[str, Callable[[History, FigureContext], Figure]] = {
        "tracking": tracking, "control": control, "estimates": estimates
    }  # fmt: skip
    if np.isfinite(history.get("airspeed_mps", np.empty(0))).any():
        draw["air"] = air
    if context.signals:
        draw["custom"] = lambda history, context: custom(history, context, merged(context.faults))
    folder.mkdir(exist_ok=True)
    paths = []
    with panels.style():
        for name, figure in draw.items():
            paths.append(folder / f"{name}.png")
            figure(history, context).savefig(paths[-1])
    return paths


def tracking(history: History, context: FigureContext) -> Figure:
    """Attitude against its reference, left, and the error against the 0.02 deg band, right (paper, figures 3, 6, 9)."""
    t = history["time_s"]
    fig, axes = panels.new_figure(context.title, 3, 2, (11.0, 8.6))
    panels.fit_t(axes[0, 0], t)
    for i, angle in enumerate(ANGLES):
        left, right = axes[i]
        actual, reference = deg(history, f"{angle}_rad"), deg(history, f"{angle}_ref_rad")
        if not context.controlled[i]:
            actual = np.unwrap(actual, period=360.0)
            panels.fit_y(left, [panels.curve(left, t, actual, color=BLUE, label="attitude")], least=0.5)
            name_panel(left, 2 * i, f"{AXES[i]} angle, not controlled", rf"$\{angle}$ [deg]")
            name_panel(right, 2 * i + 1, f"{AXES[i]} error", "")
            panels.absent(right, "not controlled")
            continue
        drawn = [
            panels.curve(left, t, actual, color=BLUE, label="attitude"),
            panels.curve(left, t, reference, label="reference", **REFERENCE),
        ]
        panels.fit_y(left, drawn, least=0.5)
        name_panel(left, 2 * i, f"{AXES[i]} angle", rf"$\{angle}$ [deg]")

        error = np.abs(reference - actual)
        right.set_yscale("log")
        panels.curve(right, t, np.maximum(error, 1e-6), color=BLUE)
        right.axhspan(1e-9, BAND_DEG, color=GREEN, alpha=0.15, linewidth=0, label=f"within {BAND_DEG} deg")
        greatest = np.max(error, initial=1.0, where=np.isfinite(error))
        right.set_ylim(1e-3, 2.0 * greatest)
        panels.mark_entry(right, t, error, BAND_DEG)
        name_panel(right, 2 * i + 1, f"{AXES[i]} error", "|error| [deg]")
        for ax in (left, right):
            panels.shade(ax, merged(context.faults), name="fault on a surface", written=False)
    panels.legends(axes)
    return fig


def control(history: History, context: FigureContext) -> Figure:
    """Commanded and actual body rates, left; commanded and actual deflection, right (figures 4, 7, 10).

    Below, where an aircraft has other effectors than the surfaces of the axes, one panel for each.
    """
    own = {name for signal in context.signals for name in signal.columns}
    t, others = history["time_s"], effectors_of({name: y for name, y in history.items() if name not in own})
    rows = 3 + (len(others) + 1) // 2
    fig, axes = panels.new_figure(context.title, rows, 2, (11.0, 8.6 + 2.6 * (rows - 3)))
    panels.fit_t(axes[0, 0], t)
    for i, (rate, surface) in enumerate(zip(RATES, SURFACES, strict=True)):
        left, right = axes[i]
        drawn = [panels.curve(left, t, deg(history, f"{rate}_radps"), color=BLUE, label="actual")]
        if context.controlled[i]:
            command = deg(history, f"{rate}_ref_radps")
            drawn.append(panels.curve(left, t, command, label="outer-loop command $v_1$", **REFERENCE))
        panels.fit_y(left, drawn, least=0.2)
        name_panel(left, 2 * i, f"{AXES[i]} rate", f"${rate}$ [deg/s]")
        if not context.controlled[i]:
            name_panel(right, 2 * i + 1, surface, "")
            panels.absent(right, f"no {surface}")
            continue

        drawn = [
            panels.curve(
                right, t, deg(history, f"{surface}_cmd_rad"), color=VERMILLION, label="command $v_2$", linewidth=2.6
            ),
            panels.curve(
                right, t, deg(history, f"{surface}_rad"), color=BLUE, label="after limits and faults", linewidth=1.3
            ),
        ]
        windows = [w[1:4] for w in context.faults if w.surface == surface]
        drawn += panels.limits(right, drawn, limits_deg(context, surface))
        panels.fit_y(right, drawn, least=0.2, headroom=panels.shade(right, windows, name="fault"))
        name_panel(right, 2 * i + 1, surface, "deflection [deg]")
    for k, name in enumerate(others):
        ax = axes[3 + k // 2, k % 2]
        look = {"color": VERMILLION, "label": "command, trim included", "linewidth": 2.6}
        drawn = [
            panels.curve(ax, t, deg(history, f"{name}_cmd_rad"), **look),
            panels.curve(ax, t, deg(history, f"{name}_rad"), color=SKY, label="position", linewidth=1.3),
        ]
        windows = [w[1:4] for w in context.faults if w.surface == name]
        drawn += panels.limits(ax, drawn, limits_deg(context, name))
        panels.fit_y(ax, drawn, least=0.2, headroom=panels.shade(ax, windows, name="fault"))
        name_panel(ax, 6 + k, name.replace("_", " "), "position [deg]")
    if len(others) % 2:
        axes[-1, 1].set_visible(False)
        axes[-2, 1].tick_params(labelbottom=True)
    if others:  # both columns have the same curves below
        panels.legend(fig, axes, 4)
    else:
        panels.legends(axes)
    return fig


def effectors_of(history: History) -> list[str]:
    """Return the effectors in a history that are not the one surface of an axis, in their order."""
    named = (name.removesuffix("_cmd_rad") for name in history if name.endswith("_cmd_rad"))
    return [name for name in named if name not in SURFACES]


def estimates(history: History, context: FigureContext) -> Figure:
    """Disturbance estimates of both loops, and the effectiveness of each surface (figures 5, 8, 11)."""
    t = history["time_s"]
    fig, axes = panels.new_figure(context.title, 3, 3, (14.0, 8.6))
    panels.fit_t(axes[0, 0], t)
    for i, (angle, rate, surface) in enumerate(zip(ANGLES, RATES, SURFACES, strict=True)):
        outer, inner, actuator = axes[i]
        _pair(outer, t, deg(history, f"d1_hat_{angle}_radps"), deg(history, f"d1_{angle}_radps"), least=0.1)
        name_panel(outer, 3 * i, f"outer loop, {AXES[i]}", rf"$d_{{1,\{angle}}}$ [deg/s]")
        # The lumped estimate answers for all that the model lacks, so it must not be read as an error of d_2.
        look = {"label": r"lumped estimate $\hat f$: $d_2$, faults, limits, model", "color": PURPLE}
        _pair(inner, t, deg(history, f"f_hat_{rate}_radps2"), deg(history, f"d2_{rate}_radps2"), least=1.0, **look)
        name_panel(inner, 3 * i + 1, f"inner loop, {AXES[i]}", rf"$\hat f_{rate}$, $d_{{2,{rate}}}$ [deg/s$^2$]")
        for ax in (outer, inner):
            for time in context.disturbances_s:
                ax.axvline(time, color="#888888", linewidth=0.9, linestyle=":", zorder=1, label="disturbance changes")

        if not context.controlled[i]:
            name_panel(actuator, 3 * i + 2, surface, "")
            panels.absent(actuator, f"no {surface}")
            continue
        effect = panels.curve(
            actuator, t, column(history, f"effectiveness_{surface}"), color=GREEN, label="true effectiveness"
        )
        panels.fit_y(actuator, [effect, np.array([0.0, 1.0])], least=1.0)
        name_panel(actuator, 3 * i + 2, surface, r"$\omega$ [-]")
        panels.shade(actuator, [w[1:4] for w in context.faults if w.surface == surface], name="fault", written=False)
    panels.legends(axes)
    return fig


def air(history: History, context: FigureContext) -> Figure:
    """Airspeed, altitude, flow angles, and wind or throttle."""
    t = history["time_s"]
    fig, axes = panels.new_figure(context.title, 2, 2, (11.0, 6.6))
    panels.fit_t(axes[0, 0], t)
    speed, height, flow, last = axes.flat
    panels.fit_y(speed, [panels.curve(speed, t, column(history, "airspeed_mps"), color=BLUE)], least=1.0)
    name_panel(speed, 0, "airspeed", "[m/s]")
    panels.fit_y(height, [panels.curve(height, t, column(history, "altitude_m"), color=BLUE)], least=2.0)
    name_panel(height, 1, "altitude", "[m]")
    alpha, beta = deg(history, "alpha_rad"), deg(history, "beta_rad")
    drawn = [
        panels.curve(flow, t, alpha, color=BLUE, label=r"angle of attack $\alpha$"),
        panels.curve(flow, t, beta, color=VERMILLION, linestyle="--", label=r"sideslip $\beta$"),
    ]
    panels.fit_y(flow, drawn, least=0.5)
    name_panel(flow, 2, "flow angles", "[deg]")
    if context.wind:
        parts = (("north", SKY, "-"), ("east", GREEN, "--"), ("down", PURPLE, "-."))
        drawn = [
            panels.curve(
                last, t, column(history, f"wind_{part}_mps"), color=colour, linestyle=dash, label=f"wind {part}"
            )
            for part, colour, dash in parts
        ]
        panels.fit_y(last, drawn, least=0.5)
        name_panel(last, 3, "wind", "[m/s]")
    else:
        panels.fit_y(last, [panels.curve(last, t, column(history, "throttle"), color=BLUE)], least=0.1)
        name_panel(last, 3, "throttle", "[-]")
    panels.legends(axes)
    return fig


def _pair(ax: Axes, t: np.ndarray, estimate: np.ndarray, true: np.ndarray, *, least: float, **look: str) -> None:
    """Draw an estimate and the truth, on an axis of at least `least`."""
    if not np.isfinite(estimate).any():
        panels.note(ax, "this controller makes no estimate")
    drawn = [
        panels.curve(ax, t, estimate, **{"color": BLUE, "label": "estimate", **look}),
        panels.curve(ax, t, true, label="true disturbance", **REFERENCE),
    ]
    panels.fit_y(ax, drawn, least=least)


def limits_deg(context: FigureContext, surface: str) -> tuple[float, ...]:
    """Return the limits of a surface that there are, deg."""
    return tuple(np.rad2deg(limit) for limit in context.limits_rad.get(surface) or () if np.isfinite(limit))


def merged(faults: Sequence[FaultWindow]) -> list[tuple[float, float, str]]:
    """Return the times at which some surface is faulty, without overlaps."""
    spans: list[tuple[float, float, str]] = []
    for start, end in sorted((w.start_s, w.end_s) for w in faults):
        if spans and start <= spans[-1][1]:
            spans[-1] = (spans[-1][0], max(end, spans[-1][1]), "")
        else:
            spans.append((start, end, ""))
    return spans


def name_panel(ax: Axes, index: int, title: str, unit: str) -> None:
    """Give a panel its letter (by `index`), title and unit."""
    ax.set_title(f"({_LETTERS[index % len(_LETTERS)]}) {title}")
    ax.set_ylabel(unit)


def column(history: History, name: str) -> np.ndarray:
    """Return a column to draw, shape (n,): NaN where it is absent or has diverged."""
    values = history.get(name, np.full(len(history["time_s"]), np.nan))
    return np.where(np.abs(values) < _LARGEST, values, np.nan)


def deg(history: History, name: str) -> np.ndarray:
    """Return a column in rad as deg, or in rad/s as deg/s; see `column`."""
    return np.rad2deg(column(history, name))
