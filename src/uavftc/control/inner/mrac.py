"""Inner loop, model reference adaptive control: the paper's comparator of section 4.

The predictor and adaptive laws of `predictor.py` without the low-pass filter of the L1 law:

    v_ad = -(W_hat^T Phi + eps_hat + K r) / omega_hat,   v2 = -K_0^T x2 + v_ad

The paper names the comparator and states that its parameters are those of the L1 controller; it prints no equation.
This is the law that results when the filter bandwidth of eq. (32) tends to infinity. It commands from the first sample
on, where the L1 filter is still at zero.

With `anti_windup: limited` the predictor is given what was applied of v_ad (see `predictor.py`); there is no filter.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.control.inner.predictor import (
    PREDICTOR_PARAMS,
    PREDICTOR_STATE,
    PredictorConfig,
    advance,
    limited,
    lumped,
    predictor_params,
    start,
)
from uavftc.control.rbf import basis
from uavftc.core.given import Given
from uavftc.core.linear3 import multiply, multiply_transposed
from uavftc.core.stage import Block, Stage, law, params_of

PARAMS = np.dtype(
    [
        *PREDICTOR_PARAMS,
        ("K", "f8", (3, 3)),  # reference gain
        ("K_0", "f8", (3, 3)),  # linear feedback, v2_l = -K_0^T x2
    ]
)
STATE = np.dtype(PREDICTOR_STATE)


class Config(PredictorConfig):
    """Model reference adaptive control: the same predictor and laws without the low-pass filter."""

    kind: Literal["mrac"] = "mrac"
    """the same predictor and laws without the low-pass filter"""


@law
def step(p, s, row):
    """Write the command v2, rad, and the estimate f_hat, rad/s^2, into the row."""
    x2 = row.x2_meas
    if s.started != 0.0:
        advance(p, s, x2)
    else:
        start(s, x2)
    basis(row.x1_meas, x2, p.psi_0, p.axes, p.centres, p.width, s.Phi)
    f = (lumped(s, 0), lumped(s, 1), lumped(s, 2))
    K_r = multiply(p.K, row.v1)
    feedback = multiply_transposed(p.K_0, x2)
    for i in range(3):
        s.v_ad[i] = -(f[i] + K_r[i]) / s.omega_hat[i]
        row.v2[i] = limited(p, s, i, feedback[i])
    row.f_hat[0], row.f_hat[1], row.f_hat[2] = multiply(p.B_m, f)


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas", "v1"], writes=["v2", "f_hat"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the law, its gains computed from the design matrices."""
    return [stage.block(params_of(PARAMS, **predictor_params(config, given)))]
