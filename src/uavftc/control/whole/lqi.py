"""Linear quadratic regulator with integral action, on the model linearised about the trim.

    x  = [x1 - x1_c; x2; xi],   xi' = x1 - x1_c                          (9,)
    x' = F x + G v2,   F = [0, g1, 0; 0, A, 0; I, 0, 0],   G = [0; B; 0],   g1 = g1(x1_trim)
    v2 = -K x within the limits,   K minimises the sum of x^T Q x + v2^T R v2

F and G are sampled exactly for a command held over a sample, and K is solved from the discrete Riccati equation, so
that K belongs to the rate at which it flies. Q and R follow Bryson's rule, one over the square of what is tolerable:
R from half the range of each surface, Q from the options `attitude_deg`, 5 deg, `rate_degps`, 10 deg/s, and
`integral_degs`, 5 deg s. The integral stands still while a command is beyond its limit (anti-windup).

Fewer axes: x holds angles, rates and integrals of the controlled ones; K has zeros for the others (docs/theory.md,
"Fewer axes").

Compiled, as an example of PARAMS, STATE, `stage` and `params(design, h, options)`.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, sin, tan
from typing import Any

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from uavftc.control.custom.controller import positive_options
from uavftc.core.axes import indices
from uavftc.core.given import ControlDesign
from uavftc.core.kinematics import wrapped
from uavftc.core.stage import Stage, law, params_of
from uavftc.core.statespace import StateSpace

UNLIMITED = 0.5  # rad, what a surface without limits counts for in R

PARAMS = np.dtype(
    [
        ("h", "f8"),  # sample time, s
        ("K", "f8", (3, 9)),  # rad per rad, rad/s and rad s
        ("v_min", "f8", (3,)),  # rad
        ("v_max", "f8", (3,)),
    ]
)
STATE = np.dtype([("xi", "f8", (3,)), ("x", "f8", (9,))])  # integral of the attitude error, rad s; x of the sample


def params(design: ControlDesign, h: float, options: Mapping[str, Any]) -> np.ndarray:
    """Return the parameters for a sample time h, s: the gain K and the limits."""
    chosen = positive_options(options, attitude_deg=5.0, rate_degps=10.0, integral_degs=5.0)
    own = indices(design.axes)
    tolerable = np.radians(np.repeat(list(chosen.values()), len(own)))
    reach = np.minimum(np.diff(design.limits_rad[own], axis=1)[:, 0] / 2.0, UNLIMITED)
    Phi, Gamma = sampled(design, h)
    Q, R = np.diag(tolerable**-2.0), np.diag(reach**-2.0)
    S = solve_discrete_are(Phi, Gamma, Q, R)
    K = np.zeros((3, 9))
    K[np.ix_(own, states(own))] = np.linalg.solve(R + Gamma.T @ S @ Gamma, Gamma.T @ S @ Phi)
    return params_of(PARAMS, h=h, K=K, v_min=design.limits_rad[:, 0], v_max=design.limits_rad[:, 1])


def linear(design: ControlDesign, h: float, options: Mapping[str, Any]) -> StateSpace:
    """Return the law about the trim and without limits: sampled, from [x1, x2], shape (6,), to v2; its state is xi."""
    K = params(design, h, options)["K"][0]
    to_xi = h * np.eye(3, 6)
    return StateSpace(np.eye(3), to_xi, -K[:, 6:], -K[:, :6])


def sampled(design: ControlDesign, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Phi, shape (3n, 3n), and Gamma, shape (3n, n), of x[k+1] = Phi x[k] + Gamma v2[k], n controlled axes."""
    FG = np.zeros((12, 12))
    phi, theta = design.x1_trim[:2]
    FG[0:3, 3:6] = [  # g1
        [1.0, sin(phi) * tan(theta), cos(phi) * tan(theta)],
        [0.0, cos(phi), -sin(phi)],
        [0.0, sin(phi) / cos(theta), cos(phi) / cos(theta)],
    ]
    FG[3:6, 3:6] = design.A
    FG[6:9, 0:3] = np.eye(3)
    FG[3:6, 9:12] = design.B
    own = indices(design.axes)
    n, kept = 3 * len(own), [*states(own), *(9 + own)]
    both = expm(h * FG[np.ix_(kept, kept)])
    return both[:n, :n], both[:n, n:]


def states(own: np.ndarray) -> np.ndarray:
    """Return where angles, rates and integrals of some axes are in x."""
    return np.concatenate([own, 3 + own, 6 + own])


@law
def step(p, s, row):
    """Write the command v2, rad, into the row."""
    for i in range(3):
        s.x[i] = row.x1_meas[i] - row.x1_c[i]
        s.x[3 + i] = row.x2_meas[i]
        s.x[6 + i] = s.xi[i]
    s.x[2] = wrapped(s.x[2])
    free = True
    for i in range(3):
        v = 0.0
        for j in range(9):
            v -= p.K[i, j] * s.x[j]
        free = free and p.v_min[i] <= v <= p.v_max[i]
        row.v2[i] = min(max(v, p.v_min[i]), p.v_max[i])
    if free:
        for i in range(3):
            s.xi[i] += p.h * s.x[i]


stage = Stage(step, PARAMS, STATE, reads=["x1_c", "x1_meas", "x2_meas"], writes=["v2"])
