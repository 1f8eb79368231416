"""What a scenario leaves to the aircraft, filled in."""

from __future__ import annotations

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim.model import ALTITUDE_M, TrimmedModel
from uavftc.scenario.controllers import Controller
from uavftc.scenario.schema import Initial, Scenario

NOMINAL_AIRSPEED_MPS = 30.0  # for a rotational model without one; nothing depends on it but the envelope's limits


def resolved(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None) -> Scenario:
    """Return the scenario with everything filled in that it leaves to the aircraft."""
    default = aircraft.initial
    airspeed = scenario.initial.airspeed_mps or (model.trim["airspeed"] if model else default and default.airspeed_mps)
    altitude = scenario.initial.altitude_m or (model.trim["altitude"] if model else default and default.altitude_m)
    airspeed, altitude = airspeed or NOMINAL_AIRSPEED_MPS, altitude or ALTITUDE_M
    limits = scenario.envelope
    slow, fast = limits.min_airspeed_mps, limits.max_airspeed_mps
    controller = scenario.controller
    if isinstance(controller, Controller) and getattr(controller.inner, "B_m", 0) is None:
        B_m = aircraft.analytic.B_m if aircraft.analytic else _rows(model.B_rates) if model else None
        inner = controller.inner.model_copy(update={"B_m": B_m})
        controller = controller.model_copy(update={"inner": inner})
    return scenario.model_copy(
        update={
            "initial": Initial(airspeed_mps=airspeed, altitude_m=altitude),
            "envelope": limits.model_copy(
                update={
                    "min_airspeed_mps": 0.5 * airspeed if slow is None else slow,
                    "max_airspeed_mps": 2.0 * airspeed if fast is None else fast,
                }
            ),
            "controller": controller,
        }
    )


def _rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in matrix)
