"""The regulator against the Riccati equation and its optimum, and in the paper's scenarios."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from flying import flown
from uavftc.control.whole import lqi
from uavftc.core.given import ControlDesign
from uavftc.core.kinematics import attitude_rates
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows

A = np.array([[-8.5, 1.2, -3.5], [-1.5, -1.5, -1.0], [-0.02, 0.0, -2.0]])
B = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])
H = 0.005
DESIGN = ControlDesign(A, B, np.array([[-0.05, 0.1]] * 3), np.array([0.1, 0.2, 0.3]), "test")


def test_the_sampled_model_is_the_kinematics_and_the_linear_pair():
    # x1' = g1(x1_trim) x2 by the project's kinematics, x2' = A x2 + B v2, xi' = x1, over one sample
    Phi, Gamma = lqi.sampled(DESIGN, H)
    slow, _ = lqi.sampled(DESIGN, 1e-7)
    for i, axis in enumerate(np.eye(3)):
        np.testing.assert_allclose(slow[0:3, 3 + i] / 1e-7, attitude_rates(DESIGN.x1_trim, axis), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(Phi[3:6, 3:6], expm(H * A), rtol=1e-12)
    np.testing.assert_allclose(Phi[6:9, 0:3], H * np.eye(3), rtol=1e-12)
    np.testing.assert_allclose(Gamma[3:6], np.linalg.solve(A, (expm(H * A) - np.eye(3)) @ B), rtol=1e-9, atol=1e-12)


def test_no_other_gain_costs_less():
    # the cost of a linear feedback from random starts, summed over 60 s; perturbed gains must cost more
    p = lqi.params(DESIGN, H, {})[0]
    Phi, Gamma = lqi.sampled(DESIGN, H)
    Q = np.diag(np.radians(np.repeat([5.0, 10.0, 5.0], 3)) ** -2.0)
    R = np.eye(3) / 0.075**2  # half the range
    rng = np.random.default_rng(7)

    def cost(K):
        x = start.copy()
        total = 0.0
        for _ in range(4000):
            v2 = -K @ x
            total += np.sum(x * (Q @ x)) + np.sum(v2 * (R @ v2))
            x = Phi @ x + Gamma @ v2
        return total

    start = rng.normal(size=(9, 9))
    best = cost(p["K"])
    for _ in range(3):
        assert cost(p["K"] * (1.0 + 0.1 * rng.normal(size=(3, 9)))) > best
    assert np.abs(np.linalg.eigvals(Phi - Gamma @ p["K"])).max() < 1.0


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_it_holds_the_step_and_survives_the_faults(plant):
    _, records, outcome = flown("scenario1", plant, "lqi")
    assert outcome.completed
    assert np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1].max() < 0.02
    _, records, outcome = flown("scenario3", plant, "lqi")
    assert outcome.completed
    assert np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1].max() < 0.5


def test_its_integral_takes_out_a_gyro_bias():
    # the paper's outer loop without observer is off by bias / bandwidth = 0.6 deg; an integral of the attitude is not
    bias = ("sensors.gyro_bias_degps=[0.3, 0.3, 0.3]", "duration_s=60")
    _, records, _ = flown("scenario1", "analytic", "lqi", bias)
    assert np.degrees(np.abs(records["x1_c"] - records["x1"]))[-1].max() < 0.01


def test_the_integral_stands_still_while_a_command_is_beyond_its_limit():
    # given a bank angle that asks for more than the aileron has / then xi is not moved on any axis
    rows = empty_rows(10)
    records = as_records(rows)
    records["x1_c"][:5, 0] = 1.0
    records["x1_c"][5:, 1] = 0.01
    block = lqi.stage.block(lqi.params(DESIGN, H, {}))
    program = Program([block])
    program.run(rows, 0, 5)
    assert np.all(records["v2"][:5, 0] == 0.1)
    np.testing.assert_array_equal(block.state["xi"][0], 0.0)
    program.run(rows, 5, 10)
    np.testing.assert_allclose(block.state["xi"][0], [0.0, -5 * H * 0.01, 0.0])
