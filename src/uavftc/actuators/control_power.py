"""Control power lost to damage: a surface of which a part is gone does a part of what it did, at every deflection.

    total = trim + u,    u <- g (trim + u) - trim    on [start_s, end_s)

with u between the stops and g the `control_power` that `damage` leaves of the effector: the moment that is left is that
of the deflection g total. With g = 0 a surface makes no moment, its trim's neither. Of several damages at a time the
shares multiply. There is no memory: at `end_s` it is as before.

Approximate where a surface's moment is not linear in its deflection, and where its drag matters. A surface with a servo
in the aircraft's XML is commanded to g total: it still lags, and its position in the history is that of the share.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.saturation import sat
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, records_of

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s
        ("end", "f8"),  # s
        ("share", "f8"),  # g; 1 of an effector that the damage leaves alone
        ("trim", "f8"),  # rad
        ("u_min", "f8"),  # stops about trim, rad
        ("u_max", "f8"),
    ]
)
STATE = NOTHING


@law
def step(p, s, e, row):
    """Replace the deflection, between its stops, by that with the moment that is left."""
    if p.start <= row.t < p.end and p.share != 1.0:
        e.deflection = p.share * (p.trim + sat(e.deflection, p.u_min, p.u_max)) - p.trim


stage = Stage(step, PARAMS, STATE, reads=["deflection", "t"], writes=["deflection"])


def share_of(entry: Any, given: Given) -> np.ndarray:
    """Return the control power that a damage leaves of each effector, shape (n,)."""
    share = np.ones(len(given.effectors))
    for name, left in entry.control_power.items():
        for j in given.targets[name]:
            share[j] *= left
    return share


def blocks(config: None, given: Given) -> list[Block]:
    """Return the loss of each damage that takes control power; none without."""
    n = len(given.effectors)
    found = []
    for i, entry in enumerate(given.damage):
        if not entry.control_power:
            continue
        share = share_of(entry, given)
        params = records_of(
            PARAMS,
            n,
            start=np.full(n, entry.start_s),
            end=np.full(n, np.inf if entry.end_s is None else entry.end_s),
            share=share,
            trim=np.zeros(n) if given.trim_rad is None else given.trim_rad,
            u_min=given.stops_rad[:, 0],
            u_max=given.stops_rad[:, 1],
        )
        found.append(stage.block(params, name=f"control power {i}"))
    return found


def at_rest(config: None, given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return the deflections with the moments that are left."""
    n = len(given.effectors)
    trim = np.zeros(n) if given.trim_rad is None else np.asarray(given.trim_rad, dtype=float)
    for entry in acting(given.damage, rest.t):
        if entry.control_power:
            share = share_of(entry, given)
            stopped = np.where(share != 1.0, given.stops_rad.T, [[-np.inf], [np.inf]])
            reach = reach.within(*stopped).scaled(share, (share - 1.0) * trim)
    return [reach]
