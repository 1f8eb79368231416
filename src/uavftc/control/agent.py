"""An agent from outside in the loop: each step it says, from -1 to 1, how much of each axis' limits it commands.

    u_i = a_i u_max,i  for a_i >= 0,    -a_i u_min,i  for a_i < 0,    a_i clipped to [-1, 1]

In place of the inner loop v2 = u; assisting it v2 = v2 + u. What is not a number stays none, and ends the flight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, params_of
from uavftc.errors import InputError

REPLACE, ASSIST = "replace", "assist"
MODES = (REPLACE, ASSIST)
NAME = "agent"
"""Of its block in the program of a flight."""

PARAMS = np.dtype([("limits", "f8", (3, 2))])  # least and greatest of each axis about trim, rad
STATE = np.dtype([("action", "f8", (3,))])  # -1..1


class Agent(NamedTuple):
    """An agent in a flight: `mode` is one of `MODES`, `state` one record of `STATE`, which it writes before a row."""

    mode: str
    state: np.ndarray


@law
def scaled(action, least, greatest):
    """Return the deflection of an action, rad."""
    a = 1.0 if action > 1.0 else (-1.0 if action < -1.0 else action)
    return -a * least if a < 0.0 else a * greatest


@law
def command(p, s, row):
    """Command what the agent says."""
    for i in range(3):
        row.v2[i] = scaled(s.action[i], p.limits[i, 0], p.limits[i, 1])


@law
def assist(p, s, row):
    """Add what the agent says to the command."""
    for i in range(3):
        row.v2[i] += scaled(s.action[i], p.limits[i, 0], p.limits[i, 1])


_STAGES = {
    REPLACE: Stage(command, PARAMS, STATE, reads=[], writes=["v2"]),
    ASSIST: Stage(assist, PARAMS, STATE, reads=["v2"], writes=["v2"]),
}


def blocks(agent: Agent, given: Given) -> list[Block]:
    """Return the block of an agent.

    Raises
    ------
    InputError
        If an axis has no limits for it to be scaled by.
    """
    limits = np.array(given.design.limits_rad, dtype=float)
    if not np.isfinite(limits).all():
        raise InputError(
            "the limits of the surfaces",
            found="an axis without any",
            expected="a limit of each, which an action of 1 commands",
            remedy="set saturation: {min_rad: -0.4, max_rad: 0.4} in the scenario",
        )
    return [_STAGES[agent.mode].block(params_of(PARAMS, limits=limits), agent.state, name=NAME)]
