"""Linear model of a JSBSim aircraft at its trim, by central differences with actuators settled.

The vehicle is frozen: a state is set and a few frames run, or a surface is moved until everything is at rest; then the
accelerations are read. For those few frames a propeller keeps the speed of the trim, but not its thrust.
The response to each surface is taken at two step sizes; where they differ, it is not linear in the small.
"""

from __future__ import annotations

from typing import NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.modes import STATES
from uavftc.core.signals import SURFACES
from uavftc.plants.jsbsim.trim import Trim, accelerations, command, has, place, run_for, set_throttle

SETTLE_S = 2.0  # actuators
ENGINE_S = 10.0  # engines
SURFACE_STEPS = (0.002, 0.01)  # of the command's range either side
RATE_STEP = 2e-3  # rad/s, and rad for angles
SPEED_STEP = 0.1  # m/s
THROTTLE_STEP = 0.02

PLACED = {"V": "airspeed", "alpha": "alpha", "beta": "beta", "theta": "theta", "phi": "phi"}
"""States that are set by name; the rates are a separate argument."""


class Linear(NamedTuple):
    """A linear model at a trim; surfaces in the units of their commands."""

    A: np.ndarray
    """(8, 8) over `STATES`."""
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
    base = {"airspeed": trim.airspeed, "alpha": trim.alpha, "theta": trim.theta, "phi": trim.phi, "beta": 0.0}

    def response(rates: tuple[float, float, float] = (0.0, 0.0, 0.0), **changes: float) -> np.ndarray:
        state = base | {k: base[k] + v for k, v in changes.items()}
        place(fdm, altitude=trim.altitude, rates=rates, **state)
        run_for(fdm, 4 * fdm.get_delta_t())
        return np.array(accelerations(fdm))

    command(fdm, aircraft, trim)
    run_for(fdm, ENGINE_S)
    columns: dict[str, np.ndarray] = {}
    for name, key in PLACED.items():
        step = SPEED_STEP if name == "V" else RATE_STEP
        columns[name] = (response(**{key: step}) - response(**{key: -step})) / (2.0 * step)  # type: ignore[arg-type]
    for i, name in enumerate("pqr"):
        unit = [0.0, 0.0, 0.0]
        unit[i] = RATE_STEP
        plus, minus = tuple(unit), tuple(-x for x in unit)
        columns[name] = (response(plus) - response(minus)) / (2.0 * RATE_STEP)  # type: ignore[arg-type]
    response()
    B, position, nonlinearity = surface_response(fdm, aircraft)
    throttle = throttle_response(fdm, aircraft, trim)
    return Linear(_full(columns, trim), B, position, throttle, nonlinearity)


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
