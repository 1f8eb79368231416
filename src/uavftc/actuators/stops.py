"""Mechanical stops, the last effect on every effector: no command and no fault moves it further.

u = sat(u) between the stops, counted about trim; the law is that of the saturation.
"""

from __future__ import annotations

import numpy as np

from uavftc.actuators import saturation
from uavftc.actuators.at_rest import Reach, Rest
from uavftc.core.given import Given
from uavftc.core.stage import Block, records_of

PARAMS, STATE, step, stage = saturation.PARAMS, saturation.STATE, saturation.step, saturation.stage


def blocks(config: None, given: Given) -> list[Block]:
    """Return the stops of each effector; none where there are none."""
    if not np.isfinite(given.stops_rad).any():
        return []
    low, high = given.stops_rad.T
    return [stage.block(records_of(PARAMS, len(given.effectors), u_min=low, u_max=high), name="stops")]


def at_rest(config: None, given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return what is between the stops."""
    return [reach.within(*given.stops_rad.T)]
