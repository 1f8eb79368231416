"""Scenario 2 as one system of ordinary differential equations: the paper's loop before it is sampled.

Model (7) with the hard limits of the scenario, outer loop (9) with observer (14) to (16), predictor and adaptive laws
(30) and (31), control law (32); the projection of (31) holds an estimate at its bound. It is what a general solver is
given to integrate, compiled by numba, so that the solver's own work is what is timed and not an interpreted right-hand
side. Parameters are read from the flight it is compared with.

State, shape (51,): x1, x2, x2_hat, omega_hat, eps_hat, v_ad, zeta, W_hat (5, 3), W_hat of the observer (5, 3).
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from uavftc.control.inner import l1
from uavftc.control.outer import ndi, nndo
from uavftc.core.stage import Block
from uavftc.flight.build import Flight
from uavftc.plants import analytic

SIZE = 51
DEG = np.pi / 180.0

PARAMS = np.dtype(
    [
        ("c", "f8", (9,)),  # coefficients of eq. (2)
        ("A_l", "f8", (3, 3)),
        ("A_m", "f8", (3, 3)),
        ("K_1", "f8", (3, 3)),
        ("B_m", "f8", (3, 3)),
        ("P_B_m", "f8", (3, 3)),
        ("K", "f8", (3, 3)),
        ("K_0", "f8", (3, 3)),
        ("D", "f8", (3,)),
        ("sigma", "f8", (3,)),
        ("gamma", "f8"),
        ("Gamma", "f8"),
        ("filter_bandwidth", "f8"),
        ("omega_min", "f8"),
        ("omega_max", "f8"),
        ("W_max", "f8"),
        ("eps_max", "f8"),
        ("centres", "f8", (5,)),
        ("width", "f8"),
        ("u_min", "f8", (3,)),
        ("u_max", "f8", (3,)),
        ("x1_c", "f8", (3,)),
    ]
)


def parameters(flight: Flight, x1_c: np.ndarray) -> np.ndarray:
    """Return one record of PARAMS, shape (1,), of an analytic flight of scenario 2 with the command x1_c, (3,), rad."""
    blocks = {id(block.stage): block.params[0] for block in flight.program.blocks if isinstance(block, Block)}
    inner, outer, observer = (blocks[id(m.stage)] for m in (l1, ndi, nndo))
    plant = blocks[id(analytic.stage)]
    limits = flight.scenario.limits_rad()
    values: dict[str, Any] = {
        "c": plant["c"],
        "A_l": plant["A_l"],
        "K_1": inner["A_s"] - inner["A_m"],
        "D": outer["D"],
        "sigma": observer["sigma"],
        "gamma": observer["gamma"],
        "u_min": limits[:, 0],
        "u_max": limits[:, 1],
        "x1_c": x1_c,
    }
    record = np.zeros(1, PARAMS)
    for name in PARAMS.names or ():
        record[name] = values[name] if name in values else inner[name]
    return record


def start(x1: np.ndarray) -> np.ndarray:
    """Return the state at t = 0, shape (51,), from the attitude x1, (3,), rad, at rest."""
    y = np.zeros(SIZE)
    y[0:3] = y[18:21] = x1
    y[9:12] = 1.0
    return y


def d2_of(t: float) -> tuple[float, float, float]:
    """Return scenario 2's disturbance at t, s: angular acceleration, rad/s^2."""
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


@numba.njit
def _held(rate, value, low, high):  # type: ignore[no-untyped-def]
    """Return the rate of an estimate, or 0 where it would leave its bounds."""
    return 0.0 if (value <= low and rate < 0.0) or (value >= high and rate > 0.0) else rate


@numba.njit(error_model="numpy")
def right_hand_side(t, y, p):  # type: ignore[no-untyped-def]
    """Return the derivative of the state, shape (51,)."""
    p = p[0]
    out = np.empty(51)
    x1, x2, x2_hat, omega, eps, v, zeta = y[0:3], y[3:6], y[6:9], y[9:12], y[12:15], y[15:18], y[18:21]
    s, c, tan, cos = np.sin(x1[0]), np.cos(x1[0]), np.tan(x1[1]), np.cos(x1[1])
    turn = x2[2] * c + x2[1] * s
    x1_dot = (x2[0] + turn * tan, x2[1] * c - x2[2] * s, turn / cos)  # (1)
    Phi = np.empty(5)  # (10)
    for n in range(5):
        square = 0.0
        for j in range(3):
            square += (x1[j] - p.centres[n]) ** 2 + (x2[j] - p.centres[n]) ** 2
        Phi[n] = np.exp(-square / (2.0 * p.width * p.width))
    d1_hat, lumped, gradient, e_1 = np.zeros(3), np.zeros(3), np.zeros(3), np.empty(3)
    for i in range(3):
        lumped[i] = eps[i]
        for n in range(5):
            lumped[i] += y[21 + 3 * n + i] * Phi[n]
            d1_hat[i] += y[36 + 3 * n + i] * Phi[n]
        for j in range(3):
            gradient[i] += (x2_hat[j] - x2[j]) * p.P_B_m[j, i]
        e_1[i] = p.D[i] * (p.x1_c[i] - x1[i]) - d1_hat[i]
    sin_theta = np.sin(x1[1])
    r = (e_1[0] - e_1[2] * sin_theta, e_1[1] * c + e_1[2] * s * cos, -e_1[1] * s + e_1[2] * c * cos)  # (9)
    g = p.c
    x2_dot = (  # (2)
        (g[0] * x2[2] + g[1] * x2[0]) * x2[1],
        g[4] * x2[0] * x2[2] - g[5] * (x2[0] * x2[0] - x2[2] * x2[2]),
        (g[7] * x2[0] - g[1] * x2[2]) * x2[1],
    )
    d2 = _d2(t)
    for i in range(3):
        model, command, plant = 0.0, lumped[i] + omega[i] * v[i], x2_dot[i] + d2[i]
        for j in range(3):
            command += p.K[i, j] * r[j]
            v2 = v[j] - p.K_0[0, j] * x2[0] - p.K_0[1, j] * x2[1] - p.K_0[2, j] * x2[2]
            u = min(max(v2, p.u_min[j]), p.u_max[j])
            plant += p.A_l[i, j] * x2[j] + p.B_m[i, j] * u
            model += p.A_m[i, j] * x2_hat[j] + p.B_m[i, j] * (omega[j] * v[j] + lumped[j])
            model += p.K_1[i, j] * (x2_hat[j] - x2[j])
        out[i] = x1_dot[i]
        out[3 + i] = plant  # (7)
        out[6 + i] = model  # (30)
        out[9 + i] = _held(-p.Gamma * gradient[i] * v[i], omega[i], p.omega_min, p.omega_max)  # (31)
        out[12 + i] = _held(-p.Gamma * gradient[i], eps[i], -p.eps_max, p.eps_max)
        out[15 + i] = -p.filter_bandwidth * command  # (32)
        out[18 + i] = p.sigma[i] * (x1[i] - zeta[i]) + x1_dot[i] + d1_hat[i]  # (14)
        for n in range(5):
            W = y[21 + 3 * n + i]
            out[21 + 3 * n + i] = _held(-p.Gamma * Phi[n] * gradient[i], W, -p.W_max, p.W_max)
            out[36 + 3 * n + i] = p.gamma * Phi[n] * (x1[i] - zeta[i])  # (16)
    return out
