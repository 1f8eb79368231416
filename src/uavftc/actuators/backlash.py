"""Backlash between a servo and its surface: the surface rests while the servo crosses the play.

y moves only where it is pushed:    y = u - w/2 for u - y > w/2,    y = u + w/2 for y - u > w/2,    w = `backlash_deg`

The last part of a servo. Its memory is the surface, at first in the middle of the play at trim. The servo moves along a
curve within a plant step and is given to this law by its mean. A fault of the kind `backlash` widens the play to
`width_deg`; one that is wider by itself stays as it is. The play widens about where the surface is. After the window
the surface goes on from where it is, and where the servo's own play does not reach that far, it is moved to its edge at
once.
"""

from __future__ import annotations

from math import radians
from typing import Literal

import numpy as np

from uavftc.actuators.fault import SurfaceFault
from uavftc.actuators.servo import Keys, Schedule, note, part_of, schedule, servos, value_of
from uavftc.config.values import NonNegative, Positive
from uavftc.core.given import Given
from uavftc.core.stage import RAW, Block, Stage, floats, law, records_of

KEYS_IN = "actuators"

PARAMS = np.dtype([("count", "i8")])  # of switches of the width
STATE = RAW  # y, rad, in [0], then the switches, the widths, rad, and how far each moved the surface
FIRST = 1  # place of the switches


class Config(Keys):
    """The play between a servo and its surface."""

    backlash_deg: NonNegative = 0.0
    """width of the play, from one side to the other, >= 0"""


class Widened(SurfaceFault):
    """A play of `width_deg` between servo and surface on [start_s, end_s)."""

    kind: Literal["backlash"] = "backlash"
    """play between the servo and its surface"""
    width_deg: Positive
    """width, from one side to the other, > 0; a play that is wider by itself stays as it is"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"{self.width_deg:g} deg of backlash"


FAULT = Widened


@law
def pushed(y, u, half):
    """Return where a surface at y is when the servo is at u, rad, with half of the play."""
    if u - y > half:
        return u - half
    if y - u > half:
        return u + half
    return y if u - y <= half else u  # nan


@law
def step(p, s, e, row):
    """Move the surface as far as it is pushed."""
    memory = floats(s, 3 * p.count + 3)
    i = part_of(memory, FIRST, p.count, row.t)
    u, y = e.deflection, memory[0]
    e.deflection = pushed(y, u, 0.5 * value_of(memory, FIRST, p.count, i))
    if i > 0:
        note(memory, FIRST, p.count, i, e.deflection - pushed(y, u, 0.5 * value_of(memory, FIRST, p.count, 0)))
    memory[0] = e.deflection


stage = Stage(step, PARAMS, STATE, reads=["deflection", "t"], writes=["deflection"])


def widths(config: Keys, given: Given) -> Schedule:
    """Return the play of each effector in time, rad."""
    own = [0.0 if servo.keys is None else radians(servo.keys.backlash_deg) for servo in servos(config, given)]
    return schedule(own, 0.0, Widened, lambda w, fault: max(w, radians(fault.width_deg)), given)


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the play of each effector; none where there is none."""
    width = widths(config, given)
    if not width.acts.any():
        return []
    state = np.column_stack([np.zeros(len(width.table)), width.table])
    return [stage.block(records_of(PARAMS, len(state), count=width.switches), state)]
