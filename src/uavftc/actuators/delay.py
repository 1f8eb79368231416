"""Delay of the loop, between command and surface, of any length.

A delay of d plant steps and a part f of one, 0 <= f < 1: over a plant step the effector follows the command of d steps
ago, and during the first part f of the step still the one before it. It gets the mean of the two over the step,

    deflection = f command[d + 1] + (1 - f) command[d].

Before the first sample the command is zero (trim). Where `simulation.substeps` is left open, the plant's step is chosen
such that the delay is a whole number of them (`flight/timing.py`), and f = 0.
"""

from __future__ import annotations

import math

import numpy as np

from uavftc.config.values import Model, NonNegative
from uavftc.core.given import Given
from uavftc.core.stage import RAW, Block, Stage, floats, law, records_of

KEYS_IN = "controller"

PARAMS = np.dtype(
    [
        ("whole", "i8"),  # d, plant steps
        ("part", "f8"),  # f, of a plant step
    ]
)
STATE = RAW  # the place of the next command in [0], then the line of the last d + 2 commands, rad


class Config(Model):
    """Pure delay between command and surface."""

    delay_s: NonNegative = 0.0
    """pure delay between command and surface, >= 0"""


@law
def ago(line, length, newest, whole, part):
    """Return the value of the delay ago of a line whose newest is at a place, from -1 on."""
    current = line[1 + (newest - whole + length) % length]
    before = line[1 + (newest - whole - 1 + length) % length]
    return part * before + (1.0 - part) * current if part > 0.0 else current


@law
def through(line, length, value, whole, part):
    """Push a value into a line of so many, behind the place of the next; return the one of the delay ago."""
    newest = int(line[0])
    line[1 + newest] = value
    line[0] = (newest + 1) % length
    return ago(line, length, newest, whole, part)


@law
def step(p, s, e, row):
    """Push the deflection into the line, and give the effector the one of the delay ago."""
    length = p.whole + 2
    e.deflection = through(floats(s, length + 1), length, e.deflection, p.whole, p.part)


stage = Stage(step, PARAMS, STATE, reads=["deflection"], writes=["deflection"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the line of each effector; none without a delay."""
    if config.delay_s <= 0.0:
        return []
    # a delay longer than the flight acts as one of the flight's length; so the line stays small
    delay = min(config.delay_s, (given.steps + 1) * given.h) / given.plant_step
    whole = math.floor(delay + 1e-9)
    part = delay - whole if delay - whole > 1e-9 else 0.0
    n = len(given.effectors)
    return [stage.block(records_of(PARAMS, n, whole=[whole] * n, part=[part] * n), np.zeros((n, whole + 3)))]
