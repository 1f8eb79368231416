"""The scale error of a rate gyro: x2_meas = (1 + k) x2_meas.

An example of an error of the sensors in one file; it takes part by its place in `sensors.CHAIN`.
"""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, Vector3
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype([("factor", "f8", (3,))])  # 1 + k
STATE = NOTHING


class Config(Model):
    """A constant error of the scale of the measured body rates."""

    gyro_scale_error: Vector3 = (0.0, 0.0, 0.0)
    """error of the scale of the measured [p, q, r], as a fraction: 0.01 is one per cent too much"""


@law
def step(p, s, row):
    """Scale x2_meas in place."""
    for i in range(3):
        row.x2_meas[i] *= p.factor[i]


stage = Stage(step, PARAMS, STATE, reads=["x2_meas"], writes=["x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the error; none where it is zero on every axis."""
    error = np.array(config.gyro_scale_error)
    return [stage.block(params_of(PARAMS, factor=1.0 + error))] if error.any() else []
