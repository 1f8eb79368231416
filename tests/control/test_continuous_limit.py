"""The sampled loop against the paper's continuous equations, integrated here by an independent solver.

Outer loop (9) with d1_hat = 0, predictor and adaptive laws (30) and (31), control law (32), on the model (7) with
A_l = A_m. No limit is active and no bound is reached.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import paper
from uavftc.control.inner import l1
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario

DURATION, EVERY = 2.0, 0.02  # s
STEP = np.radians([5.0, 5.0, 5.0])
D = 0.5
K = np.linalg.inv(paper.B_M) @ paper.A_M
NO_FAULT, NO_D2 = np.ones(3), np.zeros(3)
FAULT, D2 = np.array([0.6, 0.7, 0.8]), np.array([0.5, -1.0, 1.0])  # -, deg/s^2


def continuous(effectiveness, d2, method):
    """Attitude, (n, 3), rad, of the continuous closed loop; state: x1, x2, x2_hat, omega, eps, v_ad, W."""

    def rhs(_, y):
        x1, x2, x2_hat, omega, eps, v = y[:18].reshape(6, 3)
        W = y[18:].reshape(5, 3)
        G, Phi = paper.g1(x1), paper.phi(x1, x2)
        x2_tilde = x2_hat - x2
        gradient = x2_tilde @ paper.P @ paper.B_M
        eta = omega * v + W.T @ Phi + eps
        r = np.linalg.solve(G, D * (STEP - x1))
        return np.concatenate(
            [
                G @ x2,
                np.linalg.solve(paper.INERTIA, -np.cross(x2, paper.INERTIA @ x2))
                + paper.A_M @ x2 + paper.B_M @ (effectiveness * v) + np.radians(d2),
                paper.A_M @ x2_hat + paper.B_M @ eta + x2_tilde,
                -paper.GAMMA * gradient * v,
                -paper.GAMMA * gradient,
                -paper.BANDWIDTH * (eta + K @ r),
                -paper.GAMMA * np.outer(Phi, gradient).ravel(),
            ]
        )  # fmt: skip

    start = np.zeros(33)
    start[9:12] = 1.0
    t = np.arange(round(DURATION / EVERY) + 1) * EVERY
    solved = solve_ivp(rhs, (0.0, t[-1]), start, method=method, rtol=1e-6, atol=1e-8, t_eval=t)
    assert solved.success
    return solved.y[:3].T


def sampled(rate, effectiveness, d2):
    """The same attitude by the package, at `rate` Hz."""
    surfaces, axes = ("aileron", "elevator", "rudder"), ("p_degps2", "q_degps2", "r_degps2")
    flight = build_flight(
        Scenario.model_validate(
            {
                "name": "limit", "duration_s": DURATION, "plant": "analytic",
                "reference": {"phi_deg": 5, "theta_deg": 5, "psi_deg": 5},
                "controller": {"outer": {"kind": "ndi"}, "inner": {"kind": "l1"}, "rate_hz": rate},
                "faults": [
                    {"surface": s, "effectiveness": float(e)} for s, e in zip(surfaces, effectiveness, strict=True)
                ],
                "disturbances": [
                    {"kind": "angular-acceleration", **{a: float(d) for a, d in zip(axes, d2, strict=True)}}
                ],
            }
        )
    )  # fmt: skip
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    (state,) = (b.state[0] for b in flight.program.blocks if b.stage is l1.stage)
    assert (np.abs(state["omega_hat"] - 1.0) < 0.5).all()  # no bound is near
    return records["x1"][:: round(rate * EVERY)]


# Constant d2 or a fault from t = 0 excites the oscillation of the adaptation, at krad/s and lightly damped: an explicit
# method of high order resolves it in less time than an implicit one. Without them Radau takes large steps.
@pytest.mark.parametrize(
    ("effectiveness", "d2", "method", "allowed_deg"),
    [
        (NO_FAULT, NO_D2, "Radau", 0.014),
        (FAULT, NO_D2, "Radau", 0.018),
        (FAULT, D2, "DOP853", 0.018),
    ],
    ids=["nominal", "fault", "fault and d2"],
)
def test_sampled_loop_converges_to_the_continuous_one_at_first_order(effectiveness, d2, method, allowed_deg):
    # the law is the paper's: of a step of 5 deg the 200 Hz flight is off by less than 0.4 %, and five times the rate
    # means a fifth of that
    reference = continuous(effectiveness, d2, method)
    error = {
        rate: np.degrees(np.abs(sampled(rate, effectiveness, d2) - reference)).max(axis=0) for rate in (200, 1000, 5000)
    }
    assert error[200].max() < allowed_deg
    np.testing.assert_allclose(error[200] / error[1000], 5.0, rtol=0.05)
    np.testing.assert_allclose(error[1000] / error[5000], 5.0, rtol=0.05)
