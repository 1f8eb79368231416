"""The figures of one flight, in the order of the paper: tracking, control outputs, estimates; and the air.

Drawn with matplotlib's object interface, which touches neither a display nor the user's settings. Importing this
module imports matplotlib (0.7 s), so import it where figures are drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from uavftc.analysis.metrics import CONVERGENCE_BAND_DEG as BAND_DEG
from uavftc.core.signals import ANGLES, AXES, RATES, SURFACES
from uavftc.report import panels, series
from uavftc.report.air_figure import air
from uavftc.report.chatter import chatter
from uavftc.report.drawn import Drawn, History
from uavftc.report.overview import STYLE, overview
from uavftc.report.palette import ACTUAL, COMMAND, DEFLECTION, ESTIMATE, GREEN, REFERENCE
from uavftc.report.panels import IDLE_DEGPS, letters
from uavftc.report.series import column, deg
from uavftc.report.signals_figure import custom
from uavftc.report.strip import mark, new_figure
from uavftc.results.context import FigureContext

TURN = 360.0


def write_figures(folder: Path, history: History, context: FigureContext) -> list[Path]:
    """Write tracking.png, control.png, estimates.png; with an airspeed air.png, with own signals custom.png.

    Parameters
    ----------
    folder
        Where to write; made if it is missing (its parent must exist).
    history
        Published columns (`signals.COLUMNS`), name to shape (n,), SI and rad, NaN where there is none; a column that
        is absent is drawn as empty.
    context
        Title, limits, windows and what else is shown next to the history.
    """
    folder.mkdir(exist_ok=True)
    return [drawing.write(folder / f"{name}.png") for name, drawing in drawings(history, context).items()]


class Drawing(NamedTuple):
    """One figure of a flight, not drawn yet."""

    function: Callable[[History, FigureContext], Figure]
    history: History
    context: FigureContext
    style: Mapping[str, Any]
    """Of `panels.style`: where it differs from the other figures."""

    def draw(self) -> Figure:
        """Return the figure."""
        with panels.style(self.style):
            return self.function(self.history, self.context)

    def write(self, file: Path) -> Path:
        """Draw it to a file, and return that."""
        with panels.style(self.style):
            self.function(self.history, self.context).savefig(file)
        return file


def drawings(history: History, context: FigureContext) -> dict[str, Drawing]:
    """Return each figure that a flight has, by its name; arguments as those of `write_figures`."""
    functions: dict[str, Callable[[History, FigureContext], Figure]] = {
        "tracking": tracking, "control": control, "estimates": estimates
    }  # fmt: skip
    if np.isfinite(history.get("airspeed_mps", np.empty(0))).any():
        functions["air"] = air
    if context.signals:
        functions["custom"] = custom
    found = {name: Drawing(function, history, context, {}) for name, function in functions.items()}
    return found | {"overview": Drawing(overview, history, context, STYLE)}


def tracking(history: History, context: FigureContext) -> Figure:
    """Attitude against its reference, left, and the error against the 0.02 deg band, right (paper, figures 3, 6, 9)."""
    flight = Drawn(history, context)
    fig, axes = new_figure(context, flight.t, 3, 2, (11.0, 8.6))
    for i, angle in enumerate(ANGLES):
        left, right = axes[i]
        if not context.controlled[i]:
            panels.fit_y(left, flight.curve(left, _unwrapped(angle), label="attitude", **ACTUAL), least=0.5)
            letters(left, 2 * i, f"{AXES[i]} angle, not controlled", rf"$\{angle}$ [deg]")
            letters(right, 2 * i + 1, f"{AXES[i]} error", "")
            panels.absent(right, "not controlled")
            mark(left, context, angle)
            mark(right, context)
            continue
        turn = TURN if angle == "psi" else None
        drawn = flight.curve(left, _read(f"{angle}_rad"), turn=turn, label="attitude", **ACTUAL)
        drawn += flight.measured(left, f"{angle}_meas_rad", turn=turn)
        reference = deg(history, f"{angle}_ref_rad")
        drawn.append(panels.curve(left, flight.t, reference, label="reference", **REFERENCE))
        panels.fit_y(left, drawn, least=0.5)
        letters(left, 2 * i, f"{AXES[i]} angle", rf"$\{angle}$ [deg]")

        right.set_yscale("log")
        flight.curve(right, _error(angle, floor=1e-6), **ACTUAL)
        right.axhspan(1e-9, BAND_DEG, color=GREEN, alpha=0.15, linewidth=0, label=f"within {BAND_DEG} deg")
        error = _error(angle)(history)
        right.set_ylim(1e-3, 2.0 * np.max(error, initial=1.0, where=np.isfinite(error)))
        letters(right, 2 * i + 1, f"{AXES[i]} error", "|error| [deg]")
        for ax in (left, right):
            mark(ax, context, angle)
        panels.mark_entry(right, flight.t, error, BAND_DEG)
    panels.legends(axes)
    return fig


def _read(name: str) -> Callable[[History], np.ndarray]:
    """Return what reads a column in rad as deg."""
    return lambda history: deg(history, name)


def _unwrapped(angle: str) -> Callable[[History], np.ndarray]:
    return lambda history: np.unwrap(deg(history, f"{angle}_rad"), period=TURN)


def _error(angle: str, floor: float = 0.0) -> Callable[[History], np.ndarray]:
    return lambda h: np.maximum(np.abs(deg(h, f"{angle}_ref_rad") - deg(h, f"{angle}_rad")), floor)


def control(history: History, context: FigureContext) -> Figure:
    """Commanded and actual body rates, left; commanded and actual deflection, right (figures 4, 7, 10).

    Below, where an aircraft has other effectors than the surfaces of the axes, one panel for each.
    """
    own = {name for signal in context.signals for name in signal.columns}
    others = effectors_of({name: y for name, y in history.items() if name not in own})
    rows = 3 + (len(others) + 1) // 2
    flight = Drawn(history, context)
    fig, axes = new_figure(context, flight.t, rows, 2, (11.0, 8.6 + 2.6 * (rows - 3)))
    for i, (rate, surface) in enumerate(zip(RATES, SURFACES, strict=True)):
        left, right = axes[i]
        drawn = flight.curve(left, _read(f"{rate}_radps"), label="actual", **ACTUAL)
        drawn += flight.measured(left, f"{rate}_meas_radps")
        if context.controlled[i]:
            command = deg(history, f"{rate}_ref_radps")
            drawn.append(panels.curve(left, flight.t, command, label="outer-loop command $v_1$", **REFERENCE))
        panels.fit_y(left, drawn, least=0.2)
        letters(left, 2 * i, f"{AXES[i]} rate", f"${rate}$ [deg/s]")
        mark(left, context, rate)
        if context.controlled[i]:
            letters(right, 2 * i + 1, surface, "deflection [deg]")
            _deflections(right, flight, context, surface, "command $v_2$", "after limits and faults")
        else:
            letters(right, 2 * i + 1, surface, "")
            panels.absent(right, f"no {surface}")
            mark(right, context)
    for k, name in enumerate(others):
        ax = axes[3 + k // 2, k % 2]
        letters(ax, 6 + k, name.replace("_", " "), "position [deg]")
        _deflections(ax, flight, context, name, "command, trim included", "position")
    if len(others) % 2:
        axes[-1, 1].set_visible(False)
        axes[-2, 1].tick_params(labelbottom=True)
    if others:  # both columns have the same curves below
        panels.legend(fig, axes)
    else:
        panels.legends(axes)
    return fig


def _deflections(ax: Axes, flight: Drawn, context: FigureContext, name: str, command: str, position: str) -> None:
    """Draw the command to a surface or effector and its deflection, with the limits and the windows that concern it."""
    commanded = chatter(ax, flight.t, deg(flight.history, f"{name}_cmd_rad"), label=command, **COMMAND)
    deflected = flight.busy(ax, _read(f"{name}_rad"), label=position, **DEFLECTION)
    bounds = limits_deg(context, name)
    drawn = [*series.wound_up(commanded, deflected, bounds), *deflected]
    panels.fit_y(ax, drawn, least=0.2, keep=panels.limits(ax, drawn, bounds))
    mark(ax, context, name, written=True)


def effectors_of(history: History) -> list[str]:
    """Return the effectors in a history that are not the one surface of an axis, in their order."""
    named = (name.removesuffix("_cmd_rad") for name in history if name.endswith("_cmd_rad"))
    return [name for name in named if name not in SURFACES]


def estimates(history: History, context: FigureContext) -> Figure:
    """Disturbance estimates of both loops, and the effectiveness of each surface (figures 5, 8, 11)."""
    flight = Drawn(history, context)
    fig, axes = new_figure(context, flight.t, 3, 3, (14.0, 8.6))
    for i, (angle, rate, surface) in enumerate(zip(ANGLES, RATES, SURFACES, strict=True)):
        outer, inner, actuator = axes[i]
        _pair(outer, flight, f"d1_hat_{angle}_radps", f"d1_{angle}_radps", least=0.1, label="estimate", observer=True)
        letters(outer, 3 * i, f"outer loop, {AXES[i]}", rf"$d_{{1,\{angle}}}$ [deg/s]")
        mark(outer, context, f"d1_{angle}")
        # The lumped estimate answers for all that the model lacks, so it must not be read as an error of d_2.
        label = r"lumped estimate $\hat f$: $d_2$, faults, limits, model"
        _pair(inner, flight, f"f_hat_{rate}_radps2", f"d2_{rate}_radps2", least=1.0, label=label)
        letters(inner, 3 * i + 1, f"inner loop, {AXES[i]}", rf"$\hat f_{rate}$, $d_{{2,{rate}}}$ [deg/s$^2$]")
        mark(inner, context, f"f_{rate}")
        if not context.controlled[i]:
            letters(actuator, 3 * i + 2, surface, "")
            panels.absent(actuator, f"no {surface}")
            mark(actuator, context)
            continue
        effect = panels.curve(
            actuator, flight.t, column(history, f"effectiveness_{surface}"), color=GREEN, label="true effectiveness"
        )
        panels.fit_y(actuator, [effect], least=1.0, keep=[np.array([0.0, 1.0])])
        letters(actuator, 3 * i + 2, surface, r"$\omega$ [-]")
        if np.all(effect == 1.0):
            panels.note(actuator, r"$\omega$ = 1 all flight")
        mark(actuator, context, surface)
    panels.legends(axes)
    return fig


def _pair(
    ax: Axes, flight: Drawn, estimated: str, truth: str, *, least: float, label: str, observer: bool = False
) -> None:
    """Draw an estimate and the truth, on an axis of at least `least`; say where nothing is estimated."""
    values = flight.busy(ax, _read(estimated), label=label, **ESTIMATE)
    true = panels.curve(ax, flight.t, deg(flight.history, truth), label="true disturbance", **REFERENCE)
    panels.fit_y(ax, [*values, true], least=least)
    found = np.abs(values[-1][np.isfinite(values[-1])])
    if not found.size:
        panels.note(ax, "this controller makes no estimate", height=0.7)
    elif observer and found.max() < IDLE_DEGPS:
        panels.note(ax, panels.idle(found.max(), "deg/s"), height=0.7)


def limits_deg(context: FigureContext, surface: str) -> tuple[float, ...]:
    """Return the limits of a surface that there are, deg."""
    return tuple(np.rad2deg(limit) for limit in context.limits_rad.get(surface) or () if np.isfinite(limit))
