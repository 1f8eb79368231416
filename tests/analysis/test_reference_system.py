"""The reference system (45): against the continuous adaptive law, and against sampled flights of the analytic plant."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from control.paper import A_M, A_S, B_M, BANDWIDTH, GAMMA, INERTIA, P, g1
from flying import flown
from uavftc.analysis.l1_condition import Given, norms_of, theorem_3
from uavftc.analysis.reference_system import (
    Disturbance,
    assumptions_not_met,
    differences,
    jumps,
    lumped_disturbance,
    replay,
    simulate,
)
from uavftc.control.inner import l1
from uavftc.core.signals import as_records, empty_rows

K = np.linalg.solve(B_M, A_M)
K_2 = np.linalg.solve(B_M, A_S)
PRINTED_GAIN = ("controller.inner.reference_gain=printed",)


def inner_block(flight):
    return l1.blocks(flight.scenario.controller.inner, flight.given)[0]


def distances(scenario, A, gain, overrides=()):
    """Return (largest |x_ref - x2|, largest |v_ref - v_ad|, largest |v1|, largest |x2_tilde|) of an analytic flight."""
    flight, records, _ = flown(scenario, "analytic", None, overrides)
    law = replay(inner_block(flight), records)
    eta = lumped_disturbance(records, law.v_ad, inertia=INERTIA, A_l=A_M, B_l=B_M, A_m=A_M, B_m=B_M)
    reference = simulate(records, eta, A=A, B_m=B_M, K=gain, filter_bandwidth=BANDWIDTH, v_start=law.v_ad[0])
    found = differences(records, law.v_ad, reference)
    return (*(float(np.max(x)) for x in found), np.max(np.abs(records["v1"])), np.max(np.abs(law.x2_tilde)))


def rate_command(x1):
    """Return r of eq. (9) for a step of 5 deg on every axis, rad/s: plain numpy."""
    return np.linalg.solve(g1(x1), 0.5 * (np.radians(5.0) - x1))


def continuous_share(A, gain, flown_gain):
    """Return max |x_ref - x2| / max |r| of the ideal continuous loop in scenario 1, by an independent solver.

    Plant and law have no uncertainty but the gyroscopic terms, which both compensate; what parts them is A and gain.
    """

    def rhs(_, y):
        x1, x2, v, x_ref, v_ref = y.reshape(5, 3)
        r = rate_command(x1)
        eta = np.linalg.solve(B_M, np.linalg.solve(INERTIA, -np.cross(x2, INERTIA @ x2)))
        return np.concatenate(
            [
                g1(x1) @ x2,
                A_M @ x2 + B_M @ (v + eta),
                -BANDWIDTH * (v + eta + flown_gain @ r),
                A @ x_ref + B_M @ (v_ref + eta),
                -BANDWIDTH * (v_ref + eta + gain @ r),
            ]
        )

    solved = solve_ivp(rhs, (0.0, 20.0), np.zeros(15), method="Radau", rtol=1e-7, atol=1e-10)
    x1, x2, _, x_ref, _ = solved.y.reshape(5, 3, -1)
    return np.max(np.abs(x_ref - x2)) / max(np.max(np.abs(rate_command(x))) for x in x1.T)


def sampled_share(h):
    """Return the same of a loop without uncertainty whose law is sampled every h, s, and held, A = A_m, K in both."""
    ahead = expm(h * np.block([[A_M, B_M], [np.zeros((3, 6))]]))
    decay = np.exp(-BANDWIDTH * h)
    x1, x2, v = np.zeros((3, 3))
    rates, commands = [], []
    for k in range(round(5.0 / h)):
        r = rate_command(x1)
        v = v if k == 0 else decay * v - (1.0 - decay) * (K @ r)
        rates.append(x2)
        commands.append(r)
        x2_next = ahead[:3, :3] @ x2 + ahead[:3, 3:] @ v
        middle = x1 + 0.5 * h * g1(x1) @ x2
        x1, x2 = x1 + h * g1(middle) @ (0.5 * (x2 + x2_next)), x2_next
    # The reference system under the same commands, linear between the samples.
    eye, zero = np.eye(3), np.zeros((3, 3))
    system = np.block(
        [
            [A_M, B_M, zero, zero],
            [zero, -BANDWIDTH * eye, -BANDWIDTH * K, zero],
            [zero, zero, zero, eye],
            [np.zeros((3, 12))],
        ]
    )
    ahead = expm(h * system)
    y, largest = np.zeros(6), 0.0
    for k in range(len(rates) - 1):
        y = (ahead @ np.concatenate([y, commands[k], (commands[k + 1] - commands[k]) / h]))[:6]
        largest = max(largest, np.max(np.abs(y[:3] - rates[k + 1])))
    return largest / np.max(np.abs(commands))


class TestReplay:
    @pytest.mark.parametrize(
        ("scenario", "plant", "overrides"),
        [
            ("scenario3", "analytic", ()),
            ("scenario3", "jsbsim", ()),
            ("scenario1", "analytic", ("sensors.gyro_bias_degps=[0.3, 0.2, 0.1]", "controller.delay_s=0.007")),
            ("scenario1", "analytic", ("controller.inner.K_0=[[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]",)),
        ],
    )
    def test_the_law_gives_the_recorded_commands_to_the_bit(self, scenario, plant, overrides):
        # One implementation of the law: the same inputs give the same outputs, so its state is that of the flight.
        flight, records, _ = flown(scenario, plant, None, overrides)
        law = replay(inner_block(flight), records)  # it raises where v2 differs in a bit
        K_0 = np.array(flight.scenario.controller.inner.K_0)
        np.testing.assert_allclose(law.v_ad - records["x2_meas"] @ K_0, records["v2"], atol=1e-15)
        assert np.all(law.x2_tilde[0] == 0.0)
        assert 1e-9 < np.max(np.abs(law.x2_tilde)) < 1e-4

    def test_another_controllers_flight_is_refused(self):
        flight, _, _ = flown("scenario1", "analytic")
        _, records, _ = flown("scenario1", "analytic", None, PRINTED_GAIN)
        with pytest.raises(ValueError, match="another controller"):
            replay(inner_block(flight), records)


def test_eta_closes_the_equations_of_the_flight():
    # x2' = A_m x2 + B_m (omega v_ad + eta), from the recorded samples: the plant's own derivative, by differences.
    flight, records, _ = flown("scenario3", "analytic")
    law = replay(inner_block(flight), records)
    eta = lumped_disturbance(records, law.v_ad, inertia=INERTIA, A_l=A_M, B_l=B_M, A_m=A_M, B_m=B_M)
    h = 0.005
    x2, omega = records["x2"], records["effectiveness"]
    middle = 0.5 * (x2[1:] + x2[:-1])
    held = omega[:-1] * law.v_ad[:-1] + eta.held[:-1] + 0.5 * (eta.smooth[1:] + eta.smooth[:-1])
    found = np.diff(x2, axis=0) / h
    # the midpoint rule errs by h^2/12 of the third derivative: 60^2 1/s^2 of the filter times 0.4 rad/s^2
    np.testing.assert_allclose(found, middle @ A_M.T + held @ B_M.T, atol=2e-3)
    assert np.max(np.abs(found)) > 0.1


def test_the_simulation_is_exact_for_linear_inputs():
    # Against an integration a hundred times finer, with commands and disturbance that are linear over each sample.
    n, h = 41, 0.005
    records = as_records(empty_rows(n))
    t = records["t"] = np.arange(n) * h
    records["v1"] = np.outer(t, [0.3, -0.2, 0.1]) + 0.02
    records["effectiveness"] = [0.6, 1.0, 0.8]
    records["x2"][0] = [0.01, -0.02, 0.03]
    smooth = np.outer(t, [0.1, 0.2, -0.1])
    held = np.repeat([[0.02, -0.01, 0.0]], n, axis=0)
    found = simulate(
        records, Disturbance(smooth, held), A=A_M, B_m=B_M, K=K, filter_bandwidth=BANDWIDTH, v_start=np.full(3, 0.004)
    )
    omega, fine = np.array([0.6, 1.0, 0.8]), 500
    x, v = np.array([0.01, -0.02, 0.03]), np.full(3, 0.004)

    def derivative(time, x, v):
        eta = time * np.array([0.1, 0.2, -0.1]) + [0.02, -0.01, 0.0]
        r = time * np.array([0.3, -0.2, 0.1]) + 0.02
        return A_M @ x + B_M @ (omega * v + eta), -BANDWIDTH * (omega * v + eta + K @ r)

    d = h / fine
    for i in range((n - 1) * fine):
        a = derivative(i * d, x, v)
        b = derivative((i + 0.5) * d, x + 0.5 * d * a[0], v + 0.5 * d * a[1])
        x, v = x + d * b[0], v + d * b[1]
    np.testing.assert_allclose(found.x_ref[-1], x, atol=1e-8)
    np.testing.assert_allclose(found.v_ref[-1], v, atol=1e-8)


def test_the_continuous_law_stays_within_gamma_of_the_system_with_A_m_and_not_with_A_s():
    # Given the continuous laws (30) to (32) with eps_hat alone, a smooth eta(t) and r(t), integrated exactly as one
    # linear system: [x2, x2_tilde, eps_hat, v_ad, x_ref, v_ref, x_ref printed] driven by [sin t, cos t, 1].
    # Then |x_ref - x2| <= ||H_m C H_s^-1|| max|x2_tilde|, and likewise v; with the printed A_s, which the plant lacks,
    # the difference is more than a hundred times the printed gamma_1.
    zero, k = np.zeros((3, 3)), BANDWIDTH * np.eye(3)
    F = np.block(
        [
            [A_M, zero, zero, B_M, zero, zero, zero],
            [zero, A_S, B_M, zero, zero, zero, zero],
            [zero, -GAMMA * (P @ B_M).T, zero, zero, zero, zero, zero],
            [zero, zero, -k, -k, zero, zero, zero],
            [zero, zero, zero, zero, A_M, B_M, zero],
            [zero, zero, zero, zero, zero, -k, zero],
            [zero, zero, zero, zero, zero, B_M, A_S],
        ]
    )
    eta = np.array([[0.02, 0.0, 0.01], [0.0, 0.03, -0.02], [-0.01, 0.01, 0.02]])
    r = np.array([[0.0, 0.02, 0.04], [0.03, 0.0, -0.03], [0.0, -0.02, 0.05]])
    push = -k @ (eta + K @ r)
    drive = np.vstack([B_M @ eta, -B_M @ eta, np.zeros((3, 3)), -k @ K @ r, B_M @ eta, push, B_M @ eta])
    turn = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    E = expm(1e-4 * np.block([[F, drive], [np.zeros((3, 21)), turn]]))
    state = np.concatenate([np.zeros(21), [0.0, 1.0, 1.0]])
    path = np.empty((40_000, 24))
    for i in range(len(path)):
        path[i] = state = E @ state
    x2, x2_tilde, _, v_ad, x_ref, v_ref, x_printed = (path[:, 3 * i : 3 * i + 3] for i in range(7))
    gamma_0 = 1.01 * float(np.max(np.abs(x2_tilde)))  # between the samples it may be a little larger
    given = Given(lipschitz=0.0, gamma_0=gamma_0)
    design = {"A_s": A_S, "B_m": B_M, "K": K, "filter_bandwidth": BANDWIDTH, "omega": np.ones(3), "accuracy": 1e-4}
    bound = theorem_3(norms_of(A_M, **design), given)
    seen = np.max(np.abs(x_ref - x2)), np.max(np.abs(v_ref - v_ad))
    assert 0.05 * bound.gamma_1 < seen[0] <= bound.gamma_1
    assert 0.05 * bound.gamma_2 < seen[1] <= bound.gamma_2
    printed = theorem_3(norms_of(A_S, **design), given)
    assert np.max(np.abs(x_printed - x2)) > 100.0 * printed.gamma_1


class TestBesideFlights:
    def test_with_the_plants_matrix_the_flight_is_close(self):
        # 200 Hz: what is left is the sampling, two per cent of the commanded rate. The continuous loop leaves nothing,
        # and one that is sampled without any adaptation nearly as much as the flight.
        x2, v_ad, r, x2_tilde = distances("scenario1", A_M, K)
        assert continuous_share(A_M, K, K) < 1e-9
        assert x2 / r == pytest.approx(sampled_share(0.005), rel=0.15)
        assert v_ad < 1e-3  # rad; the surfaces move by hundredths
        assert x2_tilde < 1e-6  # rad/s: Gamma = 1e5

    def test_what_is_left_is_the_sampling(self):
        # A first-order effect: five times the rate, a fifth of the difference.
        slow, fast = (distances("scenario1", A_M, K, over) for over in ((), ("controller.rate_hz=1000",)))
        assert fast[0] / slow[0] == pytest.approx(0.2, abs=0.02)
        assert fast[1] / slow[1] == pytest.approx(0.2, abs=0.02)

    def test_with_the_printed_matrix_a_fixed_share_of_the_command_is_left(self):
        # With the default gain, with eq. (45) to the letter (K_2) next to the default gain, and with K_2 in both; no
        # sample rate makes it smaller.
        r = distances("scenario1", A_S, K)[2]
        left = continuous_share(A_S, K, K)
        assert left > 0.5
        assert distances("scenario1", A_S, K)[0] / r == pytest.approx(left, abs=0.005)
        assert distances("scenario1", A_S, K_2)[0] / r == pytest.approx(continuous_share(A_S, K_2, K), abs=0.005)
        printed = distances("scenario1", A_S, K_2, PRINTED_GAIN)[0]
        assert printed / r == pytest.approx(continuous_share(A_S, K_2, K_2), abs=0.005)
        fast = distances("scenario1", A_S, K, ("controller.rate_hz=1000",))
        assert fast[0] / fast[2] == pytest.approx(left, abs=0.005)

    def test_faults_and_disturbances_do_not_part_them(self):
        # eta takes everything that the plant did beyond the model, so the sampled loop stays as close under faults.
        x2, _, r, _ = distances("scenario3", A_M, K)
        assert x2 / r < 0.05


class TestAssumptions:
    def limits(self, flight):
        return flight.scenario.limits_rad()

    def test_the_saturated_step_alone_meets_them(self):
        # Scenario 1 on the analytic plant: no command reaches a limit.
        flight, records, _ = flown("scenario1", "analytic")
        assert assumptions_not_met(records, self.limits(flight)) == []

    @pytest.mark.parametrize(
        ("scenario", "overrides", "words"),
        [
            ("scenario2", (), ["disturbance d2 is discontinuous (first at t = 10 s)"]),
            (
                "scenario3",
                (),
                [
                    "leaves (0, 1]: from 0.3 to 2.399",
                    "changes during",
                    "bias v2a is discontinuous (first at t = 8 s)",
                    "d2",
                ],
            ),
            ("scenario1", ("saturation.max_rad=0.01",), ["saturation is active"]),
            ("scenario1", ("sensors.gyro_bias_degps=[0.1, 0, 0]",), ["measured rates"]),
            ("scenario1", ("controller.delay_s=0.005",), ["at once"]),
        ],
    )
    def test_what_is_not_met_is_named(self, scenario, overrides, words):
        flight, records, _ = flown(scenario, "analytic", None, overrides)
        found = assumptions_not_met(records, self.limits(flight))
        assert len(found) == len(words)
        for sentence, word in zip(found, words, strict=True):
            assert word in sentence

    def test_jumps_are_distinguished_from_smooth_signals(self):
        # 200 Hz: sines, ramps and kinks have none; a step, a window and a pulse of one sample have.
        t = np.arange(0.0, 5.0, 0.005)
        smooth = [np.sin(3.0 * t), np.abs(np.sin(2.0 * t)), t**2, np.maximum(t - 2.0, 0.0), np.exp(-20.0 * t), 0.0 * t]
        assert len(jumps(np.column_stack(smooth))) == 0
        step = np.where(t >= 1.0, 0.3 + np.sin(t), np.sin(t))
        assert list(jumps(step[:, None])) == [200]
        window = np.where((t >= 1.0) & (t < 2.0), np.cos(t), 0.0)
        assert list(jumps(window[:, None])) == [200, 400]
        pulse = np.zeros_like(t)
        pulse[300] = 1e-3
        assert list(jumps(pulse[:, None])) == [300, 301]
