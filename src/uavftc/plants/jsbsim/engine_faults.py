"""Faults of engines in JSBSim: a gain and an offset on the throttle position, and an engine shut down.

In a flight with such a fault, the copy that JSBSim loads has one more channel at the end of <flight_control>. JSBSim
runs <system>s first, then <autopilot>, then <flight_control>, each in the order of its file, and then the engines: what
this channel makes of fcs/throttle-pos-norm[j] is what engine j gets, whatever set it before. With gain 1 and offset 0
it is the same to the bit.

A lost engine is stopped as well. What stops it depends on its kind, measured on JSBSim 1.3.3: a piston engine that the
air turns starts again unless its magnetos are off; a turbine and a turboprop spool up again without cutoff; an electric
motor and a rocket have nothing but their throttle. Everything that an aircraft has of these is written. Whether its
thrust then falls to zero or below is tried before the flight, at the trim, and refused where it does not.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from uavftc.actuators.engine import Change
from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim import engines
from uavftc.plants.jsbsim.copy import Addition
from uavftc.plants.jsbsim.engines import throttle_position
from uavftc.plants.jsbsim.events import Event, Schedule, Told, row_at
from uavftc.plants.jsbsim.load import initialised
from uavftc.plants.jsbsim.model import TrimmedModel, read, written
from uavftc.plants.jsbsim.plant import INTEGRATORS
from uavftc.plants.jsbsim.trim import Trim, freeze, start

SECTION = "flight_control"
LOST_S = 30.0
"""Time within which the thrust of a lost engine has fallen to `NONE`, at the airspeed of the trim."""
NONE = 1e-6  # N
SOME = 0.123  # throttle that nothing else sets
LOSS = Change(gain=0.0, stopped=True)


class EngineChange(NamedTuple):
    """A fault of an engine as the plant takes it."""

    engine: int
    """In JSBSim, from 0."""
    change: Change
    start_s: float
    end_s: float | None


def _gain(engine: int) -> str:
    return f"uavftc/engine-gain[{engine}]"


def _held(engine: int) -> str:
    return f"uavftc/engine-held[{engine}]"


def channel(engine: int) -> Addition:
    """Return the channel that scales and holds the throttle position of an engine."""
    position, gain, held = throttle_position(engine), _gain(engine), _held(engine)
    value = f"<product><property>{position}</property><property>{gain}</property></product><property>{held}</property>"
    return Addition(
        SECTION,
        f'<property value="1">{gain}</property><property value="0">{held}</property>'
        f'<channel name="uavftc-engine-{engine}"><fcs_function name="uavftc/engine-throttle[{engine}]">'
        f"<function><sum>{value}</sum></function><output>{position}</output></fcs_function></channel>",
    )


def told(faults: Sequence[EngineChange], rate_hz: float) -> Told:
    """Return what JSBSim is told of the faults of its engines; at most one at a time acts on an engine."""
    events: list[Event] = []
    for fault in sorted(faults, key=lambda f: f.start_s):  # one may begin where another ends
        events += begun(fault, row_at(fault.start_s, rate_hz))
        if fault.end_s is not None:
            events += ended(fault, row_at(fault.end_s, rate_hz))
    return Told(tuple(events), tuple(channel(j) for j in sorted({fault.engine for fault in faults})))


ACTIVE, ALL = "propulsion/active_engine", -1.0
SWITCHES = {"propulsion/magneto_cmd": (0.0, 3.0), "propulsion/cutoff_cmd": (1.0, 0.0)}
"""Of the engine that is active: what stops it, and what lets it run."""


def begun(fault: EngineChange, row: int) -> list[Event]:
    """Return what is written at the beginning of a fault."""
    j, change = fault.engine, fault.change
    held = throttle_position(j) if change.held is None else change.held
    events = [Event(row, _held(j), held), Event(row, _gain(j), change.gain)]
    return [*events, *(_switched(j, row, running=False) if change.stopped else [])]


def ended(fault: EngineChange, row: int) -> list[Event]:
    """Return what is written at the end of a fault: all as it was before."""
    j = fault.engine
    events = [Event(row, _held(j), 0.0), Event(row, _gain(j), 1.0)]
    return [*events, *(_switched(j, row, running=True) if fault.change.stopped else [])]


def _switched(engine: int, row: int, *, running: bool) -> list[Event]:
    switches = [Event(row, name, ends[running], where_it_exists=True) for name, ends in SWITCHES.items()]
    return [
        Event(row, ACTIVE, float(engine)),
        *switches,
        Event(row, ACTIVE, ALL),
        Event(row, f"propulsion/engine[{engine}]/set-running", float(running), where_it_exists=True),
    ]


def is_last(aircraft: Aircraft, model: TrimmedModel, engine: int) -> bool:
    """Whether nothing sets the throttle position of an engine after the channel, which is what it then has.

    Flight controls in a file of their own, <flight_control file="...">, run after what stands in the main file.
    """
    return _is_last(aircraft, aircraft.sha256(), model.frame_s, engine)


@functools.lru_cache(maxsize=64)
def _is_last(aircraft: Aircraft, _checksum: str, frame_s: float, engine: int) -> bool:
    fdm = initialised(aircraft, frame_s, [channel(engine)])
    fdm[_gain(engine)], fdm[_held(engine)] = 0.0, SOME
    for _ in range(2):
        fdm.run()
    return bool(fdm[throttle_position(engine)] == SOME)


class Tried(NamedTuple):
    """A lost engine at the trim, its airspeed held."""

    after_s: float | None
    """When it pulls no more, s; None if it goes on pulling."""
    before_n: float
    """Its thrust at the trim, N."""
    left_n: float
    """Its thrust then, or after `LOST_S`, N."""


def tried(aircraft: Aircraft, model: TrimmedModel, engine: int) -> Tried:
    """Return what becomes of the thrust of a lost engine, the vehicle held at its trim; once for each trim."""
    return _tried(aircraft, aircraft.sha256(), json.dumps(written(model)), engine)


@functools.lru_cache(maxsize=64)
def _tried(aircraft: Aircraft, _checksum: str, text: str, engine: int) -> Tried:
    model = read(json.loads(text))
    fdm = initialised(aircraft, model.frame_s, [channel(engine)])
    start(fdm, aircraft, Trim(**model.trim), np.zeros(3), INTEGRATORS)
    freeze(fdm)
    before = float(engines.thrust(fdm)[engine])
    Schedule(fdm, begun(EngineChange(engine, LOSS, 0.0, None), 0)).write(0)
    for k in range(round(LOST_S / model.frame_s)):
        fdm.run()
        left = float(engines.thrust(fdm)[engine])
        if left <= NONE:
            return Tried((k + 1) * model.frame_s, before, left)
    return Tried(None, before, left)
