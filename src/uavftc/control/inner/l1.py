"""Inner loop, L1 adaptive control law: eq. (32) over the predictor of `predictor.py`.

    v_ad(s) = -K_3 D(s) ( eta_hat(s) + K r(s) ),   K_3 D(s) = k/s,   k = 60 rad/s
    eta_hat = omega_hat v_ad + W_hat^T Phi + eps_hat
    v2      = -K_0^T x2 + v_ad

with r = v1, the body rates that the outer loop commands. Per channel the loop is the low-pass filter
C(s) = k omega / (s + k omega).

Deviation from the print: eq. (32) reads eta_hat - K_2 r, and the printed K_2 equals B_m^-1 A_s, so that the rates
would converge to minus the command; here K stands with a plus. The gain K is `gains.reference_gain`.

Sampled form: with omega_hat, the estimates and r held over the step the filter is solved exactly,

    v_ad_new = a v_ad - (1 - a) (W_hat^T Phi + eps_hat + K r) / omega_hat,   a = exp(-k h omega_hat), per channel.

Backward Euler in its place doubles the distance to the continuous limit.

With `anti_windup: limited` v_ad is set to what was applied of it (see `predictor.py`), and the filter goes on from
there.
"""

from __future__ import annotations

from math import exp
from typing import Literal

import numpy as np

from uavftc.config.values import Positive
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
        ("filter_bandwidth", "f8"),  # k, rad/s
        ("K", "f8", (3, 3)),  # reference gain
        ("K_0", "f8", (3, 3)),  # linear feedback, v2_l = -K_0^T x2
    ]
)
STATE = np.dtype(PREDICTOR_STATE)


class Config(PredictorConfig):
    """L1 adaptive control, eqs. (28)-(35); `filter_bandwidth` in rad/s."""

    kind: Literal["l1"] = "l1"
    """L1 adaptive control"""
    filter_bandwidth: Positive = 60.0
    """bandwidth k of the filter C(s), rad/s, > 0"""


@law
def step(p, s, row):
    """Write the command v2, rad, and the estimate f_hat, rad/s^2, into the row."""
    x2 = row.x2_meas
    started = s.started != 0.0
    if started:
        advance(p, s, x2)
    else:
        start(s, x2)
    basis(row.x1_meas, x2, p.psi_0, p.axes, p.centres, p.width, s.Phi)
    f = (lumped(s, 0), lumped(s, 1), lumped(s, 2))
    K_r = multiply(p.K, row.v1)
    feedback = multiply_transposed(p.K_0, x2)
    for i in range(3):
        if started:
            a = exp(-p.filter_bandwidth * p.h * s.omega_hat[i])
            s.v_ad[i] = a * s.v_ad[i] - (1.0 - a) * (f[i] + K_r[i]) / s.omega_hat[i]
        row.v2[i] = limited(p, s, i, feedback[i])
    row.f_hat[0], row.f_hat[1], row.f_hat[2] = multiply(p.B_m, f)


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas", "v1"], writes=["v2", "f_hat"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the law, its gains computed from the design matrices."""
    return [stage.block(params_of(PARAMS, **predictor_params(config, given), filter_bandwidth=config.filter_bandwidth))]
