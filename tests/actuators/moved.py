"""Servos moved by themselves: the blocks of a scenario's actuators on rows of given commands."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from flying import HALE, given_of
from uavftc.actuators import CHAIN
from uavftc.config.effect import config_of
from uavftc.core.given import Given
from uavftc.core.program import Program
from uavftc.core.signals import Shape, as_records, empty_rows
from uavftc.core.stage import Stage, law
from uavftc.plants.interface import Timing
from uavftc.scenario.schema import Scenario

RATE_HZ = 200
H = 1.0 / RATE_HZ
SEEN = np.dtype([("next", "i8"), ("deflection", "f8", (8192,))])


@law
def pass_on(p, s, e, row):
    """Begin the plant step as the allocation does."""
    e.deflection = e.command


@law
def look(p, s, e, row):
    """Keep the deflection of each plant step."""
    s.deflection[s.next] = e.deflection
    s.next += 1


begins, ends = Stage(pass_on), Stage(look, state=SEEN)


class Moved(NamedTuple):
    """What came of it; n effectors, N rows."""

    every: np.ndarray
    """Deflection at each plant step, shape (N substeps, n), rad."""
    servo: np.ndarray
    """Where the servo is at each sample, shape (N, n), rad."""
    blocks: tuple[str, ...]
    program: Program
    given: Given


def scenario(n: int, actuators: Any = None, faults: Any = ()) -> Scenario:
    """Return a scenario of n rows."""
    keys = {"name": "s", "duration_s": (n - 1) / RATE_HZ, "plant": "analytic", "faults": list(faults)}
    return Scenario.model_validate({**keys, "actuators": actuators or {}})


def given(of: Scenario, substeps: int = 1, **more: Any) -> Given:
    """Return what hale gives its actuators."""
    return given_of(Timing(H, substeps), of.steps, None, HALE)._replace(faults=tuple(of.faults), **more)


def moved(
    commands: Any, actuators: Any = None, faults: Any = (), *, substeps: int = 1, at_end: bool = False, **more: Any
) -> Moved:
    """Return what the servos of hale make of commands, shape (N,) for all alike or (N, 4), rad."""
    commands = np.asarray(commands, dtype=float)
    n = len(commands)
    of = scenario(n, actuators, faults)
    known = given(of, substeps, at_end=at_end, **more)
    blocks = [block for effect in CHAIN for block in effect.blocks(config_of(effect, of), known)]
    rows, shape = empty_rows(n, 4), Shape(4)
    records = as_records(rows, shape)
    records["t"] = of.times()
    records["effectors"]["effectiveness"] = 1.0
    records["effectors"]["command"] = commands[:, None] if commands.ndim == 1 else commands
    seen = np.zeros(4, SEEN)
    each = np.zeros(4, begins.params)
    program = Program(
        [], [begins.block(each, name="begin"), *blocks, ends.block(state=seen, name="look")], substeps=substeps
    )
    for first in range(0, n, 7):  # in pieces, as a flight is
        last = min(first + 7, n)
        assert program.run(rows, first, last) == last
    every = seen["deflection"][:, : n * substeps].T
    np.testing.assert_array_equal(records["effectors"]["deflection"], every[::substeps])
    names = tuple(block.name for block in blocks)
    return Moved(every, records["effectors"]["servo"].copy(), names, program, known)


__all__ = ["RATE_HZ", "H", "Moved", "given", "moved", "scenario"]
