"""Input saturation, eq. (20): each surface limited to its own [u_min, u_max] about trim.

The same stage serves for the mechanical stops, which come last in the chain.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.stage import NOTHING, Stage, carray, law

PARAMS = np.dtype([("u_min", "f8", (3,)), ("u_max", "f8", (3,))])  # rad; +-inf for no limit
STATE = NOTHING


@law
def sat(v, u_min, u_max):
    """Return v limited to [u_min, u_max], rad (eq. 20); nan stays nan."""
    return u_min if v < u_min else (u_max if v > u_max else v)


@law
def step(p, s, row):
    """Limit the deflections u2 and u2_late in place."""
    for i in range(3):
        row.u2[i] = sat(row.u2[i], p.u_min[i], p.u_max[i])
        row.u2_late[i] = sat(row.u2_late[i], p.u_min[i], p.u_max[i])


@Stage(PARAMS, STATE)
def stage(p, s, row):
    """Entry."""
    step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])
