"""The outer loop's dynamic inversion, eq. (9)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import paper
from uavftc.control.outer import ndi
from uavftc.core.stage import params_of

D = np.array([0.5, 0.8, 0.3])
VECTOR = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3).map(np.array)


@pytest.fixture(scope="module")
def law():
    return paper.Law(ndi.stage, params_of(ndi.PARAMS, D=D, axes=1.0))


@settings(deadline=None)  # the first example compiles
@given(phi=st.floats(-np.pi, np.pi), theta=st.floats(-1.4, 1.4), error=VECTOR, d1_hat=VECTOR)
def test_commanded_rates_give_the_attitude_rates_of_eq_8(law, phi, theta, error, d1_hat):
    # g1 v1 + d1_hat = D (x1_c - x1) at every attitude: the inversion is exact, the estimate is subtracted once
    x1 = np.array([phi, theta, 0.3])
    row = law(x1_meas=x1, x1_c=x1 + error, d1_hat=d1_hat)
    np.testing.assert_allclose(paper.g1(x1) @ row["v1"] + d1_hat, D * error, rtol=0, atol=1e-13 / np.cos(theta) * 10)


def test_ideal_loop_decays_as_exp_of_minus_D_t_on_each_axis(law):
    # x1' = g1 v1: every axis on its own, exp(-D t), from an attitude far outside the linear range
    x1_0, x1_c = np.radians([70.0, -55.0, 150.0]), np.radians([-20.0, 30.0, 60.0])
    t = np.linspace(0.0, 10.0, 41)
    solved = solve_ivp(
        lambda _, x1: paper.g1(x1) @ law(x1_meas=x1, x1_c=x1_c, d1_hat=0.0)["v1"],
        (0.0, 10.0), x1_0, t_eval=t, rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    expected = x1_c + np.exp(-np.outer(t, D)) * (x1_0 - x1_c)
    assert np.abs(solved.y.T - expected).max() < 1e-8


@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 4])
def test_heading_error_is_taken_the_short_way_round(law, turns):
    # psi is continuous and may have turned any number of times; the command is absolute
    psi, psi_c = np.radians([-170.0, 170.0])
    expected = D[2] * np.radians(-20.0)
    row = law(x1_meas=[0.0, 0.0, psi + 2 * np.pi * turns], x1_c=[0.0, 0.0, psi_c], d1_hat=0.0)
    np.testing.assert_allclose(row["v1"], [0.0, 0.0, expected], atol=1e-13)


def test_bank_and_pitch_errors_are_not_wrapped(law):
    # only the heading is an angle round the clock; 200 deg of bank error is 200 deg
    row = law(x1_meas=0.0, x1_c=[np.radians(200.0), np.radians(-200.0), 0.0], d1_hat=0.0)
    np.testing.assert_allclose(row["v1"], [D[0] * np.radians(200.0), -D[1] * np.radians(200.0), 0.0], atol=1e-13)
