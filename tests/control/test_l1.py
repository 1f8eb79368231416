"""The L1 law, eq. (32): filter, reference, linear feedback, and the closed loop at flight-computer rates."""

from __future__ import annotations

import numpy as np
import pytest

import paper
from uavftc.control.inner import l1
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario

RATES = [50, 100, 200, 1000]


def step_flight(rate, inner="l1", duration=20.0, **sections):
    """The paper's step of 5 deg on every axis, on the rotational model, limited and disturbed as in scenario 2."""
    return build_flight(
        Scenario.model_validate(
            {
                "name": "step", "duration_s": duration, "plant": "analytic",
                "reference": {"phi_deg": 5, "theta_deg": 5, "psi_deg": 5},
                "controller": {"inner": {"kind": inner}, "rate_hz": rate},
                "saturation": {"min_rad": -0.05, "max_rad": 0.1},
                "disturbances": [{"kind": "angular-acceleration", "p_degps2": 0.5, "q_degps2": -0.5, "r_degps2": 1}],
                **sections,
            }
        )
    )  # fmt: skip


@pytest.mark.parametrize("omega", [0.2, 1.0, 1.7])
@pytest.mark.parametrize("h", [0.02, 0.005, 0.001])
def test_filter_is_exact_at_every_rate(h, omega):
    # frozen estimates (Gamma = 0): v_ad = -(K r + f)/omega (1 - exp(-k omega t)) at the samples, whatever the rate
    r, f = np.array([0.1, -0.2, 0.3]), np.array([0.02, 0.01, -0.03])
    K = np.linalg.inv(paper.B_M) @ paper.A_M
    law = paper.Law(l1.stage, paper.inner_params(l1.PARAMS, h=h, Gamma=0.0))
    law(v1=r)  # t = 0: the filter starts empty
    np.testing.assert_array_equal(law.row["v2"], 0.0)
    law.state["omega_hat"], law.state["eps_hat"] = omega, f
    for k in range(1, 40):
        law(v1=r)
        share = 1.0 - np.exp(-paper.BANDWIDTH * omega * k * h)
        np.testing.assert_allclose(law.row["v2"], -(K @ r + f) / omega * share, rtol=1e-12, atol=1e-16)
    np.testing.assert_allclose(law.row["f_hat"], paper.B_M @ f, rtol=1e-14)


def test_filter_works_on_each_channel_with_its_own_effectiveness():
    # C(s) = k omega/(s + k omega) per channel: a weak surface is filtered more slowly
    omega, r = np.array([0.3, 1.0, 1.8]), np.array([0.1, 0.1, 0.1])
    law = paper.Law(l1.stage, paper.inner_params(l1.PARAMS, Gamma=0.0, K=np.eye(3), h=0.01))
    law(v1=r)
    law.state["omega_hat"] = omega
    law(v1=r)
    np.testing.assert_allclose(law.row["v2"], -r / omega * (1.0 - np.exp(-0.6 * omega)), rtol=1e-14)


def test_estimate_includes_the_network_on_the_new_sample():
    # the filter takes W' Phi with the basis of the sample just measured, not of the one before
    x1, x2 = np.array([0.1, -0.2, 2.1]), np.array([0.03, 0.02, -0.01])
    W = np.random.default_rng(9).normal(scale=0.1, size=(5, 3))
    law = paper.Law(l1.stage, paper.inner_params(l1.PARAMS, Gamma=0.0, psi_0=2.0))
    law(x1_meas=[0.0, 0.0, 2.0])
    law.state["W_hat"] = W
    law(x1_meas=x1, x2_meas=x2)
    f = W.T @ paper.phi(x1, x2, 2.0)
    np.testing.assert_allclose(law.row["f_hat"], paper.B_M @ f, rtol=1e-12)
    np.testing.assert_allclose(law.row["v2"], -f * (1.0 - np.exp(-0.3)), rtol=1e-12)


def test_linear_feedback_is_minus_K_0_transposed_x2():
    # v2 = -K_0' x2 + v_ad: the transpose matters, and v_ad itself (the predictor's input) is without it
    K_0 = np.arange(9.0).reshape(3, 3) / 10.0
    x2 = np.array([0.1, -0.2, 0.3])
    law = paper.Law(l1.stage, paper.inner_params(l1.PARAMS, Gamma=0.0, K_0=K_0))
    law(x2_meas=x2)
    np.testing.assert_allclose(law.row["v2"], -K_0.T @ x2, rtol=1e-14)
    np.testing.assert_array_equal(law.state["v_ad"], 0.0)


@pytest.mark.parametrize("rate", RATES)
def test_closed_loop_is_stable_and_accurate_at_every_rate(rate):
    # Gamma = 1e5 at rates where every explicit step is lost: the step is tracked, the disturbance rejected, no chatter
    flight = step_flight(rate)
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    error = np.degrees(np.abs(records["x1"][-1] - records["x1_c"][-1]))
    assert error.max() < 1e-3
    # travel of the command: one rise to the peak and back to the steady command, plus little
    assert np.abs(np.diff(records["v2"], axis=0)).sum(axis=0).max() < 0.15
    settled = records["t"] > 10.0
    np.testing.assert_allclose(np.degrees(records["f_hat"][settled]).mean(axis=0), [0.5, -0.5, 1.0], atol=1e-3)


@pytest.mark.parametrize("rate", RATES)
def test_estimates_stay_away_from_their_bounds(rate):
    # the bounds are not printed; the chosen ones must not bind in the paper's conditions
    flight = step_flight(rate)
    fly_to_memory(flight)
    (state,) = (b.state[0] for b in flight.program.blocks if b.stage is l1.stage)
    assert (state["omega_hat"] > 0.5).all()
    assert (state["omega_hat"] < 1.5).all()
    assert np.abs(state["W_hat"]).max() < 1.0
    assert np.abs(state["eps_hat"]).max() < 1.0
    assert np.abs(state["eps_hat"]).max() > 1e-4  # it did adapt
