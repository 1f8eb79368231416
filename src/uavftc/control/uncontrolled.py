"""What every controller commands about an axis that nothing acts on: zero.

The laws of this project command zero there by themselves; a custom controller may return anything. It is part of a
flight only where an axis is missing.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

PARAMS = np.dtype([("axes", "f8", (3,))])  # 1 where the axis is controlled


@law
def step(p, s, row):
    """Set the command of each axis that is not controlled to zero."""
    for i in range(3):
        if p.axes[i] == 0.0:
            row.v2[i] = 0.0


stage = Stage(step, PARAMS, NOTHING, reads=["v2"], writes=["v2"])


def blocks(given: Given) -> list[Block]:
    """Return the law where an axis is missing, and nothing where there is none."""
    if all(given.axes):
        return []
    return [stage.block(params_of(PARAMS, axes=np.array(given.axes, float)), name="uncontrolled")]
