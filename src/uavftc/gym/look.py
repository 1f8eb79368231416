"""What an agent sees of a sample, as numbers of about 1 within fixed bounds: one law, which runs before the agent acts.

    0-2     attitude error, reference less measured [phi, theta, psi], rad; the heading's within half a turn
    3-4     measured bank and pitch, rad
    5-7     measured body rates [p, q, r], rad/s
    8-10    commanded body rates of the outer loop, v1, rad/s; 0 where the controller has none
    11-13   command of the controller that is assisted, in limits of its axis; 0 where the agent replaces it
    14-16   action before, -1..1

Each is clipped to its bound. All of it is what a controller is shown, with the errors of the sensors.
"""

from __future__ import annotations

from math import pi

import numpy as np

from uavftc.core.stage import Stage, law

COUNT = 17
RATE_BOUND = 10.0  # rad/s
COMMAND_BOUND = 10.0  # in limits
BOUNDS = np.array([pi, pi, pi, pi, 0.5 * pi, *[RATE_BOUND] * 6, *[COMMAND_BOUND] * 3, 1.0, 1.0, 1.0])
"""Of each number, to either side, shape (17,)."""

PARAMS = np.dtype(
    [
        ("limits", "f8", (3, 2)),  # of each axis about trim, rad
        ("assists", "f8"),  # 1 where there is a command to see
        ("bounds", "f8", (COUNT,)),
    ]
)
STATE = np.dtype([("seen", "f8", (COUNT,)), ("action", "f8", (3,))])


@law
def step(p, s, row):
    """Write what is seen of the row into the state."""
    for i in range(3):
        error = row.x1_c[i] - row.x1_meas[i]
        if i == 2:
            error -= 2.0 * pi * round(error / (2.0 * pi))
        s.seen[i] = error
        s.seen[5 + i] = row.x2_meas[i]
        s.seen[8 + i] = row.v1[i]
        v2 = row.v2[i] * p.assists
        limit = p.limits[i, 1] if v2 >= 0.0 else -p.limits[i, 0]
        s.seen[11 + i] = v2 / limit if limit > 0.0 else 0.0
        s.seen[14 + i] = s.action[i]
    s.seen[3] = row.x1_meas[0]
    s.seen[4] = row.x1_meas[1]
    for i in range(COUNT):
        value = s.seen[i]
        if not (abs(value) <= p.bounds[i]):
            s.seen[i] = p.bounds[i] if value > 0.0 else (-p.bounds[i] if value < 0.0 else 0.0)  # and 0 of no number


stage = Stage(step, PARAMS, STATE, reads=["x1_c", "x1_meas", "x2_meas"], writes=[])
