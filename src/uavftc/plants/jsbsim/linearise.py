"""Control effectiveness of a JSBSim aircraft at its trim, by central differences of the body accelerations."""

from __future__ import annotations

import jsbsim
import numpy as np

from uavftc.aircraft import Aircraft
from uavftc.signals import SURFACES

ACCELERATIONS = ("accelerations/pdot-rad_sec2", "accelerations/qdot-rad_sec2", "accelerations/rdot-rad_sec2")
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
