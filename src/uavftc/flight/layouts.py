"""The effectors of a flight: as measured at the trim, or as the companion file claims them."""

from __future__ import annotations

import math

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import mixing_of
from uavftc.core.layout import Layout
from uavftc.core.signals import SURFACES
from uavftc.flight.rotational import moments_per_rad
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.scenario.schema import Scenario


def layout_of(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None) -> Layout:
    """Return the effectors, as measured at the trim or, where there is no trimmed model, as the companion file has."""
    moments = moments_per_rad(scenario, aircraft, model)
    if model is None:
        return claimed_layout(aircraft)._replace(moments=moments)
    effectors = model.effectors
    flown = scenario.plant == "jsbsim"
    sign = [math.copysign(1.0, e.position_rad) if flown and e.position is not None else 0.0 for e in effectors]
    return Layout(
        names=model.names,
        mixing=np.array(model.mixing),
        gangs=model.gangs,
        trim_rad=np.array([e.trim_rad for e in effectors]),
        position_sign=np.array(sign),
        read=np.array([flown and not e.ideal and e.position is not None for e in effectors]),
        sense=np.array([math.copysign(1.0, e.position_rad) if e.position is not None else 1.0 for e in effectors]),
        engines=tuple(model.engine_order) if flown and model.engines else (),
        moments=moments,
    )


def claimed_layout(aircraft: Aircraft) -> Layout:
    """Return the effectors of a companion file; the trim of its rotational model is zero."""
    names = tuple(aircraft.named_effectors())
    gangs = aircraft.gangs or {name: {name: 1.0} for name in names if name in SURFACES}
    nothing = np.zeros(len(names))
    return Layout(names, mixing_of(names, gangs), gangs, nothing, nothing, nothing.astype(bool), nothing + 1.0)


def claimed_stops(aircraft: Aircraft) -> np.ndarray:
    """Return least and greatest deflection of each effector of a companion file, rad, shape (n, 2)."""
    stops = np.array([s.stop_rad or np.inf for s in aircraft.named_effectors().values()])
    return np.column_stack([-stops, stops])
