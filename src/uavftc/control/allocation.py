"""Allocation: from the three axes that the laws command to the effectors of the aircraft, and back.

    command_j = sum_i M[j, i] v2[i]            before the actuators
    u2_i      = sum_j M^+[i, j] deflection_j   after them: what each axis gets

M is the mixing matrix of the aircraft and M^+ its pseudo-inverse. An effector that serves one axis, as those of a gang
do, takes the sum's one term; where each axis has one surface, both are exact.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.given import Given
from uavftc.core.layout import shares
from uavftc.core.stage import NOTHING, Block, Stage, law, records_of

GANG_PARAMS = np.dtype(
    [
        ("axis", "i8"),  # the one axis that the effector serves
        ("mix", "f8"),  # its entry of M
        ("share", "f8"),  # its entry of M^+
        ("first", "f8"),  # 1 for the first effector of the axis
        ("trim", "f8"),  # deflection at trim, rad
        ("read", "f8"),  # 1 where the plant reads the position
    ]
)
MIXED_PARAMS = np.dtype(  # row of M, column of M^+
    [("mix", "f8", (3,)), ("share", "f8", (3,)), ("first", "f8"), ("trim", "f8"), ("read", "f8")]
)


@law
def allocate_gang(p, s, e, row):
    """Write the command of an effector of one axis; the actuators begin with it as the deflection."""
    e.command = p.mix * row.v2[p.axis]
    e.deflection = e.command


@law
def gather_gang(p, s, e, row):
    """Add what an effector of one axis gives to it; where the plant does not read its position, write it."""
    if p.read == 0.0:
        e.position = p.trim + e.deflection
    part = p.share * e.deflection
    row.u2[p.axis] = part if p.first != 0.0 else row.u2[p.axis] + part


@law
def allocate_mixed(p, s, e, row):
    """Write the command of the effector; the actuators begin with it as the deflection."""
    e.command = p.mix[0] * row.v2[0] + p.mix[1] * row.v2[1] + p.mix[2] * row.v2[2]
    e.deflection = e.command


@law
def gather_mixed(p, s, e, row):
    """Add what the effector gives to each axis; where the plant does not read its position, write it."""
    if p.read == 0.0:
        e.position = p.trim + e.deflection
    for i in range(3):
        part = p.share[i] * e.deflection
        row.u2[i] = part if p.first != 0.0 else row.u2[i] + part


COMMAND = ["command", "deflection"]
GANG = (
    Stage(allocate_gang, GANG_PARAMS, NOTHING, reads=["v2"], writes=COMMAND),
    Stage(gather_gang, GANG_PARAMS, NOTHING, reads=["deflection", "u2"], writes=["u2", "position"]),
)
MIXED = (
    Stage(allocate_mixed, MIXED_PARAMS, NOTHING, reads=["v2"], writes=COMMAND),
    Stage(gather_mixed, MIXED_PARAMS, NOTHING, reads=["deflection", "u2"], writes=["u2", "position"]),
)


def blocks(given: Given) -> tuple[Block, Block]:
    """Return what turns axis commands into effector commands, and what turns deflections into those of the axes."""
    n, M = len(given.effectors), given.mixing
    axis, share = np.argmax(M != 0.0, axis=1), shares(M)
    trim = np.zeros(n) if given.trim_rad is None else given.trim_rad
    read = np.zeros(n) if given.read is None else np.asarray(given.read, dtype=float)
    if np.all(np.count_nonzero(M, axis=1) <= 1):
        first = [float(i not in axis[:j]) for j, i in enumerate(axis)]
        mix, own = M[np.arange(n), axis], share[np.arange(n), axis]
        params = records_of(GANG_PARAMS, n, axis=axis, mix=mix, share=own, first=first, trim=trim, read=read)
        stages = GANG
    else:
        first = [float(j == 0) for j in range(n)]
        params = records_of(MIXED_PARAMS, n, mix=M, share=share, first=first, trim=trim, read=read)
        stages = MIXED
    return stages[0].block(params, name="allocation"), stages[1].block(params, name="gather")
