"""Scenario 2 as one system of ordinary differential equations: the paper's loop before it is sampled.

A general solver integrates it. It is compiled by numba, so that the solver's work is timed and not an interpreted
right-hand side. The equations are those of the flight it is compared with, called with its
parameters: model (7) `analytic.derivative`, limits (20) `saturation.sat`, outer loop (9) `ndi.step`, predictor and
adaptive laws (30) and (31) `predictor.advance`. What the flight has in a sampled form only stands here in the
continuous one: the projection of (31), which holds an estimate at its bound, observer (14) to (16), control law (32).

State, shape (51,): x1, x2, x2_hat, omega_hat, eps_hat, v_ad, zeta, W_hat (5, 3), W_hat of the observer (5, 3).
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from uavftc.actuators import saturation
from uavftc.actuators.saturation import sat
from uavftc.control.inner import l1
from uavftc.control.inner.predictor import advance, lumped
from uavftc.control.outer import ndi, nndo
from uavftc.control.rbf import NODES, basis
from uavftc.core.kinematics import attitude_rates
from uavftc.core.linear3 import multiply, multiply_transposed
from uavftc.core.stage import Block
from uavftc.flight.build import Flight
from uavftc.plants import analytic

SIZE = 51
DEG = np.pi / 180.0

LOOP = np.dtype(
    [
        # parameters
        ("plant", analytic.PARAMS),
        ("outer", ndi.PARAMS),
        ("observer", nndo.PARAMS),
        ("inner", l1.PARAMS),
        ("u_min", "f8", (3,)),  # rad
        ("u_max", "f8", (3,)),
        ("omega_min", "f8"),  # bounds of the estimates
        ("omega_max", "f8"),
        ("W_max", "f8"),  # rad
        ("eps_max", "f8"),  # rad
        # memory of the laws, written anew in each call
        ("nothing", ndi.STATE),
        ("signals", [(name, "f8", (3,)) for name in ("x1_c", "x1_meas", "x2_meas", "d1_hat", "v1")]),
        ("state", l1.STATE),
        ("Phi", "f8", (NODES,)),  # of the observer
    ]
)


def loop_of(flight: Flight, x1_c: np.ndarray) -> np.ndarray:
    """Return one record of LOOP, shape (1,), of an analytic flight of scenario 2 with the command x1_c, (3,), rad."""
    params: dict[int, np.ndarray] = {}
    for block in flight.program.blocks:
        if isinstance(block, Block):  # the first of each: limits may follow limits
            params.setdefault(id(block.stage), block.params)
    record = np.zeros(1, LOOP)
    for name, module in (("plant", analytic), ("outer", ndi), ("observer", nndo), ("inner", l1)):
        record[name] = params[id(module.stage)]
    own = np.argmax(flight.given.mixing, axis=0)  # of each axis the effector that moves as it does
    for name in ("u_min", "u_max"):
        record[name] = np.ravel(params[id(saturation.stage)][name])[own]
    # An explicit step of 1 s without bounds moves the state of (30) and (31) by its rate.
    record["inner"]["h"] = record["inner"]["explicit"] = 1.0
    for name, free in (("omega_min", -np.inf), ("omega_max", np.inf), ("W_max", np.inf), ("eps_max", np.inf)):
        record[name] = record["inner"][name]
        record["inner"][name] = free
    record["signals"]["x1_c"] = x1_c
    return record


def start(x1: np.ndarray) -> np.ndarray:
    """Return the state at t = 0, shape (51,), from the attitude x1, (3,), rad, at rest."""
    y = np.zeros(SIZE)
    y[0:3] = y[18:21] = x1
    y[9:12] = 1.0
    return y


def d2_of(t: float) -> tuple[float, float, float]:
    """Return scenario 2's disturbance at t, s: angular acceleration, rad/s^2 (a test compares it with the flight's)."""
    if t < 10.0:
        return (
            DEG * (0.1 + 0.5 * np.sin(t)),
            DEG * (0.3 + np.sin(2.0 * t)),
            DEG * (0.5 + 1.5 * np.sin(3.0 * t)),
        )
    if t < 13.0:
        return DEG * 0.2, DEG * 0.2, DEG * 0.2
    return DEG * np.sin(0.1 * t), DEG * np.cos(0.2 * t), DEG * np.sin(0.5 * t)


_d2 = numba.njit(d2_of)


@numba.njit(error_model="numpy")
def _observer(
    p: Any, x1: Any, x1_dot: Any, zeta: Any, W: Any, Phi: Any, d1_hat: Any, zeta_dot: Any, W_dot: Any
) -> None:
    """Write the estimate d1_hat, rad/s, and the rates of zeta and W: eqs. (14) to (16)."""
    for i in range(3):
        d1_hat[i] = 0.0
        for n in range(NODES):
            d1_hat[i] += W[n, i] * Phi[n]
        e = x1[i] - zeta[i]  # (15)
        zeta_dot[i] = p.sigma[i] * e + x1_dot[i] + d1_hat[i]  # (14)
        for n in range(NODES):
            W_dot[n, i] = p.gamma * Phi[n] * e  # (16)


@numba.njit(error_model="numpy")
def _command_rate(p: Any, s: Any, v1: Any, v_ad_dot: Any) -> None:
    """Write the rate of v_ad, rad/s: control law (32) with K_3 D(s) = k/s."""
    K_r = multiply(p.K, v1)
    for i in range(3):
        v_ad_dot[i] = -p.filter_bandwidth * (s.omega_hat[i] * s.v_ad[i] + lumped(s, i) + K_r[i])


@numba.njit(error_model="numpy")
def _held(rate: float, value: float, low: float, high: float) -> float:
    """Return the rate of an estimate, or 0 where it would leave its bounds: the projection of (31)."""
    return 0.0 if (value <= low and rate < 0.0) or (value >= high and rate > 0.0) else rate


@numba.njit(error_model="numpy")
def right_hand_side(t: float, y: np.ndarray, loop: np.ndarray) -> np.ndarray:
    """Return the derivative of the state, shape (51,), s^-1; the memory in the record `loop` is overwritten."""
    q: Any = loop[0]
    out = np.empty(SIZE)
    inner, s, signals, Phi = q.inner, q.state, q.signals, q.Phi
    x1, x2, x2_hat, zeta = y[0:3], y[3:6], y[6:9], y[18:21]
    weights = y[21:51].copy()  # a solver may hand out a column of a matrix
    W, W_observer = weights[:15].reshape(NODES, 3), weights[15:].reshape(NODES, 3)

    for i in range(3):
        signals.x1_meas[i], signals.x2_meas[i] = x1[i], x2[i]
        s.x2[i], s.x2_hat[i], s.x2_tilde[i] = x2[i], x2_hat[i], x2_hat[i] - x2[i]
        s.omega_hat[i], s.eps_hat[i], s.v_ad[i] = y[9 + i], y[12 + i], y[15 + i]
        for n in range(NODES):
            s.W_hat[n, i] = W[n, i]
    basis(x1, x2, q.observer.psi_0, q.observer.axes, q.observer.centres, q.observer.width, Phi)
    basis(x1, x2, inner.psi_0, inner.axes, inner.centres, inner.width, s.Phi)

    x1_dot = attitude_rates(x1, x2)
    _observer(q.observer, x1, x1_dot, zeta, W_observer, Phi, signals.d1_hat, out[18:21], out[36:51].reshape(NODES, 3))
    ndi.step(q.outer, q.nothing, signals)
    _command_rate(inner, s, signals.v1, out[15:18])

    v_l = multiply_transposed(inner.K_0, x2)
    u2 = (
        sat(s.v_ad[0] - v_l[0], q.u_min[0], q.u_max[0]),
        sat(s.v_ad[1] - v_l[1], q.u_min[1], q.u_max[1]),
        sat(s.v_ad[2] - v_l[2], q.u_min[2], q.u_max[2]),
    )
    out[0:3], out[3:6] = analytic.derivative(q.plant, x1, x2, u2, (0.0, 0.0, 0.0), _d2(t))

    advance(inner, s, x2)
    for i in range(3):
        omega, eps = y[9 + i], y[12 + i]
        out[6 + i] = s.x2_hat[i] - x2_hat[i]
        out[9 + i] = _held(s.omega_hat[i] - omega, omega, q.omega_min, q.omega_max)
        out[12 + i] = _held(s.eps_hat[i] - eps, eps, -q.eps_max, q.eps_max)
        for n in range(NODES):
            out[21 + 3 * n + i] = _held(s.W_hat[n, i] - W[n, i], W[n, i], -q.W_max, q.W_max)
    return out
