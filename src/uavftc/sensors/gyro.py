"""The bias of a rate gyro: x2_meas = x2_meas + b."""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, Vector3
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype([("bias", "f8", (3,))])  # b, rad/s
STATE = NOTHING


class Config(Model):
    """A constant bias of the measured body rates."""

    gyro_bias_degps: Vector3 = (0.0, 0.0, 0.0)
    """constant bias of the measured [p, q, r]"""


@law
def step(p, s, row):
    """Add the bias to x2_meas in place."""
    for i in range(3):
        row.x2_meas[i] += p.bias[i]


stage = Stage(step, PARAMS, STATE, reads=["x2_meas"], writes=["x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the bias; none where it is zero on every axis."""
    bias = np.radians(config.gyro_bias_degps)
    return [stage.block(params_of(PARAMS, bias=bias))] if bias.any() else []
