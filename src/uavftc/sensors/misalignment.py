"""The misalignment of a sensor: it is mounted turned by three angles, and measures along its own axes.

The axes of the sensor are those of the body turned by yaw, then pitch, then roll (3-2-1, as the attitude itself), with
the matrix C from body to sensor axes, exact at any angle:

    gyro          x2_meas = C x2_meas
    attitude      C(x1_meas) = C C(x1_meas), with C(x1) from the axes of the earth to those of the body

A heading is continuous: it is moved by whole turns to within half a turn of the one that is turned. Straight up and
down, where bank and heading are not defined, the measurement is not defined either.
"""

from __future__ import annotations

from math import asin, atan2, cos, pi, sin

import numpy as np

from uavftc.config.values import Model, Vector3
from uavftc.core.given import Given
from uavftc.core.linear3 import multiply
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype(
    [
        ("attitude", "f8", (3, 3)),  # C from body to sensor axes
        ("turned", "f8"),  # 0 where the attitude is measured along the axes of the body
        ("gyro", "f8", (3, 3)),
    ]
)
STATE = NOTHING


class Config(Model):
    """The angles at which the sensors are mounted."""

    attitude_misalignment_deg: Vector3 = (0.0, 0.0, 0.0)
    """by how much the attitude sensor is turned about [x, y, z] of the body: yaw first, then pitch, then roll"""
    gyro_misalignment_deg: Vector3 = (0.0, 0.0, 0.0)
    """by how much the gyro is turned about [x, y, z] of the body, in the same order"""


@law
def turn(C, x1):
    """Return the attitude C C(x1) as [phi, theta, psi], three values, rad; C (3, 3)."""
    sf, cf, st, ct = sin(x1[0]), cos(x1[0]), sin(x1[1]), cos(x1[1])
    sp, cp = sin(x1[2]), cos(x1[2])
    x, _, _ = multiply(C, (ct * cp, sf * st * cp - cf * sp, cf * st * cp + sf * sp))  # of north in sensor axes
    y, _, _ = multiply(C, (ct * sp, sf * st * sp + cf * cp, cf * st * sp - sf * cp))  # of east
    z, z_y, z_z = multiply(C, (-st, sf * ct, cf * ct))  # of down
    psi = atan2(y, x)
    return atan2(z_y, z_z), -asin(min(max(z, -1.0), 1.0)), psi + 2.0 * pi * np.round((x1[2] - psi) / (2.0 * pi))


@law
def step(p, s, row):
    """Measure along the axes of the sensors, in place."""
    x1, x2 = row.x1_meas, row.x2_meas
    if p.turned != 0.0:
        row.x1_meas[0], row.x1_meas[1], row.x1_meas[2] = turn(p.attitude, x1)
    row.x2_meas[0], row.x2_meas[1], row.x2_meas[2] = multiply(p.gyro, x2)


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def matrix(angles: np.ndarray) -> np.ndarray:
    """Return C, shape (3, 3), to axes turned by [roll, pitch, yaw], rad, in the order 3-2-1."""
    (sf, st, sp), (cf, ct, cp) = np.sin(angles), np.cos(angles)
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cf, sf], [0.0, -sf, cf]])
    pitch = np.array([[ct, 0.0, -st], [0.0, 1.0, 0.0], [st, 0.0, ct]])
    yaw = np.array([[cp, sp, 0.0], [-sp, cp, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(roll @ pitch @ yaw)


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the misalignment; none where every angle is zero."""
    attitude, gyro = np.radians(config.attitude_misalignment_deg), np.radians(config.gyro_misalignment_deg)
    if not (attitude.any() or gyro.any()):
        return []
    mounted = params_of(PARAMS, attitude=matrix(attitude), turned=float(attitude.any()), gyro=matrix(gyro))
    return [stage.block(mounted, name="sensor_misalignment")]
