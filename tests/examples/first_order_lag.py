"""An actuator of first order: the deflection follows its command with a lag, y' = w (u - y).

Sampled form, exact for a u that is held over a plant step dt: y + (1 - exp(-w dt)) (u - y). The effector gets where the
lag is at the end of the plant step.

An example of an effect of the actuators in one file; it takes part by its place in `actuators.CHAIN`.
"""

from __future__ import annotations

from math import exp

import numpy as np

from uavftc.config.values import Model, Positive
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

KEYS_IN = "actuators"

PARAMS = np.dtype([("share", "f8")])  # 1 - exp(-w dt), of the way that is left
STATE = np.dtype([("y", "f8")])  # rad; zero is trim


class Config(Model):
    """The lag of every actuator."""

    bandwidth_radps: Positive | None = None
    """bandwidth of the actuators, > 0; `null` is without lag"""


@law
def step(p, s, e, row):
    """Move on by one plant step."""
    s.y += p.share * (e.deflection - s.y)
    e.deflection = s.y


stage = Stage(step, PARAMS, STATE, reads=["deflection"], writes=["deflection"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the lag of each effector; none where no bandwidth is given."""
    if config.bandwidth_radps is None:
        return []
    n = len(given.effectors)
    share = 1.0 - exp(-config.bandwidth_radps * given.plant_step)
    return [stage.block(records_of(PARAMS, n, share=[share] * n))]
