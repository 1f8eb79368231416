"""Delay between command and surface: whole samples and a part of one.

A delay of (n + f) samples, 0 <= f < 1, means that over the sample [t_k, t_k+1) the surface first still follows the
command of sample k - n - 1, and from t_k + f h on that of sample k - n. Both go into the row: `u2` and `u2_late`.
Before the first sample the command is zero (trim). This stage is the first of the chain on a surface; the ones after
it work on both values.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.stage import RAW, Stage, carray, law

PARAMS = np.dtype(
    [
        ("whole", "i8"),  # n, samples
        ("partial", "f8"),  # f, of a sample
    ]
)
STATE = RAW  # (n + 3, 3): the slot of the next command in [0, 0], then the line of n + 2 commands, rad


@law
def step(p, line, row):
    """Push v2 into the line and write the delayed commands, rad, into u2 and u2_late."""
    length = p.whole + 2
    newest = int(line[0, 0])
    current = (newest - p.whole + length) % length
    before = (newest - p.whole - 1 + length) % length
    for i in range(3):
        line[1 + newest, i] = row.v2[i]
    for i in range(3):
        row.u2_late[i] = line[1 + current, i]
        row.u2[i] = line[1 + before, i] if p.partial > 0.0 else line[1 + current, i]
    line[0, 0] = (newest + 1) % length


@Stage(PARAMS, STATE)
def stage(p, s, row):
    """Entry."""
    params = carray(p, 1)[0]
    step(params, carray(s, (params.whole + 3, 3)), carray(row, 1)[0])


def memory(whole: int) -> np.ndarray:
    """Return the zeroed line of a delay of `whole` samples and a part, shape ((whole + 3) * 3,), rad."""
    return np.zeros((whole + 3) * 3)
