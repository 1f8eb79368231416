"""Inner loop, proportional: v2 = B_m^-1 k (v1 - x2), with B_m that of the aircraft.

An example of a law of the inner loop in one file; it takes part by its place in `control.inner.KINDS`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.config.values import Model, Positive
from uavftc.core.given import Given
from uavftc.core.linear3 import multiply
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

PARAMS = np.dtype([("gain", "f8", (3, 3))])  # k B_m^-1, rad per rad/s
STATE = NOTHING


class Config(Model):
    """A proportional law on the body rates."""

    kind: Literal["proportional"] = "proportional"
    """proportional to the error of the body rates"""
    gain_radps: Positive = 6.0
    """k: how fast an error of the body rates decays, > 0"""


@law
def step(p, s, row):
    """Write the command v2, rad, into the row."""
    v1, x2 = row.v1, row.x2_meas
    row.v2[0], row.v2[1], row.v2[2] = multiply(p.gain, (v1[0] - x2[0], v1[1] - x2[1], v1[2] - x2[2]))


stage = Stage(step, PARAMS, STATE, reads=["v1", "x2_meas"], writes=["v2"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the law."""
    return [stage.block(params_of(PARAMS, gain=config.gain_radps * np.linalg.inv(given.design.B)))]
