"""What a flight can show to its controller beside attitude and rates."""

from __future__ import annotations

from math import cos, sin
from typing import Any

import numpy as np

from uavftc.control.custom.measured import STANDARD_GRAVITY, Aboard
from uavftc.core.given import Given
from uavftc.core.layout import Layout
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.scenario.schema import Scenario

SEA_LEVEL = 1.225  # kg/m^3, ISO 2533; near enough for a trial, which needs a number of the right size


def aboard_of(scenario: Scenario, given: Given, model: TrimmedModel | None, layout: Layout) -> Aboard:
    """Return what the controller may ask for; the air of a trimmed JSBSim aircraft, and none on the analytic plant."""
    columns = frozenset(column.name for column in layout.columns)
    air = air_at_trim(model) if model is not None and scenario.plant == "jsbsim" else None
    return Aboard(given, layout.shown_sign, air, columns, len(layout.engines))


def air_at_trim(model: TrimmedModel) -> dict[str, Any]:
    """Return what of `measured.MEASURED` the plant measures in the air, as it is at the trim."""
    trim = model.trim
    phi, theta, airspeed = trim["phi"], trim["theta"], trim["airspeed"]
    return {
        "airspeed": airspeed,
        "alpha": trim["alpha"],
        "beta": trim.get("beta", 0.0),
        "dynamic_pressure": 0.5 * SEA_LEVEL * airspeed**2,
        "throttle": trim["throttle"],
        "accelerations": STANDARD_GRAVITY * np.array([sin(theta), -sin(phi) * cos(theta), -cos(phi) * cos(theta)]),
        "altitude": trim["altitude"],
    }
