"""Dead band of a servo: it does not answer a command within half the width of it about trim.

y = 0 for |u| <= w/2,    y = u - sign(u) w/2 beyond,    w = `deadband_deg`

The first part of a servo, ahead of its delay. A fault of the kind `deadband` widens it to `width_deg`; one that is
wider by itself stays as it is. It has no memory: from the end of the window on it is the servo's own.
"""

from __future__ import annotations

from math import isnan, radians
from typing import Literal

import numpy as np

from uavftc.actuators.fault import SurfaceFault
from uavftc.actuators.servo import Keys, note, part_of, schedule, servos, value_of
from uavftc.config.values import NonNegative, Positive
from uavftc.core.given import Given
from uavftc.core.stage import RAW, Block, Stage, floats, law, records_of

KEYS_IN = "actuators"

PARAMS = np.dtype([("count", "i8")])  # of switches of the width
STATE = RAW  # the switches and the widths, rad, and how far each moved the servo
FIRST = 0  # place of the switches


class Config(Keys):
    """The dead band of a servo."""

    deadband_deg: NonNegative = 0.0
    """width of the dead band about trim, >= 0"""


class Widened(SurfaceFault):
    """A servo with a dead band of `width_deg` on [start_s, end_s)."""

    kind: Literal["deadband"] = "deadband"
    """a servo that does not answer small commands"""
    width_deg: Positive
    """width of the band, > 0; a servo whose own is wider keeps it"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"{self.width_deg:g} deg of dead band"


FAULT = Widened


@law
def without(u, half):
    """Return a command, rad, without what is within half the width of the dead band; nan stays nan."""
    if u > half:
        return u - half
    if u < -half:
        return u + half
    return u if isnan(u) else 0.0


@law
def step(p, s, e, row):
    """Take the dead band out of the command in place."""
    memory = floats(s, 3 * p.count + 2)
    i = part_of(memory, FIRST, p.count, row.t)
    u = e.deflection
    e.deflection = without(u, 0.5 * value_of(memory, FIRST, p.count, i))
    if i > 0:
        note(memory, FIRST, p.count, i, e.deflection - without(u, 0.5 * value_of(memory, FIRST, p.count, 0)))


stage = Stage(step, PARAMS, STATE, reads=["deflection", "t"], writes=["deflection"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the dead band of each effector; none where there is none."""
    own = [0.0 if servo.keys is None else radians(servo.keys.deadband_deg) for servo in servos(config, given)]
    width = schedule(own, 0.0, Widened, lambda w, fault: max(w, radians(fault.width_deg)), given)
    if not width.acts.any():
        return []
    return [stage.block(records_of(PARAMS, len(own), count=width.switches), width.table)]
