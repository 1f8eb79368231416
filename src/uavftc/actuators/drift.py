"""A drift: on [start_s, end_s) the surface drifts away from what is commanded, as far as its stop.

    deflection = deflection + rate (n dt)

n counts the plant steps dt since the first one of the window. No memory beyond the window: from the first sample at or
after `end_s` it does as commanded.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, put, struck
from uavftc.config.values import Number
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"

PARAMS = np.dtype([("start", "f8"), ("end", "f8"), ("step", "f8")])  # s, s, rad a plant step
STATE = np.dtype([("n", "f8"), ("most", "f8")])  # plant steps since the window began; rad, how far it moved the surface


class Config(SurfaceFault):
    """A surface that drifts away from its command on [start_s, end_s)."""

    kind: Literal["drift"] = "drift"
    """drifts away from what is commanded"""
    rate_degps: Number
    """how fast it drifts, as the aircraft counts it"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"drift {self.rate_degps:g} deg/s"


@law
def step(p, s, e, row):
    """Add the drift inside the window."""
    if p.start <= row.t < p.end:
        put(s, e, e.deflection + s.n * p.step)
        s.n += 1.0
    else:
        s.n = 0.0


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault."""
    found = []
    for i, entry in enumerate(config):
        hit = struck(entry, given)
        each = hit.scale * np.radians(entry.rate_degps) * given.plant_step
        found.append(
            stage.block(records_of(PARAMS, len(each), start=hit.start, end=hit.end, step=each), name=f"drift {i}")
        )
    return found


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return what is reached as far as the surfaces have drifted at the time."""
    for entry in acting(config, rest.t):
        away = struck(entry, given).scale * np.radians(entry.rate_degps) * (rest.t - entry.start_s)
        reach = reach.scaled(np.ones(len(away)), away)
    return [reach]
