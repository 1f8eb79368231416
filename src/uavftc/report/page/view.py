"""What the moving view of a page shows: attitude, way and moving surfaces over the time, and what is read at it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.core.layout import Layout
from uavftc.core.signals import ANGLES, AXES, SURFACES
from uavftc.report.page.packed import packed
from uavftc.report.page.signals import TURN
from uavftc.report.series import column, deg
from uavftc.results.windows import FlightWindow

MAX_SAMPLES = 2_000
SPAN_M = 10.0  # of an aircraft that does not say it

PARTS = ("left_aileron", "right_aileron", "left_elevator", "right_elevator", "rudder")
"""Surfaces of the sketch. Their angle is that of the trailing edge: down, of the rudder to the right."""


class Sketch(NamedTuple):
    """The aircraft as the view draws it: a sketch with its wing span and the surfaces of its axes."""

    layout: Layout = Layout()
    span_m: float = SPAN_M


def view_of(
    history: Mapping[str, np.ndarray], windows: Sequence[FlightWindow], sketch: Sketch, samples: int = MAX_SAMPLES
) -> dict[str, Any]:
    """Return the samples of the view, evenly over the flight, and for each part of the sketch the windows on it.

    Angles in deg, places in m from the start: north, east, up.
    """
    n = len(history["time_s"])
    rows = np.unique(np.round(np.linspace(0, n - 1, min(n, samples))).astype(int))

    def sent(values: np.ndarray) -> dict[str, str]:
        return packed(np.asarray(values, dtype=float)[rows].astype("<f4"))

    height = column(history, "altitude_m")
    has_way = "north_m" in history and np.isfinite(column(history, "north_m")).any()
    way = {}
    if has_way:
        way = {"north": sent(column(history, "north_m")), "east": sent(column(history, "east_m"))}
        way["up"] = sent(height - height[np.isfinite(height)][0])
    angles = {a: np.unwrap(deg(history, f"{a}_rad"), period=TURN) for a in ANGLES}
    return {
        "t": sent(history["time_s"]),
        **{angle: sent(values) for angle, values in angles.items()},
        **way,
        "span": sketch.span_m,
        "parts": {
            part: {"angle": sent(values), "windows": _on(names, windows)}
            for part, (values, names) in _parts(history, sketch.layout).items()
        },
        "read": [
            {"name": name, "unit": unit, "digits": digits, "y": sent(values)}
            for name, unit, digits, values in _read(history)
            if np.isfinite(values).any()
        ],
    }


def _read(history: Mapping[str, np.ndarray]) -> list[tuple[str, str, int, np.ndarray]]:
    found = [(f"{axis} angle", "deg", 2, deg(history, f"{a}_rad")) for axis, a in zip(AXES, ANGLES, strict=True)]
    found += [(f"{s}, about trim", "deg", 2, deg(history, f"{s}_rad")) for s in SURFACES]
    found += [
        ("airspeed", "m/s", 2, column(history, "airspeed_mps")),
        ("altitude", "m", 1, column(history, "altitude_m")),
        ("angle of attack α", "deg", 2, deg(history, "alpha_rad")),
        ("sideslip β", "deg", 2, deg(history, "beta_rad")),
        ("load factor", "g", 2, column(history, "load_factor")),
    ]
    return found


def _on(names: Sequence[str], windows: Sequence[FlightWindow]) -> list[int]:
    """Return the numbers of the faults of surfaces, and of damage, that concern one of these effectors."""
    kinds = ("fault", "damage")
    return [i for i, w in enumerate(windows, 1) if w.kind in kinds and w.concerns.intersection(names)]


def _parts(history: Mapping[str, np.ndarray], layout: Layout) -> dict[str, tuple[np.ndarray, tuple[str, ...]]]:
    """Return the angle of each part of the sketch, deg, and the effectors that it stands for.

    An effector of an axis that has a side in its name moves that side alone; what has none moves both. The sense is
    that of the moment which the axis gets: to roll to the right, the left aileron goes down.
    """
    moments = np.diag(layout.moments) if layout.moments is not None else np.array([1.0, -1.0, 1.0])
    sense = np.where(moments < 0.0, -1.0, 1.0)  # of a positive deflection: rolls right, pitches up, turns right
    found = {}
    for part in PARTS:
        side, _, surface = part.rpartition("_")
        axis = SURFACES.index(surface)
        members = tuple(name for name in layout.gangs.get(surface, ()) if not side or _side(name) in (side, ""))
        of_axis = deg(history, f"{surface}_rad")
        own = [_about_trim(history, layout, name, axis) for name in members if name not in SURFACES]
        known = [values for values in own if values is not None]
        turned = np.mean(known, axis=0) if known else of_axis
        down = {"left_aileron": 1.0, "right_aileron": -1.0, "rudder": 1.0}.get(part, -1.0)
        found[part] = (np.nan_to_num(down * sense[axis] * turned), members or (surface,))
    return found


def _side(name: str) -> str:
    return next((side for side in ("left", "right") if side in name.lower()), "")


def _about_trim(history: Mapping[str, np.ndarray], layout: Layout, name: str, axis: int) -> np.ndarray | None:
    """Return the deflection of an effector about trim, deg, positive as a positive command of the axis turns it."""
    if f"{name}_rad" not in history or name not in layout.names:
        return None
    j = layout.names.index(name)
    counted = deg(history, f"{name}_rad") / float(layout.shown_sign[j]) - float(np.rad2deg(layout.trim_rad[j]))
    sign = float(np.sign(layout.mixing[j, axis]))
    return sign * counted if sign else None
