"""The figure of the air: airspeed, altitude, flow angles, throttle, and the wind where there is any."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from uavftc.report import panels
from uavftc.report.drawn import Drawn, History
from uavftc.report.palette import ACTUAL, THREE
from uavftc.report.panels import letters
from uavftc.report.series import column, deg
from uavftc.report.strip import mark, new_figure
from uavftc.results.context import FigureContext


def air(history: History, context: FigureContext) -> Figure:
    """Airspeed, altitude, flow angles, throttle; where the air moves, its velocity and its rotation too."""
    windy = "air" in context.has
    flight = Drawn(history, context)
    fig, axes = new_figure(context, flight.t, 3 if windy else 2, 2, (11.0, 9.2 if windy else 6.6))
    speed, height, flow, throttle = axes.flat[:4]
    panels.fit_y(speed, flight.curve(speed, _plain("airspeed_mps"), **ACTUAL), least=1.0)
    letters(speed, 0, "airspeed", "[m/s]")
    mark(speed, context, "airspeed")
    panels.fit_y(height, flight.curve(height, _plain("altitude_m"), **ACTUAL), least=2.0)
    letters(height, 1, "altitude", "[m]")
    mark(height, context, "altitude")
    drawn, named = [], []
    for name, label, look in zip(("alpha", "beta"), ("angle of attack", "sideslip"), THREE, strict=False):
        text = rf"{label} $\{name}$"
        drawn += flight.curve(flow, _angle(f"{name}_rad"), label=text, **look)
        named.append(flow.lines[-1])
    panels.fit_y(flow, drawn, least=0.5)
    letters(flow, 2, "flow angles", "[deg]")
    panels.title_legend(flow, named, columns=2)
    mark(flow, context, "alpha", "beta")
    panels.fit_y(throttle, flight.curve(throttle, _plain("throttle"), **ACTUAL), least=0.1)
    letters(throttle, 3, "throttle", "[-]")
    mark(throttle, context, "throttle")
    if windy:
        wind, turning = axes[2]
        drawn = []
        for part, look in zip(("north", "east", "down"), THREE, strict=True):
            values = column(history, f"wind_{part}_mps")
            drawn.append(panels.curve(wind, flight.t, values, label=part, **look))
        panels.fit_y(wind, drawn, least=0.5)
        letters(wind, 4, "wind", "[m/s]")
        panels.title_legend(wind, wind.lines[:], columns=3)
        drawn = []
        for part, axis, look in zip("pqr", ("roll", "pitch", "yaw"), THREE, strict=True):
            values = deg(history, f"{part}_gust_radps")
            drawn.append(panels.curve(turning, flight.t, values, label=axis, **look))
        panels.fit_y(turning, drawn, least=0.5)
        letters(turning, 5, "rotation of air", "[deg/s]")
        panels.title_legend(turning, turning.lines[:], columns=3)
        if not np.nanmax(np.abs(drawn), initial=0.0):
            panels.note(turning, "this air does not turn", height=0.7)
        for ax in axes[2]:
            mark(ax, context, "wind")
    panels.legend(fig, axes)
    return fig


def _plain(name: str) -> Callable[[History], np.ndarray]:
    return lambda history: column(history, name)


def _angle(name: str) -> Callable[[History], np.ndarray]:
    return lambda history: deg(history, name)
