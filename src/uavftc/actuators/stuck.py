"""A surface that is stuck: on [start_s, end_s) it stays where it is, or where `at_deg` says.

    total deflection = at                    given: there at once
    total deflection = that of the plant step before the window      left out

Memory: outside its window it remembers the deflection and changes nothing, so the surface is free from the first
sample at or after `end_s`. A flight that begins with the fault has the surface stuck at trim.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, beyond_stops, put, struck
from uavftc.config.values import Number
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s; one that never comes for the other surfaces
        ("end", "f8"),  # s
        ("given", "f8"),  # 1 where the place is given
        ("at", "f8"),  # rad, about trim
    ]
)
STATE = np.dtype([("held", "f8"), ("most", "f8")])  # rad, about trim; rad, how far it moved the surface


class Config(SurfaceFault):
    """A surface that is stuck on [start_s, end_s)."""

    kind: Literal["stuck"] = "stuck"
    """stays where it is, or at `at_deg`"""
    at_deg: Number | None = None
    """total deflection at which it stays, as the aircraft counts it; `null` is where it is"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "stuck" if self.at_deg is None else f"stuck at {self.at_deg:g} deg"


@law
def step(p, s, e, row):
    """Hold the deflection inside the window, and remember it outside."""
    if p.start <= row.t < p.end:
        put(s, e, p.at if p.given != 0.0 else s.held)
    else:
        s.held = e.deflection


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault: its surfaces have the window, the others have none."""
    return [block_of(entry, given, f"stuck {i}") for i, entry in enumerate(config)]


def block_of(entry: Config, given: Given, name: str) -> Block:
    """Return the block of one fault."""
    hit = struck(entry, given)
    n = len(hit.start)
    at = np.zeros(n) if entry.at_deg is None else hit.scale * np.radians(entry.at_deg) - hit.trim
    there = np.full(n, float(entry.at_deg is not None))
    return stage.block(records_of(PARAMS, n, start=hit.start, end=hit.end, given=there, at=at), name=name)


def remarks(entry: Config, given: Given) -> list[tuple[str, str]]:
    """Return (key, line) where the place is beyond a stop."""
    return [] if entry.at_deg is None else beyond_stops(entry, given, "at_deg", entry.at_deg)


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return it with each surface where it is stuck; where that is not given, where it was before."""
    for entry in acting(config, rest.t):
        hit = struck(entry, given)
        there = hit.scale * np.radians(entry.at_deg) - hit.trim if entry.at_deg is not None else None
        reach = reach.put(np.isfinite(hit.start), rest.before(entry.start_s) if there is None else there)
    return [reach]
