"""Flights for tests, each flown once a session, and plants without a controller."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.metrics import INTEGRALS, metrics_of
from uavftc.core.given import ControlDesign, Given
from uavftc.core.layout import Layout
from uavftc.core.program import Program
from uavftc.core.signals import AXES, as_records, empty_rows
from uavftc.flight.build import Flight, build_flight
from uavftc.flight.fly import Outcome, fly_to_memory
from uavftc.plants.interface import Plant, Timing
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.scenario.load import load_scenario

if TYPE_CHECKING:
    from uavftc.plants.jsbsim.plant import JSBSimPlant


@functools.cache
def flown(
    scenario: str, plant: str = "jsbsim", controller: str | None = None, overrides: tuple[str, ...] = ()
) -> tuple[Flight, np.ndarray, Outcome]:
    """Return (flight, records, outcome) of a shipped scenario."""
    flight = build_flight(load_scenario(scenario, plant=plant, controller=controller, overrides=overrides))
    records, outcome = fly_to_memory(flight)
    records.setflags(write=False)
    return flight, records, outcome


def jsbsim_plant(
    aircraft: Aircraft,
    timing: Timing | None = None,
    *,
    airspeed: float = 30.0,
    altitude: float = 1000.0,
    **options: Any,
) -> JSBSimPlant:
    """Return an aircraft at its trim: in still air, without a moment input, unless `options` say otherwise."""
    from uavftc.plants.jsbsim.plant import JSBSimPlant  # only the tests that fly JSBSim import it

    given = {"wind_n": np.zeros(3), "has_wind": False, "has_moment": False} | options
    return JSBSimPlant(aircraft, trimmed_model(aircraft, airspeed, altitude), timing or Timing(0.005, 1), **given)


UNLIMITED = np.array([[-np.inf, np.inf]] * 3)


HALE_GANGS = {
    "aileron": {"left_aileron": 1.0, "right_aileron": -1.0}, "elevator": {"elevator": 1.0}, "rudder": {"rudder": 1.0}
}  # fmt: skip
HALE = Layout(
    names=("left_aileron", "right_aileron", "elevator", "rudder"),
    mixing=np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    gangs=HALE_GANGS,
    trim_rad=np.zeros(4),
)
"""The effectors of hale."""


def given_of(timing: Timing, steps: int, stops_rad: np.ndarray | None = None, layout: Layout | None = None) -> Given:
    """Return what a flight gives to its actuators; of three surfaces, one an axis, where `layout` says nothing else."""
    layout = layout or Layout()
    stops = np.array([[-np.inf, np.inf]] * len(layout.names)) if stops_rad is None else stops_rad
    design = ControlDesign(np.eye(3), np.eye(3), UNLIMITED, np.zeros(3), "test")
    own = (layout.names, stops, layout.mixing, design, layout.gangs, layout.trim_rad)
    return Given(timing.h, timing.plant_step, steps, 0, *own)


def bare(plant: Plant) -> Program:
    """Return the program of a plant without a controller: what the rows hold flies it."""
    return Program([*plant.before(), *plant.given()], plant.after(), substeps=plant.program_substeps)


def deflected(n: int, u2: Any, layout: Layout | None = None) -> np.ndarray:
    """Return `n` rows in which each effector stands as the deflection `u2` of its axis, rad, wants it."""
    layout = layout or Layout()
    rows = empty_rows(n, len(layout.names))
    as_records(rows)["u2"] = u2
    as_records(rows)["effectors"]["deflection"] = np.broadcast_to(u2, (n, 3)) @ layout.mixing.T
    return rows


def integrals(scenario: str, plant: str, overrides: tuple[str, ...] = (), controller: str | None = None) -> np.ndarray:
    """Return IAE, ISE, ITAE, ITSE (columns) of roll, pitch, yaw (rows), shape (3, 4)."""
    _, records, outcome = flown(scenario, plant, controller, overrides)
    assert outcome.completed
    metrics = metrics_of(records)
    return np.array([[metrics[axis][name] for name in INTEGRALS] for axis in AXES], dtype=float)


def largest_difference(a: np.ndarray, b: np.ndarray) -> float:
    """Return the largest relative difference between two tables."""
    return float(np.max(np.abs(a / b - 1.0)))
