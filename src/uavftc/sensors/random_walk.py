"""Random walk of a sensor: x_meas = x_meas + w, w[0] = 0, w[k + 1] = w[k] + K sqrt(h) n, with n normal (0, 1).

It is white noise of the two-sided density K^2, integrated: after t s the standard deviation is K sqrt(t), at every rate
of the controller. Of a gyro it is the rate random walk K of IEEE Std 952, in deg/s/sqrt(s), the slow drift of its bias.

Each axis has a stream of its own, by (seed, sensor, axis), of which sample k takes the k-th number. The walk goes on to
the end of the flight.
"""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, NonNegativeVector3
from uavftc.core.given import Given
from uavftc.core.random import key, normal
from uavftc.core.stage import Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype(
    [
        ("attitude", "f8", (3,)),  # standard deviation of a step, rad
        ("gyro", "f8", (3,)),  # rad/s
        ("attitude_key", "u8", (3,)),
        ("gyro_key", "u8", (3,)),
    ]
)
STATE = np.dtype(
    [
        ("k", "i8"),  # the sample
        ("attitude", "f8", (3,)),  # w, rad
        ("gyro", "f8", (3,)),  # rad/s
    ]
)


class Config(Model):
    """A random walk on the measured attitude and on the measured body rates."""

    attitude_random_walk_deg_per_rts: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """random walk of the measured [phi, theta, psi], >= 0: the standard deviation after 1 s, growing with sqrt(t)"""
    gyro_random_walk_degps_per_rts: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """the same of the measured [p, q, r]: rate random walk"""


@law
def step(p, s, row):
    """Add the walk in place, and go its next step."""
    for i in range(3):
        row.x1_meas[i] += s.attitude[i]
        row.x2_meas[i] += s.gyro[i]
        if p.attitude[i] > 0.0:
            s.attitude[i] += p.attitude[i] * normal(p.attitude_key[i], s.k)
        if p.gyro[i] > 0.0:
            s.gyro[i] += p.gyro[i] * normal(p.gyro_key[i], s.k)
    s.k += 1


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the walk; none where it is zero on every axis."""
    attitude = np.radians(config.attitude_random_walk_deg_per_rts)
    gyro = np.radians(config.gyro_random_walk_degps_per_rts)
    if not (attitude.any() or gyro.any()):
        return []
    walk = params_of(
        PARAMS,
        attitude=np.sqrt(given.h) * attitude,
        gyro=np.sqrt(given.h) * gyro,
        attitude_key=np.array([key(given.seed, "attitude random walk", i) for i in range(3)]),
        gyro_key=np.array([key(given.seed, "gyro random walk", i) for i in range(3)]),
    )
    return [stage.block(walk, name="sensor_random_walk")]
