"""What of the row before a controller is shown, kept for it: positions of the effectors, and what the axes get.

`keep` runs at the end of each plant step, so what it holds at t_k is where the command of the row before has brought
each effector; where a position changes within a sample, the history of that row has it after the first plant step.
`recall` writes it into the row at its sample; what the plant reads itself stands there already. The actuators
then write over it.

Both are part of a flight only where a controller asks for positions or u2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavftc.core.given import Given
from uavftc.core.layout import shares
from uavftc.core.stage import NOTHING, Block, Stage, law, records_of

PARAMS = np.dtype(
    [
        ("read", "f8"),  # 1 where the plant reads the position
        ("share", "f8", (3,)),  # of each axis, per deflection
        ("first", "f8", (3,)),  # 1 for the first effector of the axis
        ("trim", "f8", (3,)),  # rad, what the last effector of the axis takes off: the trim of read positions
    ]
)
STATE = np.dtype([("position", "f8"), ("deflection", "f8")])  # rad


class Memory(NamedTuple):
    """Two blocks over one memory."""

    recall: Block
    """Of the sample."""
    keep: Block
    """Of the plant step."""


@law
def keep(p, s, e, row):
    """Keep where the effector has come to."""
    s.position = e.position
    s.deflection = e.deflection


@law
def recall(p, s, e, row):
    """Write what was kept: the position, and what the effector gives to each axis."""
    counted = s.deflection
    if p.read == 0.0:
        e.position = s.position
    else:
        counted = e.position
    for i in range(3):
        if p.share[i] != 0.0:
            part = p.share[i] * counted
            row.u2[i] = (part if p.first[i] != 0.0 else row.u2[i] + part) - p.trim[i]


keep_stage = Stage(keep, NOTHING, STATE, reads=["position", "deflection"], writes=[])
recall_stage = Stage(recall, PARAMS, STATE, reads=["u2"], writes=["position", "u2"])


def memory(given: Given) -> Memory:
    """Return the blocks, which hold the trim at first.

    What an axis gets is summed up as `allocation` does or, where a position is read, as the plant does.
    """
    n = len(given.effectors)
    share = shares(given.mixing)
    trim = np.zeros(n) if given.trim_rad is None else np.asarray(given.trim_rad, float)
    read = np.zeros(n, bool) if given.read is None else np.asarray(given.read, bool)
    first, last = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(3):
        members = np.flatnonzero(share[:, i])
        if members.size:
            first[members[0], i] = 1.0
            last[members[-1], i] = sum(share[j, i] * trim[j] for j in members if read[j])
    kept = np.zeros(n, STATE)
    kept["position"] = trim
    params = records_of(PARAMS, n, read=read.astype(float), share=share, first=first, trim=last)
    return Memory(recall_stage.block(params, kept, name="recall"), keep_stage.block(state=kept, name="keep"))
