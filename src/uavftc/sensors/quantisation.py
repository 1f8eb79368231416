"""Quantisation of a sensor: x_meas = q round(x_meas / q), with q the step of its converter.

The nearest multiple of q, halves upward (a mid-tread converter: 0 is one of its values). The error is within q / 2; of
a signal that moves over many steps it is nearly uniform, with the standard deviation q / sqrt(12).
"""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, NonNegativeVector3
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype([("attitude", "f8", (3,)), ("gyro", "f8", (3,))])  # q, rad and rad/s; 0 is none
STATE = NOTHING


class Config(Model):
    """The steps in which attitude and body rates are measured."""

    attitude_quantisation_deg: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """step of the measured [phi, theta, psi], >= 0; 0 is none"""
    gyro_quantisation_degps: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """step of the measured [p, q, r], >= 0; 0 is none"""


@law
def rounded(x, q):
    """Return the multiple of q that is nearest to x."""
    return q * np.floor(x / q + 0.5)


@law
def step(p, s, row):
    """Round the measurement in place."""
    for i in range(3):
        if p.attitude[i] > 0.0:
            row.x1_meas[i] = rounded(row.x1_meas[i], p.attitude[i])
        if p.gyro[i] > 0.0:
            row.x2_meas[i] = rounded(row.x2_meas[i], p.gyro[i])


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the rounding; none where every step is zero."""
    attitude, gyro = np.radians(config.attitude_quantisation_deg), np.radians(config.gyro_quantisation_degps)
    if not (attitude.any() or gyro.any()):
        return []
    return [stage.block(params_of(PARAMS, attitude=attitude, gyro=gyro), name="sensor_quantisation")]
