"""White noise of a sensor, given by its density: x_meas = x_meas + N sqrt(rate / 2) n, with n normal (0, 1).

N is the one-sided amplitude density of a data sheet, in deg/s/sqrt(Hz) of a gyro: the noise in a bandwidth of B Hz has
the standard deviation N sqrt(B). The samples of a controller at `rate_hz` hold all of it up to rate_hz / 2, so theirs
is N sqrt(rate_hz / 2): 0.005 deg/s/sqrt(Hz) at 200 Hz is 0.05 deg/s rms. The density is that of the scenario at every
rate. Where a source has the two-sided density instead, or the angle random walk of a gyro (deg/sqrt(s), IEEE Std 952),
N is sqrt(2) times it.

Each axis has a stream of its own, by (seed, sensor, axis), of which sample k takes the k-th number.
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
        ("attitude", "f8", (3,)),  # standard deviation of a sample, rad
        ("gyro", "f8", (3,)),  # rad/s
        ("attitude_key", "u8", (3,)),
        ("gyro_key", "u8", (3,)),
    ]
)
STATE = np.dtype([("k", "i8")])  # the sample


class Config(Model):
    """White noise on the measured attitude and on the measured body rates."""

    attitude_noise_density_deg_per_rthz: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """one-sided density of the white noise on the measured [phi, theta, psi], >= 0; a sample has it times
    sqrt(rate_hz / 2) as standard deviation"""
    gyro_noise_density_degps_per_rthz: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """the same on the measured [p, q, r]"""


@law
def step(p, s, row):
    """Add the noise of the sample in place."""
    for i in range(3):
        if p.attitude[i] > 0.0:
            row.x1_meas[i] += p.attitude[i] * normal(p.attitude_key[i], s.k)
        if p.gyro[i] > 0.0:
            row.x2_meas[i] += p.gyro[i] * normal(p.gyro_key[i], s.k)
    s.k += 1


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the noise; none where its density is zero on every axis."""
    attitude = np.radians(config.attitude_noise_density_deg_per_rthz)
    gyro = np.radians(config.gyro_noise_density_degps_per_rthz)
    if not (attitude.any() or gyro.any()):
        return []
    to_samples = np.sqrt(0.5 / given.h)
    noise = params_of(
        PARAMS,
        attitude=to_samples * attitude,
        gyro=to_samples * gyro,
        attitude_key=np.array([key(given.seed, "attitude noise", i) for i in range(3)]),
        gyro_key=np.array([key(given.seed, "gyro noise", i) for i in range(3)]),
    )
    return [stage.block(noise, name="sensor_noise")]
