"""Linear model of a JSBSim aircraft at its trim, by central differences with actuators and engines settled.

The vehicle is frozen: a state is set and a few frames run, or a surface is moved until everything is at rest; then the
accelerations are read. For those few frames a propeller keeps the speed of the trim; in flight it follows (that of hale
within half a second). So each state is set again, the engines run until their forces and moments are constant, and the
change of these is added: A is quasi-steady, the engines' speeds in equilibrium at each state. Aerodynamics and flight
controls are those of the few frames, because the integrator of an autopilot never settles at a frozen error.

`A_at_once` is the rotational block before the engines have changed speed: the one that laws and rotational plants are
made from.

The response to each surface is taken at two step sizes; where they differ, it is not linear in the small.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.modes import STATES
from uavftc.core.signals import SURFACES
from uavftc.plants.jsbsim.load import inertia
from uavftc.plants.jsbsim.trim import Trim, accelerations, command, has, place, run_for, set_throttle
from uavftc.plants.jsbsim.units import FT_M, SLUG_KG, SLUGFT2_KGM2

SETTLE_S = 2.0  # actuators
ENGINE_S = 10.0  # engines
SURFACE_STEPS = (0.002, 0.01)  # of the command's range either side
RATE_STEP = 2e-3  # rad/s, and rad for angles
SPEED_STEP = 0.1  # m/s
THROTTLE_STEP = 0.02

PROPULSION = (
    "forces/fbx-prop-lbs", "forces/fby-prop-lbs", "forces/fbz-prop-lbs",
    "moments/l-prop-lbsft", "moments/m-prop-lbsft", "moments/n-prop-lbsft",
)  # fmt: skip
UNCHANGED_S = 0.5  # engines have settled when their loads change by less than `UNCHANGED` in this time
UNCHANGED = 1e-11  # of the largest load, or of a pound

PLACED = {"V": "airspeed", "alpha": "alpha", "beta": "beta", "theta": "theta", "phi": "phi"}
"""States that are set by name; the others are the body rates and have no such name."""
RATES = [STATES.index(name) for name in "pqr"]


class Linear(NamedTuple):
    """A linear model at a trim; surfaces in the units of their commands."""

    A: np.ndarray
    """(8, 8) over `STATES`, engines settled."""
    A_at_once: np.ndarray
    """(3, 3) over p, q, r, 1/s, engines at the speed of the trim."""
    B_command: np.ndarray
    """(6, 3): change of u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2, per unit of command."""
    position: np.ndarray
    """(3,) change of each surface's position, rad, per unit of its command; nan without a position property."""
    throttle_mps2: float
    """Change of u_dot, m/s^2, per unit of throttle."""
    nonlinearity: np.ndarray
    """(3,) relative difference of each surface's angular response about its axis between the two steps."""


def linearise(fdm: jsbsim.FGFDMExec, aircraft: Aircraft, trim: Trim) -> Linear:
    """Return the linear model at a trim; the FDM must be frozen, and is left at the trim."""
    engines = fdm.get_propulsion().get_num_engines()
    base = {"airspeed": trim.airspeed, "alpha": trim.alpha, "theta": trim.theta, "phi": trim.phi, "beta": 0.0}

    def put(name: str | None = None, change: float = 0.0) -> None:
        """Place the trim, one state of it changed."""
        rates = [change if name == rate else 0.0 for rate in "pqr"]
        state = dict(base)
        if name in PLACED:
            state[PLACED[name]] += change
        place(fdm, altitude=trim.altitude, rates=rates, **state)

    def response(name: str | None = None, change: float = 0.0) -> np.ndarray:
        """Return (12,): accelerations, and those that the engines alone give, after a few frames."""
        put(name, change)
        run_for(fdm, 4 * fdm.get_delta_t())
        own = engine_accelerations(fdm) if engines else np.zeros(6)
        return np.array([*accelerations(fdm), *own])

    def settled(name: str, change: float) -> np.ndarray:
        """Return (6,): accelerations that the engines alone give, once they have settled."""
        put(name, change)
        settle_engines(fdm)
        return engine_accelerations(fdm)

    def column(answer: Callable[[str, float], np.ndarray], name: str) -> np.ndarray:
        step = SPEED_STEP if name == "V" else RATE_STEP
        return (answer(name, step) - answer(name, -step)) / (2.0 * step)

    command(fdm, aircraft, trim)
    run_for(fdm, ENGINE_S)
    names = (*PLACED, *"pqr")
    at_once = {name: column(response, name) for name in names}
    response()
    B, position, nonlinearity = surface_response(fdm, aircraft)
    throttle = throttle_response(fdm, aircraft, trim)
    columns = {name: at_once[name][:6] for name in names}
    fast = _full(columns, trim)[np.ix_(RATES, RATES)]
    if engines:
        columns = {name: columns[name] + column(settled, name) - at_once[name][6:] for name in names}
    return Linear(_full(columns, trim), fast, B, position, throttle, nonlinearity)


def engine_accelerations(fdm: jsbsim.FGFDMExec) -> np.ndarray:
    """Return what engines and propellers give of u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2."""
    loads = np.array([fdm[name] for name in PROPULSION])
    force, moment = loads[:3] * FT_M * SLUG_KG, loads[3:] * SLUGFT2_KGM2  # lb is slug ft/s^2, lb ft slug ft^2/s^2
    mass = fdm["inertia/mass-slugs"] * SLUG_KG
    return np.array([*(force / mass), *np.linalg.solve(inertia(fdm), moment)])


def settle_engines(fdm: jsbsim.FGFDMExec) -> None:
    """Run frames until forces and moments of the engines are constant, for `ENGINE_S` at most."""
    before = np.array([fdm[name] for name in PROPULSION])
    for _ in range(round(ENGINE_S / UNCHANGED_S)):
        run_for(fdm, UNCHANGED_S)
        loads = np.array([fdm[name] for name in PROPULSION])
        if np.max(np.abs(loads - before)) <= UNCHANGED * max(1.0, np.max(np.abs(loads))):
            return
        before = loads


def _full(columns: dict[str, np.ndarray], trim: Trim) -> np.ndarray:
    """Assemble the (8, 8) matrix: dynamics from the differences, kinematics of a level trim in closed form."""
    V, cos, sin = trim.airspeed, np.cos(trim.alpha), np.sin(trim.alpha)
    A = np.zeros((8, 8))
    for j, name in enumerate(STATES):
        u, v, w, p, q, r = columns[name]
        A[0, j], A[1, j], A[2, j] = u * cos + w * sin, (w * cos - u * sin) / V, q  # from body axes; no sideslip
        A[4, j], A[5, j], A[6, j] = v / V, p, r
    A[3, STATES.index("q")] = 1.0
    A[7, STATES.index("p")] = 1.0
    A[7, STATES.index("r")] = np.tan(trim.theta)
    return A


def surface_response(fdm: jsbsim.FGFDMExec, aircraft: Aircraft) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (B_command (6, 3), position (3,), nonlinearity (3,)) at the frozen trim; see `Linear`."""
    B, position, nonlinearity = np.zeros((6, 3)), np.full(3, np.nan), np.zeros(3)
    for j, name in enumerate(SURFACES):
        surface = getattr(aircraft.surfaces, name)
        trim = fdm[surface.command]
        known = surface.position is not None and has(fdm, surface.position)
        slopes = []
        for part in SURFACE_STEPS:
            step = part * aircraft.command_limits()[j]
            ends = []
            for sign in (1.0, -1.0, 1.0, -1.0):  # the first pair takes up backlash, the second is the response
                fdm[surface.command] = trim + sign * step
                run_for(fdm, SETTLE_S)
                ends.append(np.array([*accelerations(fdm), fdm[surface.position] if known else np.nan]))
            slopes.append((ends[2] - ends[3]) / (2.0 * step))
        fdm[surface.command] = trim
        run_for(fdm, SETTLE_S)
        B[:, j], position[j] = slopes[0][:6], slopes[0][6]
        own, other = slopes[0][3 + j], slopes[1][3 + j]
        scale = max(abs(own), abs(other))
        nonlinearity[j] = abs(own - other) / scale if scale > 0.0 else 0.0
    return B, position, nonlinearity


def throttle_response(fdm: jsbsim.FGFDMExec, aircraft: Aircraft, trim: Trim) -> float:
    """Return the change of u_dot, m/s^2, per unit of throttle, engines settled; 0 without engines."""
    if fdm.get_propulsion().get_num_engines() == 0:
        return 0.0
    high, low = min(1.0, trim.throttle + THROTTLE_STEP), max(0.0, trim.throttle - THROTTLE_STEP)
    ends = []
    for throttle in (high, low):
        set_throttle(fdm, aircraft, throttle)
        run_for(fdm, ENGINE_S)
        ends.append(accelerations(fdm)[0])
    set_throttle(fdm, aircraft, trim.throttle)
    run_for(fdm, ENGINE_S)
    return (ends[0] - ends[1]) / (high - low)
