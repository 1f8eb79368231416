"""The bias of a sensor, constant: x_meas = x_meas + b."""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, Vector3
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype([("attitude", "f8", (3,)), ("gyro", "f8", (3,))])  # b, rad and rad/s
STATE = NOTHING


class Config(Model):
    """A constant bias of the measured attitude and of the measured body rates."""

    attitude_bias_deg: Vector3 = (0.0, 0.0, 0.0)
    """constant bias of the measured [phi, theta, psi]"""
    gyro_bias_degps: Vector3 = (0.0, 0.0, 0.0)
    """constant bias of the measured [p, q, r]"""


@law
def step(p, s, row):
    """Add the bias in place."""
    for i in range(3):
        row.x1_meas[i] += p.attitude[i]
        row.x2_meas[i] += p.gyro[i]


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the bias; none where it is zero on every axis."""
    attitude, gyro = np.radians(config.attitude_bias_deg), np.radians(config.gyro_bias_degps)
    if not (attitude.any() or gyro.any()):
        return []
    return [stage.block(params_of(PARAMS, attitude=attitude, gyro=gyro), name="sensor_bias")]
