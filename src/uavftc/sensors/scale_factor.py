"""The scale factor error of a sensor: x_meas = (1 + k) x_meas.

It acts on the angle or rate that the axis of the sensor meets, before anything is added to it. A heading counts from
north, through all turns that were flown.
"""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, Vector3
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype([("attitude", "f8", (3,)), ("gyro", "f8", (3,))])  # 1 + k
STATE = NOTHING


class Config(Model):
    """A constant error of the scale of the measured attitude and of the measured body rates."""

    attitude_scale_factor_error: Vector3 = (0.0, 0.0, 0.0)
    """error of the scale of the measured [phi, theta, psi], as a fraction: 0.01 is one per cent too much"""
    gyro_scale_factor_error: Vector3 = (0.0, 0.0, 0.0)
    """error of the scale of the measured [p, q, r], as a fraction"""


@law
def step(p, s, row):
    """Scale the measurement in place."""
    for i in range(3):
        row.x1_meas[i] *= p.attitude[i]
        row.x2_meas[i] *= p.gyro[i]


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the error; none where it is zero on every axis."""
    attitude, gyro = np.array(config.attitude_scale_factor_error), np.array(config.gyro_scale_factor_error)
    if not (attitude.any() or gyro.any()):
        return []
    return [stage.block(params_of(PARAMS, attitude=1.0 + attitude, gyro=1.0 + gyro), name="sensor_scale_factor")]
