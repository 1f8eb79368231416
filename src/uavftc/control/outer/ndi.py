"""Outer loop, nonlinear dynamic inversion: eq. (9).

    v1 = g1(x1)^-1 ( D (x1_c - x1) - d1_hat )

The estimate d1_hat is read from the signal row: the observer of `outer/nndo.py` writes it when it is part of the
loop, and it is zero when it is not ("NDI-L1"). The heading error is taken the short way round.

Without a rudder there is no heading error to feed: r is what the airframe does, and roll and pitch are inverted given
the measured r (docs/theory.md, "Fewer axes"),

    theta' = (D e)_theta,   psi' = (r + theta' sin phi)/(cos phi cos theta),   [p, q, r] = g1^-1 [phi', theta', psi']

which is defined below 90 deg of bank. Without ailerons phi' is free; it acts on p alone. The third component of v1 is
then the measured rate.
"""

from __future__ import annotations

from math import cos, sin
from typing import Literal

import numpy as np

from uavftc.config.values import Model, PositiveVector3
from uavftc.core.given import Given
from uavftc.core.kinematics import body_rates, wrapped
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of

PARAMS = np.dtype(
    [
        ("D", "f8", (3,)),  # outer-loop bandwidth, 1/s
        ("axes", "f8", (3,)),  # 1 where the axis is controlled
    ]
)
STATE = NOTHING


class Config(Model):
    """Nonlinear dynamic inversion, v1 = g1^-1 D (x1c - x1); `bandwidth` is the diagonal of D, rad/s."""

    kind: Literal["ndi"] = "ndi"
    """dynamic inversion"""
    bandwidth: PositiveVector3 = (0.5, 0.5, 0.5)
    """diagonal of D, eq. (8), rad/s, > 0"""


@law
def step(p, s, row):
    """Write the commanded body rates v1, rad/s, into the row."""
    x1_c, x1, x2, d1_hat = row.x1_c, row.x1_meas, row.x2_meas, row.d1_hat
    phi_dot = p.D[0] * (x1_c[0] - x1[0]) - d1_hat[0]
    theta_dot = p.D[1] * (x1_c[1] - x1[1]) - d1_hat[1]
    psi_dot = p.D[2] * wrapped(x1_c[2] - x1[2]) - d1_hat[2]
    if p.axes[2] == 0.0:
        psi_dot = (x2[2] + theta_dot * sin(x1[0])) / (cos(x1[0]) * cos(x1[1]))
    row.v1[0], row.v1[1], row.v1[2] = body_rates(x1, (phi_dot, theta_dot, psi_dot))
    for i in range(3):
        if p.axes[i] == 0.0:
            row.v1[i] = x2[i]


stage = Stage(step, PARAMS, STATE, reads=["x1_c", "x1_meas", "x2_meas", "d1_hat"], writes=["v1"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the inversion; `config` is any with the bandwidth."""
    return [stage.block(params_of(PARAMS, D=config.bandwidth, axes=np.array(given.axes, float)))]
