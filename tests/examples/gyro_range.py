"""The range of a rate gyro: x2_meas is cut off at +-full scale.

An example of an error of the sensors in one file; it takes part by its place in `sensors.CHAIN`.
"""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, PositiveVector3
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype([("most", "f8", (3,))])  # full scale, rad/s
STATE = NOTHING


class Config(Model):
    """The largest rates that the gyro can show."""

    gyro_range_degps: PositiveVector3 | None = None
    """full scale of the measured [p, q, r] to either side, > 0; `null` is no limit"""


@law
def step(p, s, row):
    """Cut x2_meas off in place."""
    for i in range(3):
        row.x2_meas[i] = min(max(row.x2_meas[i], -p.most[i]), p.most[i])


stage = Stage(step, PARAMS, STATE, reads=["x2_meas"], writes=["x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the limit; none where there is none."""
    if config.gyro_range_degps is None:
        return []
    return [stage.block(params_of(PARAMS, most=np.radians(config.gyro_range_degps)))]
