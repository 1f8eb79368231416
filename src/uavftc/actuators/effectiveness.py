"""Loss of effectiveness and additive fault, eq. (6): u2 = omega v2 + v_2a, after the saturation (eq. 7).

omega (`effectiveness`) and v_2a (`bias`) are signals of the row, so all four cases of the paper's section 2.2 and
their changes in time are one formula: (1) omega = 1, v_2a = 0, no fault; (2) omega < 1, v_2a = 0, loss of
effectiveness; (3) omega = 1, v_2a != 0, additive fault; (4) both.
"""

from __future__ import annotations

from uavftc.core.stage import NOTHING, Stage, carray, law

PARAMS = NOTHING
STATE = NOTHING


@law
def step(p, s, row):
    """Apply eq. (6) to u2 and u2_late in place."""
    for i in range(3):
        row.u2[i] = row.effectiveness[i] * row.u2[i] + row.bias[i]
        row.u2_late[i] = row.effectiveness[i] * row.u2_late[i] + row.bias[i]


@Stage(PARAMS, STATE)
def stage(p, s, row):
    """Entry."""
    step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])
