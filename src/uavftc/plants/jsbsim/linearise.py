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

from uavftc.aircraft.effectors import Surface
from uavftc.analysis.modes import STATES
from uavftc.core.signals import SURFACES
from uavftc.plants.jsbsim.engines import has
from uavftc.plants.jsbsim.load import inertia
from uavftc.plants.jsbsim.rig import Rig
from uavftc.plants.jsbsim.settle import FINE_S, accelerations, rest, run_for, set_from_below
from uavftc.plants.jsbsim.trim import Trim, command, place, set_throttle
from uavftc.plants.jsbsim.units import FT_M, SLUG_KG, SLUGFT2_KGM2

SETTLE_S = 2.0  # actuators
ENGINE_S = 10.0  # engines
SURFACE_STEPS = (0.002, 0.01)  # of the command's range either side
RATE_STEP = 2e-3  # rad/s, and rad for angles
SPEED_STEP = 0.1  # m/s
THROTTLE_STEP = 0.02
EXACT = 1e-12  # rad, or the unit of the position, between a position and what is linear in the command

PROPULSION = (
    "forces/fbx-prop-lbs", "forces/fby-prop-lbs", "forces/fbz-prop-lbs",
    "moments/l-prop-lbsft", "moments/m-prop-lbsft", "moments/n-prop-lbsft",
)  # fmt: skip
UNCHANGED_S = 0.5  # engines have settled when their loads change by less than `UNCHANGED` in this time
UNCHANGED = 1e-11  # of the largest load, or of a pound

PLACED = {"V": "airspeed", "alpha": "alpha", "beta": "beta", "theta": "theta", "phi": "phi"}
"""States that are set by name; the others are the body rates and have no such name."""
RATES = [STATES.index(name) for name in "pqr"]


class Surfaces(NamedTuple):
    """Response to each of n surfaces at a frozen trim, in the units of their commands."""

    B_command: np.ndarray
    """(6, n) change of accelerations per unit of command."""
    position: np.ndarray
    """(n,) change of the position property per unit of command; nan without one."""
    nonlinearity: np.ndarray
    """(n,) relative difference of the angular response about the main axis between the two steps."""
    at_trim: np.ndarray
    """(n,) position property at the trim; nan without one."""
    at_ends: np.ndarray
    """(n, 2) position property at least and greatest command; nan without one."""
    ends: np.ndarray
    """(n, 2) least and greatest command."""
    full: np.ndarray
    """(n, 2) response at either end over what the slope gives, about the main axis; nan where an end is the trim."""
    ideal: list[bool]
    """(n,) whether the position is linear in the command and there one frame later, to `EXACT`."""


class Linear(NamedTuple):
    """A linear model at a trim; surfaces in the units of their commands."""

    A: np.ndarray
    """(8, 8) over `STATES`, engines settled."""
    A_at_once: np.ndarray
    """(3, 3) over p, q, r, 1/s, engines at the speed of the trim."""
    surfaces: Surfaces
    throttle_mps2: float
    """Change of u_dot, m/s^2, per unit of throttle."""


def linearise(fdm: jsbsim.FGFDMExec, rig: Rig, trim: Trim) -> Linear:
    """Return the linear model at a trim; the FDM must be frozen, and is left at the trim."""
    engines = fdm.get_propulsion().get_num_engines()
    base = {"airspeed": trim.airspeed, "alpha": trim.alpha, "theta": trim.theta, "phi": trim.phi, "beta": trim.beta}

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

    command(fdm, trim)
    rest(fdm, ENGINE_S)
    names = (*PLACED, *"pqr")
    at_once = {name: column(response, name) for name in names}
    response()
    surfaces = surface_response(fdm, rig, trim)
    throttle = throttle_response(fdm, trim)
    columns = {name: at_once[name][:6] for name in names}
    fast = _full(columns, trim)[np.ix_(RATES, RATES)]
    if engines:
        columns = {name: columns[name] + column(settled, name) - at_once[name][6:] for name in names}
    return Linear(_full(columns, trim), fast, surfaces, throttle)


def engine_accelerations(fdm: jsbsim.FGFDMExec) -> np.ndarray:
    """Return what engines and propellers give of u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2."""
    loads = np.array([fdm[name] for name in PROPULSION])
    force, moment = loads[:3] * FT_M * SLUG_KG, loads[3:] * SLUGFT2_KGM2  # lb is slug ft/s^2, lb ft slug ft^2/s^2
    mass = fdm["inertia/mass-slugs"] * SLUG_KG
    return np.array([*(force / mass), *np.linalg.solve(inertia(fdm), moment)])


def settle_engines(fdm: jsbsim.FGFDMExec) -> None:
    """Run frames until forces and moments of the engines are constant, for `ENGINE_S` at most."""
    before = np.array([fdm[name] for name in PROPULSION])
    step = UNCHANGED_S if fdm.get_delta_t() >= FINE_S else 0.1 * UNCHANGED_S
    for _ in range(round(ENGINE_S / step)):
        run_for(fdm, step)
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


def surface_response(fdm: jsbsim.FGFDMExec, rig: Rig, trim: Trim) -> Surfaces:
    """Return the response to each surface; the FDM must be frozen at the trim, and is left there."""
    n = len(rig.surfaces)
    found = Surfaces(
        np.zeros((6, n)), np.full(n, np.nan), np.zeros(n), np.full(n, np.nan), np.full((n, 2), np.nan),
        np.zeros((n, 2)), np.full((n, 2), np.nan), [False] * n,
    )  # fmt: skip
    pedals = dict(zip(SURFACES, trim.trim_commands, strict=True))
    for j, (surface, slack) in enumerate(zip(rig.surfaces.values(), rig.backlash, strict=True)):
        at = fdm[surface.command]
        known = surface.position if surface.position is not None and has(fdm, surface.position) else None
        offset = next((pedals[s] for s in SURFACES if surface.command == f"fcs/{s}-cmd-norm"), 0.0)
        found.ends[j] = rig.ranges[j] - offset
        reach = 0.5 * float(np.ptp(rig.ranges[j]))

        def answer(command: float, surface: Surface = surface, slack: float = slack, known: str | None = known):  # type: ignore[no-untyped-def]
            """Return accelerations and position, (7,), with the command set and everything at rest."""
            set_from_below(fdm, {surface.command: command}, {surface.command: slack})
            rest(fdm, SETTLE_S)
            return np.array([*accelerations(fdm), np.nan if known is None else fdm[known]])

        slopes = []
        for part in SURFACE_STEPS:
            step = max(part * reach, 2.0 * slack)
            signs = (1.0, -1.0) if slack else (1.0, -1.0, 1.0, -1.0)  # the first pair wears in
            pair = [answer(at + sign * step) for sign in signs][-2:]
            slopes.append((pair[0] - pair[1]) / (2.0 * step))
        level = answer(at)
        found.B_command[:, j], found.position[j], found.at_trim[j] = slopes[0][:6], slopes[0][6], level[6]
        main = 3 + int(np.argmax(np.abs(slopes[0][3:6]) * np.diag(inertia(fdm))))
        own, other = slopes[0][main], slopes[1][main]
        scale = max(abs(own), abs(other))
        found.nonlinearity[j] = abs(own - other) / scale if scale > 0.0 else 0.0
        for k, end in enumerate(found.ends[j]):
            if abs(end - at) > 1e-6 * reach:
                there = answer(end)
                found.at_ends[j, k] = there[6]
                found.full[j, k] = (there - level)[main] / (own * (end - at)) if own else np.nan
            else:
                found.at_ends[j, k] = level[6]
        found.ideal[j] = known is not None and slack == 0.0 and _ideal(fdm, surface.command, known, found, j, at)
        answer(at)
    return found


def _ideal(fdm: jsbsim.FGFDMExec, command: str, position: str, found: Surfaces, j: int, at: float) -> bool:
    """Whether a position follows its command linearly and at once, from end to end."""
    rest(fdm, SETTLE_S)
    for part in (-1.0, -0.37, 0.004, 0.61, 1.0):
        end = found.ends[j, 1] if part > 0 else found.ends[j, 0]
        there = at + abs(part) * (end - at)
        fdm[command] = there
        fdm.run()
        expected = found.at_trim[j] + found.position[j] * (there - at)
        if not abs(fdm[position] - expected) <= EXACT:
            return False
    return True


def throttle_response(fdm: jsbsim.FGFDMExec, trim: Trim) -> float:
    """Return the change of u_dot, m/s^2, per unit of throttle, engines settled; 0 without engines."""
    if not trim.throttles or trim.method == "glide":
        return 0.0
    high, low = min(1.0, trim.throttle + THROTTLE_STEP), max(0.0, trim.throttle - THROTTLE_STEP)
    ends = []
    for throttle in (high, low):
        set_throttle(fdm, trim.throttles, throttle)
        rest(fdm, ENGINE_S)
        ends.append(accelerations(fdm)[0])
    set_throttle(fdm, trim.throttles, trim.throttle)
    rest(fdm, ENGINE_S)
    return (ends[0] - ends[1]) / (high - low)
