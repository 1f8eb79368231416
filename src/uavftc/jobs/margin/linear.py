"""The margins of the linear loop, for the laws that are linear, to hold next to those that were flown.

The plant is the linear pair of the trim, sampled with its input held; its limits, faults and disturbances play no part.
JSBSim moves a surface one plant step later than the analytic plant, which the delay margin then has less.
"""

from __future__ import annotations

import math

import numpy as np

from uavftc.analysis.loop_margins import held, loop_margins
from uavftc.control.custom.module import SHIPPED
from uavftc.control.whole import lqi, pid
from uavftc.core.statespace import StateSpace
from uavftc.flight.build import build_flight
from uavftc.scenario.controllers import CustomController
from uavftc.scenario.schema import Scenario

LINEAR = {"pid": pid, "lqi": lqi}


def linear_margins(scenario: Scenario) -> dict[str, float]:
    """Return `delay`, s, `gain` and `gain_reduction` of a scenario's loop; empty where its law is not linear."""
    controller = scenario.controller
    if not isinstance(controller, CustomController) or controller.kind not in SHIPPED:
        return {}
    flight = build_flight(scenario)
    if not all(flight.given.axes):
        return {}
    law, design, h = LINEAR[controller.kind], flight.given.design, flight.given.h
    plant = held(rotation(design.A, design.B, design.x1_trim), h)
    margins = loop_margins(plant, law.linear(design, h, controller.options), h)
    if not margins.stable:
        return {}
    late = flight.given.plant_step if flight.given.at_end else 0.0
    found = {
        "delay": max(0.0, float(margins.delay_s) - late),
        "gain": float(margins.gain),
        "gain_reduction": float(margins.gain_reduction),
    }
    return {name: value for name, value in found.items() if math.isfinite(value) and value > 0.0}


def rotation(A: np.ndarray, B: np.ndarray, x1_trim: np.ndarray) -> StateSpace:
    """Return x1' = g1 x2, x2' = A x2 + B u2 about the trim, from u2 to [x1, x2]; A in 1/s, B in 1/s^2."""
    F = np.zeros((6, 6))
    F[:3, 3:] = np.linalg.inv(pid.rates_from_euler(x1_trim))
    F[3:, 3:] = A
    return StateSpace(F, np.vstack([np.zeros((3, 3)), B]), np.eye(6), np.zeros((6, 3)))
