"""The linear pair of a JSBSim aircraft at its trim, by central differences of the body accelerations.

    [p_dot, q_dot, r_dot] = A [p, q, r] + B [aileron, elevator, rudder]        about the trim

A is the rotational block alone: airspeed, angles of attack and sideslip, attitude and throttle stay at the trim.
"""

from __future__ import annotations

import jsbsim
import numpy as np

from uavftc.aircraft import Aircraft
from uavftc.plants.jsbsim.trim import SPIN_UP_S, Trim, command, place
from uavftc.signals import SURFACES

ACCELERATIONS = ("accelerations/pdot-rad_sec2", "accelerations/qdot-rad_sec2", "accelerations/rdot-rad_sec2")
RATES = ("ic/p-rad_sec", "ic/q-rad_sec", "ic/r-rad_sec")
SETTLE_FRAMES = 400  # so that actuators stand still


def control_matrix(fdm: jsbsim.FGFDMExec, aircraft: Aircraft, step: float = 1e-3) -> np.ndarray:
    """Return B, shape (3, 3), 1/s^2: the change of [p_dot, q_dot, r_dot] with [aileron, elevator, rudder].

    The FDM must be frozen at its trim (`trim.trim_level`); it is left there. `step` is the deflection, rad.
    """
    B = np.zeros((3, 3))
    for j, surface in enumerate(SURFACES):
        name = getattr(aircraft.surfaces, surface).command
        trim = fdm[name]
        response = []
        for sign in (1.0, -1.0):
            fdm[name] = trim + sign * step
            for _ in range(SETTLE_FRAMES):
                fdm.run()
            response.append(np.array([fdm[a] for a in ACCELERATIONS]))
        fdm[name] = trim
        B[:, j] = (response[0] - response[1]) / (2.0 * step)
    for _ in range(SETTLE_FRAMES):
        fdm.run()
    return B


def state_matrix(fdm: jsbsim.FGFDMExec, aircraft: Aircraft, trim: Trim, step: float = 1e-3) -> np.ndarray:
    """Return A, shape (3, 3), 1/s: the change of [p_dot, q_dot, r_dot] with [p, q, r].

    The FDM must be frozen at `trim` (`trim.trim_level`); it is left there. `step` is the rate, rad/s. What the rates
    do to the derivatives of alpha and beta at that moment, and through them to the moments, is included.
    """
    frames = round(SPIN_UP_S / fdm.get_delta_t())

    def accelerations(rates: np.ndarray) -> np.ndarray:
        place(fdm, airspeed=trim.airspeed, altitude=trim.altitude, alpha=trim.alpha)
        for name, rate in zip(RATES, rates, strict=True):
            fdm[name] = rate
        fdm.run_ic()
        command(fdm, aircraft, trim.elevator, trim.throttle)
        for _ in range(frames):
            fdm.run()
        return np.array([fdm[a] for a in ACCELERATIONS])

    columns = [(accelerations(step * e) - accelerations(-step * e)) / (2.0 * step) for e in np.eye(3)]
    accelerations(np.zeros(3))
    return np.column_stack(columns)
