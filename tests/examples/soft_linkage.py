"""A soft linkage between servo and surface: the deflection follows the servo with a lag, y' = w (u - y).

Sampled form, exact for a u that is held over a plant step dt: y + (1 - exp(-w dt)) (u - y). The effector gets where the
lag is at the end of the plant step.

An example of an effect of the actuators in one file; it takes part by its place in `actuators.CHAIN`.
"""

from __future__ import annotations

from math import exp, inf

import numpy as np

from uavftc.actuators.servo import Keys, servos
from uavftc.config.values import Positive
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

KEYS_IN = "actuators"

PARAMS = np.dtype([("share", "f8")])  # 1 - exp(-w dt), of the way that is left
STATE = np.dtype([("y", "f8")])  # rad; zero is trim


class Config(Keys):
    """The lag of every linkage."""

    linkage_radps: Positive | None = None
    """bandwidth of the linkage, > 0; `null` is a stiff one"""


@law
def step(p, s, e, row):
    """Move on by one plant step."""
    s.y += p.share * (e.deflection - s.y)
    e.deflection = s.y


stage = Stage(step, PARAMS, STATE, reads=["deflection"], writes=["deflection"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the lag of each effector, by its own keys or the common ones; none where all are stiff."""
    bandwidths = [None if servo.keys is None else servo.keys.linkage_radps for servo in servos(config, given)]
    if not any(bandwidths):
        return []
    share = [1.0 - exp(-(inf if w is None else w) * given.plant_step) for w in bandwidths]
    return [stage.block(records_of(PARAMS, len(share), share=share))]
