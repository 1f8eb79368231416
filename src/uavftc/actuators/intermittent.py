"""An intermittent fault: on [start_s, end_s) eq. (6) comes and goes, u2 = omega v2 + v_2a while it is there.

It is there when the window begins. How long it stays, and how long it is away, is exponentially distributed with the
means `on_s` and `off_s`: a telegraph process. The times are drawn from the scenario's seed, the kind and the place of
the fault among its kind, so no other fault changes them. No memory beyond the window.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, struck
from uavftc.config.values import NonNegative, Number, Positive
from uavftc.core.given import Given
from uavftc.core.random import stream
from uavftc.core.stage import RAW, Block, Stage, floats, law, records_of

ENTRY_OF = "faults"

MOST_CHANGES = 1_000_000  # of one fault in a flight, 8 bytes each

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s; one that never comes for the other surfaces
        ("end", "f8"),  # s
        ("effectiveness", "f8"),  # omega
        ("bias", "f8"),  # v_2a, rad
        ("changes", "i8"),  # how many times it comes or goes
    ]
)
MOST = 1  # place in the memory of how far it moved the surface, rad
STATE = RAW  # the place of the next change, rad how far it moved the surface, then the times of the changes, s


class Config(SurfaceFault):
    """A loss of effectiveness and a bias that come and go on [start_s, end_s)."""

    kind: Literal["intermittent"] = "intermittent"
    """an effectiveness and a bias that come and go at random"""
    on_s: Positive
    """mean time for which it is there"""
    off_s: Positive
    """mean time for which it is away"""
    effectiveness: NonNegative = 0.0
    """effectiveness while it is there, >= 0"""
    bias_deg: Number = 0.0
    """added to the deflection while it is there"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        bias = f", bias {self.bias_deg:g} deg" if self.bias_deg else ""
        return f"intermittent\nω = {self.effectiveness:g}{bias}"


@law
def step(p, s, e, row):
    """Apply eq. (6) while the fault is there."""
    changes = floats(s, 2 + p.changes)
    if p.start <= row.t < p.end:
        k = int(changes[0])
        while k < p.changes and row.t >= changes[2 + k]:
            k += 1
        changes[0] = k
        if k % 2 == 0:
            before = e.deflection
            e.deflection = p.effectiveness * before + p.bias
            changes[MOST] = max(changes[MOST], abs(e.deflection - before))


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def changes_of(entry: Config, given: Given, index: int) -> np.ndarray:
    """Return the times at which the fault goes and comes, s, rising; the first of them is when it goes."""
    end = given.steps * given.h
    last = end if entry.end_s is None else min(entry.end_s, end)
    random = stream(given.seed, "intermittent", index)
    times: list[float] = []
    t = entry.start_s
    while t < last and len(times) < MOST_CHANGES:
        t += random.exponential(entry.off_s if len(times) % 2 else entry.on_s)
        times.append(t)
    return np.array(times)


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault."""
    found = []
    for i, entry in enumerate(config):
        hit, times = struck(entry, given), changes_of(entry, given, i)
        n = len(hit.start)
        params = records_of(
            PARAMS,
            n,
            start=hit.start,
            end=hit.end,
            effectiveness=np.full(n, entry.effectiveness),
            bias=hit.weight * np.radians(entry.bias_deg),
            changes=np.full(n, len(times)),
        )
        memory = np.concatenate([np.zeros((n, 2)), np.tile(times, (n, 1))], axis=1)
        found.append(stage.block(params, memory, name=f"intermittent {i}"))
    return found


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return what is reached while each fault is there, and while it is away."""
    found = [reach]
    for entry in acting(config, rest.t):
        hit = struck(entry, given)
        gain = np.where(np.isfinite(hit.start), entry.effectiveness, 1.0)
        found += [one.scaled(gain, hit.weight * np.radians(entry.bias_deg)) for one in found]
    return found
