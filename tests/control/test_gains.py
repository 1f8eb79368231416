"""The gains against the printed matrices and against the equations that define them."""

from __future__ import annotations

import numpy as np
import pytest

import paper
from uavftc.control.gains import erzberger_K_0, lyapunov_P, reference_gain
from uavftc.control.inner import l1, mrac

LAST_DIGIT = 0.5e-4 + 1e-12  # half a unit of the fourth decimal


def test_P_is_the_printed_one_to_all_four_decimals():
    # the only printed evidence for the signs of A_m and K_1 and for Q = I
    P = lyapunov_P(paper.A_S, np.eye(3))
    assert np.abs(P - paper.P_PRINTED).max() <= LAST_DIGIT
    assert np.abs(lyapunov_P(paper.A_M, np.eye(3)) - paper.P_PRINTED).max() > 0.01  # A_m in place of A_s is not it


def test_K_2_is_the_printed_one_to_all_four_decimals():
    # the printed gain is B_m^-1 A_s, which settles its sign
    assert np.abs(reference_gain(paper.A_S, paper.B_M) - paper.K_2_PRINTED).max() <= LAST_DIGIT


def test_P_solves_the_lyapunov_equation_for_any_Q():
    # the equation itself, and the solution of an independent method, for random stable A and positive Q
    rng = np.random.default_rng(1)
    for _ in range(50):
        A = rng.normal(size=(3, 3))
        A -= (np.linalg.eigvals(A).real.max() + rng.uniform(0.2, 2.0)) * np.eye(3)
        root = rng.normal(size=(3, 3))
        Q = root @ root.T + 0.1 * np.eye(3)
        P = lyapunov_P(A, Q)
        assert np.abs(A.T @ P + P @ A + Q).max() < 1e-11 * (1.0 + np.abs(P).max() * np.abs(A).max())
        np.testing.assert_allclose(P, paper.lyapunov(A, Q), rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(P, P.T)
        assert np.linalg.eigvalsh(P).min() > 0.0


def test_default_gain_has_unit_dc_gain_and_the_printed_one_does_not():
    # x2' = A_m x2 - B_m K r settles at A_m^-1 B_m K r: the command itself, or A_m^-1 A_s = I + A_m^-1 of it (K_1 = I),
    # less than half in pitch
    settled = [np.linalg.solve(paper.A_M, paper.B_M @ reference_gain(A, paper.B_M)) for A in (paper.A_M, paper.A_S)]
    np.testing.assert_allclose(settled[0], np.eye(3), atol=1e-14)
    np.testing.assert_allclose(settled[1], np.eye(3) + np.linalg.inv(paper.A_M), atol=1e-14)
    assert settled[1][1, 1] < 0.5


def test_erzberger_gain_matches_the_plant_to_the_reference_model():
    # A_l - B_m K_0^T = A_m is the matching condition; a transpose or a sign lost breaks it
    rng = np.random.default_rng(2)
    for _ in range(50):
        A_l = paper.A_M + rng.normal(size=(3, 3))
        K_0 = erzberger_K_0(A_l, paper.A_M, paper.B_M)
        np.testing.assert_allclose(A_l - paper.B_M @ K_0.T, paper.A_M, atol=1e-13)
    np.testing.assert_array_equal(erzberger_K_0(paper.A_M, paper.A_M, paper.B_M), np.zeros((3, 3)))


@pytest.mark.parametrize("law", [l1, mrac])
@pytest.mark.parametrize(("gain", "K"), [("plant", paper.A_M), ("printed", paper.A_S)])
def test_scenario_defaults_reach_the_law_as_the_papers_gains(law, gain, K):
    # P B_m, A_s and the gain that the section names follow from it; sample time and heading are the flight's
    config = law.Config(reference_gain=gain, B_m=tuple(map(tuple, paper.B_M)))
    (block,) = law.blocks(config, paper.flight_of(h=0.005, psi_0=0.3))
    p = block.params[0]
    np.testing.assert_allclose(p["P_B_m"], paper.P @ paper.B_M, atol=1e-12)
    np.testing.assert_allclose(p["K"], np.linalg.inv(paper.B_M) @ K, atol=1e-14)
    np.testing.assert_array_equal(p["A_s"], paper.A_S)
    assert (p["h"], p["psi_0"], p["Gamma"]) == (0.005, 0.3, 1e5)
