"""Flights for tests, each flown once a session, and plants without a controller."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.metrics import INTEGRALS, metrics_of
from uavftc.core.given import ControlDesign, Given
from uavftc.core.program import Program
from uavftc.core.signals import AXES, SURFACES, as_records, empty_rows
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


def given_of(timing: Timing, steps: int, stops_rad: np.ndarray = UNLIMITED) -> Given:
    """Return what a flight of three surfaces, one an axis, gives to its actuators."""
    design = ControlDesign(np.eye(3), np.eye(3), UNLIMITED, np.zeros(3), "test")
    return Given(timing.h, timing.plant_step, steps, 0, SURFACES, stops_rad, np.eye(3), design)


def bare(plant: Plant) -> Program:
    """Return the program of a plant without a controller: what the rows hold flies it."""
    return Program(plant.before(), plant.after(), substeps=plant.program_substeps)


def deflected(n: int, u2: Any) -> np.ndarray:
    """Return `n` rows in which each effector stands at the deflection `u2` of its axis, rad."""
    rows = empty_rows(n)
    as_records(rows)["u2"] = as_records(rows)["effectors"]["deflection"] = u2
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
