"""Colours and line styles: one for each signal, kind of window and controller, the same in every figure.

All are told apart with every common colour vision deficiency; what shares a panel differs in grey too, by its line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

# Okabe and Ito, "Color universal design" (2008): distinct with every common colour vision deficiency.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY, DARK, WHITE = "#999999", "#555555", "#ffffff"

SOLID: Any = "-"
DASHED: Any = (0, (4, 1.6))
DOTTED: Any = (0, (1.2, 1.2))
DASHDOT: Any = (0, (5, 1.5, 1.2, 1.5))
DASHDOTDOT: Any = (0, (5, 1.3, 1.2, 1.3, 1.2, 1.3))
LONG: Any = (0, (9, 2.5))

ACTUAL: dict[str, Any] = {"color": BLUE, "linewidth": 1.9}
"""What the vehicle does: attitude, rates, airspeed, altitude."""
REFERENCE: dict[str, Any] = {"color": BLACK, "linestyle": (0, (5, 3)), "linewidth": 1.3, "zorder": 3}
"""What it should do, or the truth next to an estimate."""
MEASURED: dict[str, Any] = {"color": GREEN, "linewidth": 1.5, "linestyle": DOTTED, "zorder": 1.9}
"""What the controller is shown, where that is something else."""
COMMAND: dict[str, Any] = {"color": VERMILLION, "linewidth": 2.6}
"""What the controller commands an effector."""
DEFLECTION: dict[str, Any] = {"color": BLUE, "linewidth": 1.3}
"""Where the effector is."""
ESTIMATE: dict[str, Any] = {"color": PURPLE, "linewidth": 1.9}
TWIN: dict[str, Any] = {"color": "#7a7a7a", "linewidth": 1.0, "linestyle": (0, (2.5, 1.8)), "zorder": 1.8}
"""The same flight without faults, beneath everything."""
LIMIT: dict[str, Any] = {"color": DARK, "linewidth": 1.2, "linestyle": (0, (4, 2))}
THREE: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "linestyle": SOLID},
    {"color": VERMILLION, "linestyle": DASHED},
    {"color": GREEN, "linestyle": DASHDOT},
)
"""The components of a vector, or roll, pitch and yaw, in one panel."""
SEVERAL: tuple[dict[str, Any], ...] = (
    *THREE,
    {"color": PURPLE, "linestyle": DOTTED},
    {"color": ORANGE, "linestyle": LONG},
    {"color": SKY, "linestyle": DASHDOTDOT},
)
"""Six of a kind in one panel; the first three are `THREE`."""


class Shade(NamedTuple):
    """How the windows of a kind are shaded, and what is written on them."""

    colour: str
    dark: str
    """The same colour, dark enough to be read as a text on white."""


KINDS = {
    "fault": Shade(ORANGE, "#7a5400"),
    "engine": Shade(VERMILLION, "#8a3d00"),
    "damage": Shade(PURPLE, "#8a3f66"),
    "air": Shade(SKY, "#1a6694"),
    "disturbance": Shade(GREY, "#555555"),
    "sensor": Shade(YELLOW, "#6f6800"),
}
"""By `FlightWindow.kind`."""

ON_DARK = {
    BLACK: "#f2f2f2", BLUE: "#5aa9ff", SKY: "#a5dcff", GREEN: "#22c296", VERMILLION: "#ff8033", PURPLE: "#e394bf",
    DARK: "#b8b8b8", "#7a7a7a": "#9a9a9a",
}  # fmt: skip
"""The same colours, light enough for a dark ground; what is not here stays as it is."""

MARKED = 4  # so many flights or more have markers too: line styles alone are no longer told apart
WIDEST, THINNEST = 3.0, 1.4  # points
_CONTROLLERS = ("nndondi-l1", "ndi-l1", "nndondi-mrac", "ndi-mrac", "pid", "lqi")
_MARKERS = ("o", "s", "^", "D", "v", "P")


def controllers(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return colour, line style and marker of each controller: of those shipped always the same, of others the next.

    Beyond six, colours come again with another line style.
    """
    free = [i for i, name in enumerate(_CONTROLLERS) if name not in names]
    places = {name: _CONTROLLERS.index(name) for name in names if name in _CONTROLLERS}
    for name in names:
        if name not in places:
            places[name] = free.pop(0) if free else len(places)
    return {name: _look(places[name]) for name in names}


def in_order(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return colour, line style and marker of each of several things of a kind, in their order."""
    return {name: _look(i) for i, name in enumerate(names)}


def looks(keys: Sequence[tuple[str, str]]) -> dict[tuple[str, str], dict[str, Any]]:
    """Return how each flight, (plant, controller), is drawn: the colour shows what differs, the dashes show the plant.

    With only one controller (or one plant), colour and dashes both show the plant (the controller). A controller that
    is shipped has the same colour in every comparison.
    """
    plants, named = (list(dict.fromkeys(key[i] for key in keys)) for i in (0, 1))
    by = 0 if len(named) == 1 and len(plants) > 1 else 1
    styles = in_order(plants) if by == 0 else controllers(named)
    dashes = in_order(plants)
    found: dict[tuple[str, str], dict[str, Any]] = {}
    # What is drawn later lies above and is thinner, so that curves which coincide stay visible, all of them.
    widths = np.linspace(WIDEST, max(THINNEST, WIDEST - 0.5 * (len(keys) - 1)), len(keys))
    order = sorted(range(len(keys)), key=lambda i: plants.index(keys[i][0]))
    for place, i in enumerate(order):
        plant, controller = keys[i]
        look = dict(styles[(plant, controller)[by]])
        if len(plants) > 1:
            look["linestyle"] = dashes[plant]["linestyle"]
        marker = look.pop("marker")
        if len(keys) >= MARKED:
            look |= {"marker": marker, "markersize": 5.5}
        label = f"{plant}, {controller}" if len(plants) > 1 else controller
        look |= {"linewidth": float(widths[place]), "zorder": 2.1 + 0.01 * place, "label": label}
        found[keys[i]] = look
    return {key: found[key] for key in keys}


def _look(i: int) -> dict[str, Any]:
    n = len(SEVERAL)
    dashes = SEVERAL[(i + i // n) % n]["linestyle"]
    return {"color": SEVERAL[i % n]["color"], "linestyle": dashes, "marker": _MARKERS[i % n]}
