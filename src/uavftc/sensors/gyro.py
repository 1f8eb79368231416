"""What the controller is shown: exact attitude, and body rates with the bias of a rate gyro.

x1_meas = x1,   x2_meas = x2 + b
"""

from __future__ import annotations

import numpy as np

from uavftc.core.stage import NOTHING, Stage, carray, law

PARAMS = np.dtype([("bias", "f8", (3,))])  # b, rad/s
STATE = NOTHING


@law
def step(p, s, row):
    """Write x1_meas and x2_meas into the row."""
    for i in range(3):
        row.x1_meas[i] = row.x1[i]
        row.x2_meas[i] = row.x2[i] + p.bias[i]


@Stage(PARAMS, STATE)
def stage(p, s, row):
    """Entry."""
    step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])
