"""Delay of a servo, of any length, behind that of the loop: u(t) becomes u(t - d), d = `delay_s`.

Over a plant step an effector gets the mean of what the delayed command is in it, as for the delay of the loop
(`delay.py`): exact for whole plant steps, and for parts of one in the mean. Before the first sample it is zero (trim).

A fault of the kind `delay` adds `delay_s`. No command is given twice or out of turn: at the beginning of the window the
servo stays where its command was, until the next one has waited long enough. After the window the line goes on with the
servo's own delay, and the commands that are older than it are left out.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from uavftc.actuators.delay import ago, through
from uavftc.actuators.fault import SurfaceFault
from uavftc.actuators.servo import Keys, note, part_of, schedule, servos, value_of
from uavftc.config.values import NonNegative, Positive
from uavftc.core.given import Given
from uavftc.core.stage import RAW, Block, Stage, floats, law, records_of

KEYS_IN = "actuators"

PARAMS = np.dtype(
    [
        ("count", "i8"),  # of switches of the delay
        ("length", "i8"),  # of the line, commands
    ]
)
STATE = RAW  # age of the last command given, plant steps, in [0]; switches, delays, plant steps, and how far each moved
# the servo, rad; the line
FIRST = 1  # place of the switches


class Config(Keys):
    """The delay of a servo."""

    delay_s: NonNegative = 0.0
    """pure delay of the servo, >= 0; `controller.delay_s` adds to it"""


class Added(SurfaceFault):
    """A servo that answers `delay_s` later than by itself on [start_s, end_s)."""

    kind: Literal["delay"] = "delay"
    """a servo that answers later"""
    delay_s: Positive
    """delay added to the servo's own, > 0"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"{1e3 * self.delay_s:g} ms late"


FAULT = Added


@law
def step(p, s, e, row):
    """Push the command into the line, and give the one that has waited long enough."""
    line = 3 * p.count + 3
    memory = floats(s, line + 1 + p.length)
    i = part_of(memory, FIRST, p.count, row.t)
    age = min(value_of(memory, FIRST, p.count, i), memory[0] + 1.0)  # a command grows older by one step a step
    memory[0] = age
    whole = int(age + 1e-9)
    part = age - whole
    e.deflection = through(memory[line:], p.length, e.deflection, whole, part if part > 1e-9 else 0.0)
    if i > 0:
        own = value_of(memory, FIRST, p.count, 0)
        whole = int(own + 1e-9)
        part = own - whole
        newest = int(memory[line]) - 1
        sooner = ago(memory[line:], p.length, newest, whole, part if part > 1e-9 else 0.0)
        note(memory, FIRST, p.count, i, e.deflection - sooner)


stage = Stage(step, PARAMS, STATE, reads=["deflection", "t"], writes=["deflection"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the line of each effector; none where nothing is delayed."""
    longest = (given.steps + 1) * given.h  # one longer than the flight acts as one of its length; the line stays small

    def steps(delay_s: float) -> float:
        return min(delay_s, longest) / given.plant_step

    own = [0.0 if servo.keys is None else servo.keys.delay_s for servo in servos(config, given)]
    delay = schedule(own, 0.0, Added, lambda d, fault: d + fault.delay_s, given)
    if not delay.acts.any():
        return []
    for row, count in zip(delay.table, delay.switches, strict=True):
        row[count : 2 * count + 1] = [steps(value) for value in row[count : 2 * count + 1]]
    ends = zip(delay.table, delay.switches, strict=True)
    length = max(math.floor(row[count : 2 * count + 1].max() + 1e-9) for row, count in ends) + 2
    n = len(own)
    state = np.zeros((n, delay.table.shape[1] + 2 + length))
    for line, row, count in zip(state, delay.table, delay.switches, strict=True):
        line[0] = np.inf  # it begins with a line full of zeros
        line[FIRST : FIRST + 3 * count + 2] = row[: 3 * count + 2]
    return [stage.block(records_of(PARAMS, n, count=delay.switches, length=[length] * n), state)]
