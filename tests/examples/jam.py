"""A surface that jams: on [start_s, end_s) it stays where it was.

An example of a kind of fault in one file; it takes part by its place in `actuators.CHAIN`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.actuators.fault import SurfaceFault
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"

PARAMS = np.dtype([("start", "f8"), ("end", "f8")])  # s; a start that never comes for the other surfaces
STATE = np.dtype([("held", "f8")])  # rad


class Config(SurfaceFault):
    """A surface that stays where it is, on [start_s, end_s)."""

    kind: Literal["jam"] = "jam"

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "jammed"


@law
def step(p, s, e, row):
    """Hold the deflection inside the window, and remember it outside."""
    if p.start <= row.t < p.end:
        e.deflection = s.held
    s.held = e.deflection


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault: its surface has the window, the others have none."""
    return [block_of(entry, given, f"jam {i}") for i, entry in enumerate(config)]


def block_of(entry: Config, given: Given, name: str) -> Block:
    """Return the block of one fault; of a gang all effectors jam."""
    hit = np.array([j in given.targets[entry.surface] for j in range(len(given.effectors))])
    start = np.where(hit, entry.start_s, np.inf)
    end = np.full(len(hit), np.inf if entry.end_s is None else entry.end_s)
    return stage.block(records_of(PARAMS, len(hit), start=start, end=end), name=name)
