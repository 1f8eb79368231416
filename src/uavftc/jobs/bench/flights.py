"""What is flown in the benchmarks."""

from __future__ import annotations

import functools

import numpy as np

from uavftc.flight.build import Flight, build_flight
from uavftc.flight.fly import fly, fly_to_memory
from uavftc.flight.recorder import Recorder
from uavftc.jobs.bench.measure import NotMeasuredError
from uavftc.plants.jsbsim.plant import JSBSimPlant
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario


@functools.cache
def scenario(name: str, *, plant: str | None = None, aircraft: str | None = None) -> Scenario:
    """Return a shipped scenario."""
    return load_scenario(name, plant=plant, aircraft=aircraft)


def level(duration_s: float, plant: str = "jsbsim") -> Scenario:
    """Return a level flight of hale: reference zero, nothing disturbed, 200 Hz."""
    return Scenario.model_validate(
        {
            "name": "level",
            "duration_s": duration_s,
            "plant": plant,
            "aircraft": "hale",
            "reference": {"phi_deg": 0, "theta_deg": 0, "psi_deg": 0},
        }
    )


def jsbsim_plant(flight: Flight) -> JSBSimPlant:
    """Return the flight's plant, which must be JSBSim."""
    assert isinstance(flight.plant, JSBSimPlant)
    return flight.plant


def fly_all_of(flight: Flight, *recorders: Recorder) -> float:
    """Fly to the end and return the seconds of the loop alone.

    Raises
    ------
    NotMeasuredError
        If the vehicle is lost on the way: the time of another flight says nothing about this one.
    KeyboardInterrupt
        After Ctrl-C, which a flight by itself only takes as its end.
    """
    outcome = fly(flight, recorders)
    if not outcome.completed:
        raise NotMeasuredError(f"the flight did not reach its end: {outcome.ended_because}")
    return outcome.wall_s


@functools.cache
def flown(name: str, plant: str) -> np.ndarray:
    """Return the history of a shipped scenario, shape (n,), dtype `signals.ROW`."""
    records, _ = fly_to_memory(build_flight(scenario(name, plant=plant)))
    return records
