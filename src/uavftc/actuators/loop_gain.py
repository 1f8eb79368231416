"""Gain of the loop, on every command: what the gain margin of a loop is about.

    deflection = loop_gain command

The command is about trim, so the trim stays. 1 is the loop as it was designed.
"""

from __future__ import annotations

import numpy as np

from uavftc.config.values import Model, Positive
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, records_of

KEYS_IN = "controller"

PARAMS = np.dtype([("gain", "f8")])
STATE = NOTHING


class Config(Model):
    """Gain between command and surface."""

    loop_gain: Positive = 1.0
    """factor on every command, above 0, for gain margins (`uavftc margin`)"""


@law
def step(p, s, e, row):
    """Apply the gain in place."""
    e.deflection *= p.gain


stage = Stage(step, PARAMS, STATE, reads=["deflection"], writes=["deflection"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the gain on each effector; none where it is 1."""
    if config.loop_gain == 1.0:
        return []
    n = len(given.effectors)
    return [stage.block(records_of(PARAMS, n, gain=[config.loop_gain] * n))]
