"""The vehicle of a phase as equations: what its six accelerations are at rest in a state, on either plant.

Unknowns are those of `State` (airspeed, incidence, sideslip, bank, pitch, turn, throttle), then c of each effector
(`Reach`). The rotational model has no flow and no forces: of its six equations the first three are always met.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.actuators.at_rest import Reach
from uavftc.actuators.engine import place_of
from uavftc.analysis.equilibrium import System
from uavftc.core.layout import shares
from uavftc.flight import uncertain
from uavftc.flight.build import Flight, rotational_model
from uavftc.jobs.survivable.phases import Sampled, rates_of
from uavftc.plants.analytic import of_another_inertia, struck_model
from uavftc.plants.interface import State
from uavftc.plants.rigid_body import coefficients, gyroscopic

EQUATIONS = ("thrust and drag", "side force", "lift", "roll moment", "pitch moment", "yaw moment")
UNITS = ("m/s^2",) * 3 + ("rad/s^2",) * 3
FORWARD = 0
EVERY = (0, 1, 2, 3, 4, 5)
ATTITUDE = (1, 2, 3, 4, 5)
"""All but that of the airspeed."""
MOMENTS = (3, 4, 5)

ALPHA_RAD = (-0.25, 0.45)
BETA_RAD = (-0.5, 0.5)
TURN_RADPS = (-0.5, 0.5)
MOST_RAD = math.radians(80.0)
"""Of bank and pitch."""
SIZE = np.array([5.0, 0.05, 0.05, 0.1, 0.1, 0.1, 0.3])
DEFLECTION = 0.1
SCALE = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
TOLERANCE = 1e-6
"""m/s^2 and rad/s^2, on each equation."""
COARSE = 2e-3
"""Where engines burn fuel and nothing is ever at rest."""


class Vehicle(NamedTuple):
    """A vehicle with some damage and some faults of engines, as equations."""

    system: System
    """Over all unknowns, for a reach without limits; the limits of a case are put in by `with_reach`."""
    stops: np.ndarray
    """Shape (n, 2), rad about trim: a floating surface goes no further."""
    trim: np.ndarray
    """Unknowns at the trim."""
    has_flow: bool
    """Whether there are forces, and so an incidence, a sideslip and an airspeed."""
    powered: bool
    """Whether a throttle moves the thrust."""
    trusted: dict[int, tuple[float, float]]
    """Range of incidence and sideslip that the aircraft is trusted in, rad, by the place of the unknown."""
    loads: Callable[[Sampled], np.ndarray]
    """loads(seen) -> the angular accelerations, shape (N, 3), rad/s^2, that disturbances make of N samples."""
    raw: Any
    """f(x, deflections) -> accelerations, and the same before engines have changed speed or None."""

    @property
    def rows(self) -> tuple[int, ...]:
        """Equations of a steady state."""
        return EVERY if self.has_flow else MOMENTS

    @property
    def attitude_rows(self) -> tuple[int, ...]:
        """Equations of an attitude that is held."""
        return ATTITUDE if self.has_flow else MOMENTS

    def with_reach(self, reach: Reach, load: np.ndarray) -> System:
        """Return the equations for what effectors reach, with an angular acceleration `load`, (3,), rad/s^2, added."""
        f, near = self.raw
        added = np.concatenate([np.zeros(3), load])

        def deflections(x: np.ndarray) -> np.ndarray:
            moved = reach.at(x[State.COUNT :], float(x[State.ALPHA]), float(x[State.BETA]))
            return np.clip(moved, *self.stops.T)

        s = self.system
        return s._replace(
            f=lambda x: f(x, deflections(x)) + added,
            near=None if near is None else (lambda x: near(x, deflections(x)) + added),
            low=np.concatenate([s.low, reach.low]),
            high=np.concatenate([s.high, reach.high]),
            size=np.concatenate([s.size, np.full(len(reach.low), DEFLECTION)]),
        )

    def free_surfaces(self, reach: Reach) -> list[int]:
        """Return the places of those effectors among the unknowns that a command moves."""
        return [State.COUNT + int(j) for j in np.flatnonzero(reach.high > reach.low)]


def vehicle_of(
    flight: Flight,
    damage: Sequence[Any] = (),
    engines: Sequence[Any] = (),
    *,
    share: float = 1.0,
    throttles: Sequence[float] = (),
) -> Vehicle:
    """Return the vehicle of a flight with damage and faults of engines, entries of the scenario, at a share of each.

    `throttles` of each fault of an engine: where it found the throttle, 0..1.
    """
    parts = [part for entry in damage if (part := entry.part(share)) is not None]
    parts = [part for part in parts if part.changes_mass or part.acts]
    if flight.scenario.plant == "analytic":
        return _rotational(flight, parts)
    return _on_jsbsim(flight, parts, engines, share, throttles)


def _on_jsbsim(
    flight: Flight, damage: Sequence[Any], engines: Sequence[Any], share: float, throttles: Sequence[float]
) -> Vehicle:
    from uavftc.actuators import ENGINES  # noqa: PLC0415
    from uavftc.plants.jsbsim import uncertainty  # noqa: PLC0415
    from uavftc.plants.jsbsim.balance import Held  # noqa: PLC0415 - each plant is imported only where it is asked
    from uavftc.plants.jsbsim.engine_faults import EngineChange  # noqa: PLC0415

    model = flight.model
    assert model is not None  # every JSBSim aircraft is flown from a trimmed model
    changes = []
    for entry in engines if share > 0.0 else ():
        (effect,) = (effect for effect in ENGINES if isinstance(entry, effect.Config))
        change, place = effect.change(entry), place_of(entry.engine, model.engine_order)
        assert place is not None  # the flight was built
        held = change.held if change.held is None else share * change.held
        gain = change.gain if change.held is None else 1.0 - share * (1.0 - change.gain)
        change = change._replace(gain=gain, held=held, stopped=change.stopped and share >= 1.0)
        changes.append(EngineChange(place, change, 0.0, None))
    told = uncertainty.told(flight.aircraft, flight.scenario.uncertainty, flown_of(flight).factors)
    held = Held(flight.aircraft, model, damage, changes, throttles if changes else (), told)
    trim, limits = held.trim, flight.scenario.envelope
    bank, pitch = (min(math.radians(limit), MOST_RAD) for limit in (limits.bank_deg, limits.pitch_deg))
    powered = model.engines > 0 and trim.method != "glide" and bool(trim.throttles)
    fixed = (0.0, 1.0) if powered else (trim.throttle, trim.throttle)
    speeds = (limits.min_airspeed_mps or 0.5 * trim.airspeed, limits.max_airspeed_mps or 2.0 * trim.airspeed)
    bounds = np.array([speeds, ALPHA_RAD, BETA_RAD, (-bank, bank), (-pitch, pitch), TURN_RADPS, fixed])
    burns = trim.way != "running"
    system = System(
        held.accelerations,  # type: ignore[arg-type]
        bounds[:, 0],
        bounds[:, 1],
        SIZE,
        SCALE,
        np.full(6, COARSE if burns else TOLERANCE),
        slow=(State.AIRSPEED, State.THROTTLE),
    )
    n = len(model.effectors)
    start = np.array([trim.airspeed, trim.alpha, trim.beta, trim.phi, trim.theta, 0.0, trim.throttle, *np.zeros(n)])
    k = State.COUNT
    return Vehicle(
        system,
        np.array([e.limits_rad for e in model.effectors]),
        start,
        has_flow=True,
        powered=powered,
        trusted=_trusted(flight),
        loads=lambda seen: seen.d2 @ held.turned.T,
        raw=(lambda x, u: held.accelerations(x[:k], u), lambda x, u: held.nearby(x[:k], u)),
    )


def flown_of(flight: Flight) -> uncertain.Vehicle:
    """Return the vehicle that flies, where a scenario says that it is not the nominal one."""
    return uncertain.vehicle_of(flight.scenario, flight.aircraft, flight.model)


def _rotational(flight: Flight, damage: Sequence[Any]) -> Vehicle:
    inertia, A_l, B_m = rotational_model(flight.aircraft, flight.model)
    inertia, A_l, B_m = of_another_inertia(inertia, A_l, B_m, flight.scenario.uncertainty.inertia(inertia))
    now, A, B = struck_model(inertia, A_l, B_m, damage)
    c, share = coefficients(now), shares(flight.layout.mixing)
    start = np.zeros(State.COUNT + len(flight.layout.names))
    start[[State.BANK, State.PITCH]] = flight.plant.x1_trim[:2]
    start[State.AIRSPEED] = flight.scenario.initial.airspeed_mps or 0.0

    def turning(attitude: np.ndarray, turn: float, d1: np.ndarray) -> np.ndarray:
        x2 = rates_of(attitude, turn, d1)
        return np.array(gyroscopic(c, x2)) + A @ x2

    def f(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        attitude = np.array([x[State.BANK], x[State.PITCH], 0.0])
        return np.concatenate([np.zeros(3), turning(attitude, float(x[State.TURN]), np.zeros(3)) + B @ (share.T @ u)])

    def loads(seen: Sampled) -> np.ndarray:
        nothing, every = np.zeros(3), zip(seen.attitude, seen.turn, seen.d1, strict=True)
        by_d1 = [turning(a, t, d1) - turning(a, t, nothing) for a, t, d1 in every]
        return seen.d2 + np.array(by_d1)

    fixed = start[: State.COUNT]
    system = System(
        f,  # type: ignore[arg-type]
        fixed - np.array([0, 0, 0, MOST_RAD, MOST_RAD, TURN_RADPS[1], 0]),
        fixed + np.array([0, 0, 0, MOST_RAD, MOST_RAD, TURN_RADPS[1], 0]),
        SIZE,
        SCALE,
        np.full(6, TOLERANCE),
    )
    return Vehicle(
        system,
        np.array(flight.plant.u_limits),
        start,
        has_flow=False,
        powered=False,
        trusted={},
        loads=loads,
        raw=(f, None),
    )


def _trusted(flight: Flight) -> dict[int, tuple[float, float]]:
    trusted = flight.aircraft.trusted
    if trusted is None:
        return {}
    named = {State.ALPHA: trusted.alpha_deg, State.BETA: trusted.beta_deg}
    return {k: (math.radians(limits[0]), math.radians(limits[1])) for k, limits in named.items() if limits is not None}
