"""Total loss of a surface: on [start_s, end_s) it gives no moment at all.

    total deflection = 0

so the moment of its trim is gone too; a surface with an effectiveness of 0 stays at trim. No memory.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, put, struck
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"

PARAMS = np.dtype([("start", "f8"), ("end", "f8"), ("trim", "f8")])  # s, s, rad
STATE = np.dtype([("most", "f8")])  # rad, how far it moved the surface


class Config(SurfaceFault):
    """A surface that is gone on [start_s, end_s)."""

    kind: Literal["total-loss"] = "total-loss"
    """is gone: it gives no moment, not that of its trim either"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "total loss"


@law
def step(p, s, e, row):
    """Set the total deflection to zero inside the window."""
    if p.start <= row.t < p.end:
        put(s, e, -p.trim)


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault."""
    found = []
    for i, entry in enumerate(config):
        hit = struck(entry, given)
        params = records_of(PARAMS, len(hit.start), start=hit.start, end=hit.end, trim=hit.trim)
        found.append(stage.block(params, name=f"total-loss {i}"))
    return found


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return it with each lost surface at a total deflection of zero, where no command moves it."""
    for entry in acting(config, rest.t):
        hit = struck(entry, given)
        lost = np.isfinite(hit.start)
        reach = reach.scaled(np.where(lost, 0.0, 1.0), np.where(lost, -hit.trim, 0.0))
    return [reach]
