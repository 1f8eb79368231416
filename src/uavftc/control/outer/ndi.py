"""Outer loop, nonlinear dynamic inversion: eq. (9).

    v1 = g1(x1)^-1 ( D (x1_c - x1) - d1_hat )

The estimate d1_hat is read from the signal row: the observer of `outer/nndo.py` writes it when it is part of the
loop, and it is zero when it is not ("NDI-L1"). The heading error is taken the short way round.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.kinematics import body_rates, wrapped
from uavftc.core.stage import NOTHING, Stage, carray, law

PARAMS = np.dtype([("D", "f8", (3,))])  # outer-loop bandwidth, 1/s
STATE = NOTHING


@law
def step(p, s, row):
    """Write the commanded body rates v1, rad/s, into the row."""
    x1_c, x1, d1_hat = row.x1_c, row.x1_meas, row.d1_hat
    x1_dot = (
        p.D[0] * (x1_c[0] - x1[0]) - d1_hat[0],
        p.D[1] * (x1_c[1] - x1[1]) - d1_hat[1],
        p.D[2] * wrapped(x1_c[2] - x1[2]) - d1_hat[2],
    )
    row.v1[0], row.v1[1], row.v1[2] = body_rates(x1, x1_dot)


@Stage(PARAMS, STATE)
def stage(p, s, row):
    """Entry."""
    step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])
