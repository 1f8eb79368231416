"""The measurement without any error: x1_meas = x1, x2_meas = x2. The other effects of the chain work on it."""

from __future__ import annotations

from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law

PARAMS = NOTHING
STATE = NOTHING


@law
def step(p, s, row):
    """Write x1_meas and x2_meas into the row."""
    for i in range(3):
        row.x1_meas[i] = row.x1[i]
        row.x2_meas[i] = row.x2[i]


stage = Stage(step, PARAMS, STATE, reads=["x1", "x2"], writes=["x1_meas", "x2_meas"])


def blocks(config: None, given: Given) -> list[Block]:
    """Return the exact measurement, which every flight has."""
    return [stage.block()]
