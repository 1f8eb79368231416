"""The laws of an aircraft with two axes against two-axis implementations of their own, and what they are made from."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.linalg import block_diag, expm, solve_continuous_lyapunov, solve_discrete_are

import paper
from uavftc.analysis.l1_condition import norms_of
from uavftc.control.inner import l1, mrac
from uavftc.control.whole import lqi, pid
from uavftc.core.axes import embedded
from uavftc.core.given import ControlDesign
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario
from wings import rotational

H = 0.005
D = SIGMA = 0.5
LEARNING = 0.05
BIAS = np.radians([0.2, -0.1, 0.3])
CASES = {"rudder": (True, True, False), "aileron": (False, True, True)}
REFERENCE = {"rudder": "{phi_deg: 4*sin(t), theta_deg: 3}", "aileron": "{theta_deg: 3, psi_deg: 4*sin(t)}"}


@pytest.fixture(scope="module", params=CASES)
def case(request, tmp_path_factory):
    """(name of the missing surface, axes, folder of a rotational model without it)."""
    folder = rotational(tmp_path_factory.mktemp("fewer") / "wing", request.param)
    return request.param, CASES[request.param], folder


def flown(case, controller, *overrides):
    missing, _, folder = case
    scenario = load_scenario(
        "scenario1", plant="analytic", aircraft=str(folder), controller=controller,
        overrides=[f"reference={REFERENCE[missing]}", "saturation=null", "duration_s=5", *overrides],
    )  # fmt: skip
    records, outcome = fly_to_memory(build_flight(scenario))
    assert outcome.completed
    return records


class TwoAxes:
    """NNDO, NDI, predictor and adaptive laws of two axes in matrices of two rows: nothing of a third is in them."""

    def __init__(self, own, filtered):
        self.i, self.j = own, [k for k in range(3) if k not in own]
        part = np.ix_(own, own)
        self.A_m, self.B, self.A_s = paper.A_M[part], paper.B_M[part], paper.A_S[part]
        P = solve_continuous_lyapunov(self.A_s.T, -np.eye(2))
        self.P_B, self.K = P @ self.B, np.linalg.solve(self.B, self.A_m)
        self.filtered = filtered
        self.zeta = None
        self.W_o, self.d1_hat = np.zeros((5, 2)), np.zeros(2)
        self.omega, self.W, self.eps, self.v_ad = np.ones(2), np.zeros((5, 2)), np.zeros(2), np.zeros(2)

    def basis(self, x1, x2):
        z = np.concatenate([x1[self.i], x2[self.i]])
        return np.exp(-((z - paper.CENTRES[:, None]) ** 2).sum(axis=1) / (2.0 * paper.WIDTH**2))

    def outer(self, x1_c, x1, x2, Phi):
        """Write the observer's estimate; return the commanded rates of the two axes."""
        g = paper.g1(x1)
        rate = (g @ x2)[self.i]
        first = self.zeta is None
        if first:
            self.zeta = x1[self.i]
        else:
            decay = np.exp(-SIGMA * H)
            drive = 0.5 * SIGMA * (self.angles + x1[self.i]) + 0.5 * (self.rate + rate) + self.d1_hat
            self.zeta = decay * self.zeta + (1.0 - decay) / SIGMA * drive
        self.W_o += H * LEARNING * np.outer(Phi, x1[self.i] - self.zeta)
        self.d1_hat = Phi @ self.W_o
        self.angles, self.rate = x1[self.i], rate
        # x1_I' = g_II v_I + g_IJ x2_J, with x2_J as measured
        asked = D * (x1_c - x1)[self.i] - self.d1_hat
        return np.linalg.solve(g[np.ix_(self.i, self.i)], asked - g[np.ix_(self.i, self.j)] @ x2[self.j])

    def inner(self, x2, v1, Phi):
        """Return the command of the two axes."""
        x2 = x2[self.i]
        if not hasattr(self, "x2_hat"):
            self.x2_hat, started = x2, False
        else:
            started = True
            eta = self.omega * self.v_ad + self.Phi @ self.W + self.eps
            gains = np.diag(1.0 + self.Phi @ self.Phi + self.v_ad**2)
            M = np.eye(2) - H * self.A_s + H * H * paper.GAMMA * self.B @ gains @ self.P_B.T
            tilde = np.linalg.solve(M, self.x2_hat - x2 + H * (self.A_m @ x2 + self.B @ eta))
            change = H * paper.GAMMA * (self.P_B.T @ tilde)
            self.omega = np.clip(self.omega - change * self.v_ad, 0.1, 2.0)
            self.eps = self.eps - change
            self.W = self.W - np.outer(self.Phi, change)
            self.x2_hat = x2 + tilde
        self.Phi = Phi
        target = -(Phi @ self.W + self.eps + self.K @ v1) / self.omega
        if not self.filtered:
            self.v_ad = target
        elif started:
            a = np.exp(-paper.BANDWIDTH * H * self.omega)
            self.v_ad = a * self.v_ad + (1.0 - a) * target
        return self.v_ad


def plant_step(x1, x2, u2, B):
    """One Runge-Kutta step of the rotational model with hale's inertia and A_l = A_m."""

    def rate(x):
        moment = -np.linalg.solve(paper.INERTIA, np.cross(x[3:], paper.INERTIA @ x[3:]))
        return np.concatenate([paper.g1(x[:3]) @ x[3:], moment + paper.A_M @ x[3:] + B @ u2])

    x = np.concatenate([x1, x2])
    a = rate(x)
    b = rate(x + 0.5 * H * a)
    c = rate(x + 0.5 * H * b)
    d = rate(x + H * c)
    x = x + H / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return x[:3], x[3:]


@pytest.mark.parametrize("controller", ["nndondi-l1", "nndondi-mrac"])
def test_the_loop_is_that_of_two_axes_alone(case, controller):
    # given an independent loop in which the third axis does not exist, closed over an independent plant that has it,
    # with a gyro bias that makes the observer work / then commands, rates and estimates are the same to rounding
    _, axes, _ = case
    records = flown(case, controller, f"sensors.gyro_bias_degps={np.degrees(BIAS).tolist()}")
    own = list(np.flatnonzero(axes))
    law, B = TwoAxes(own, controller.endswith("l1")), np.where(axes, paper.B_M, 0.0)
    x1, x2 = np.zeros(3), np.zeros(3)
    for record in records:
        np.testing.assert_allclose(record["x1"], x1, rtol=0, atol=1e-12)
        seen = x2 + BIAS
        Phi = law.basis(x1, seen)
        v1 = law.outer(record["x1_c"], x1, seen, Phi)
        v2 = law.inner(seen, v1, Phi)
        np.testing.assert_allclose(record["v1"][own], v1, rtol=0, atol=1e-12)
        np.testing.assert_allclose(record["v2"][own], v2, rtol=0, atol=1e-12)
        np.testing.assert_allclose(record["d1_hat"][own], law.d1_hat, rtol=0, atol=1e-12)
        u2 = np.zeros(3)
        u2[own] = v2
        x1, x2 = plant_step(x1, x2, u2, B)
    assert np.abs(records["d1_hat"][-1][own]).min() > 1e-4  # or the observer was not tested


@pytest.mark.parametrize("controller", ["nndondi-l1", "ndi-l1", "nndondi-mrac", "pid", "lqi"])
def test_nothing_is_commanded_or_estimated_about_the_missing_axis(case, controller):
    # exactly zero, and what is "commanded" as its rate is what the airframe does
    _, axes, _ = case
    (j,) = np.flatnonzero(np.logical_not(axes))
    records = flown(case, controller)
    for field in ("v2", "u2"):
        np.testing.assert_array_equal(records[field][:, j], 0.0)
    if controller not in ("pid", "lqi"):
        np.testing.assert_array_equal(records["d1_hat"][:, j], 0.0)
        np.testing.assert_array_equal(records["f_hat"][:, j], 0.0)
    if controller != "lqi":
        np.testing.assert_array_equal(records["v1"][:, j], records["x2_meas"][:, j])
    assert np.abs(records["x2"][:, j]).max() > 1e-4  # it does move


def given_of(axes):
    flight = paper.flight_of()
    B = np.where(axes, paper.B_M, 0.0)
    return flight._replace(design=flight.design._replace(B=B, axes=axes))


@pytest.mark.parametrize("axes", CASES.values(), ids=CASES)
@pytest.mark.parametrize("law", [l1, mrac])
def test_gains_are_those_of_the_part_of_the_matrices(axes, law):
    # P by scipy from A_s,II and Q_II, K = B_II^-1 A_m,II, and zeros wherever the missing axis is
    Q = np.array([[2.0, 0.3, 0.1], [0.3, 1.0, 0.2], [0.1, 0.2, 1.5]])
    config = law.Config(B_m=paper.B_M.tolist(), Q=Q.tolist(), K_0=(0.1 * np.ones((3, 3))).tolist())
    (block,) = law.blocks(config, given_of(axes))
    p = block.params[0]
    own = np.flatnonzero(axes)
    part = np.ix_(own, own)
    P = solve_continuous_lyapunov(paper.A_S[part].T, -Q[part])
    expected = {
        "A_m": paper.A_M[part],
        "B_m": paper.B_M[part],
        "A_s": paper.A_S[part],
        "P_B_m": P @ paper.B_M[part],
        "K": np.linalg.inv(paper.B_M[part]) @ paper.A_M[part],
        "K_0": 0.1 * np.ones((2, 2)),
    }
    for name, value in expected.items():
        np.testing.assert_allclose(p[name][part], value, rtol=1e-12, atol=1e-15, err_msg=name)
        np.testing.assert_array_equal(p[name], embedded(p[name][part], axes), err_msg=name)


@pytest.mark.parametrize("axes", CASES.values(), ids=CASES)
def test_norms_are_those_of_the_part_of_the_system(axes):
    # ||H|| and ||H C K|| of the two-axis system by summing its sampled impulse responses
    own = np.flatnonzero(axes)
    part = np.ix_(own, own)
    A_s, B, K = paper.A_S[part], paper.B_M[part], np.linalg.solve(paper.B_M[part], paper.A_M[part])
    found = norms_of(A_s, A_s=A_s, B_m=B, K=K, filter_bandwidth=paper.BANDWIDTH, omega=np.ones(2))
    t = np.arange(0.0, 40.0, 1e-3)
    eye, k = np.eye(2), paper.BANDWIDTH
    F = np.block([[A_s, B], [np.zeros((2, 2)), -k * eye]])  # x' = A_s x + B y, y' = -k y + k K r
    for norm, A, b in ((found.H, A_s, B), (found.HCK, F, np.vstack([np.zeros((2, 2)), k * K]))):
        step, state, areas = expm(1e-3 * A), b, []
        for _ in t:
            areas.append(np.abs(state[:2]))
            state = step @ state
        assert norm == pytest.approx(trapezoid(areas, t, axis=0).sum(axis=1).max(), rel=2e-4)


def test_a_part_of_a_stable_matrix_that_is_not_stable_is_refused():
    # all of A_m + K_1 is Hurwitz, what roll and pitch have of it is not: their predictor would diverge
    A_m = np.array([[0.5, 0.0, -4.0], [0.0, -3.0, 0.0], [4.0, 0.0, -5.0]]) - np.eye(3)
    config = l1.Config(A_m=A_m.tolist(), B_m=paper.B_M.tolist())
    assert l1.blocks(config, paper.flight_of())
    with pytest.raises(InputError, match="for roll and pitch, which is not Hurwitz") as error:
        l1.blocks(config, given_of((True, True, False)))
    assert error.value.where == "key controller.inner.A_m"


def test_a_control_matrix_that_lacks_an_axis_which_the_aircraft_has_is_refused():
    # a column of zeros is an aircraft without rudder; this one has one
    config = l1.Config().model_copy(update={"B_m": np.where([True, True, False], paper.B_M, 0.0).tolist()})
    assert l1.blocks(config, given_of((True, True, False)))
    with pytest.raises(InputError, match="condition number inf") as error:
        l1.blocks(config, paper.flight_of())
    assert error.value.where == "key controller.inner.B_m"


def design_of(axes, limit=1e3):
    limits = np.where(np.array(axes)[:, None], [-limit, limit], 0.0)
    B = np.where(axes, paper.B_M, 0.0)
    return ControlDesign(paper.A_M, B, limits, np.array([0.1, 0.2, 0.3]), "test", axes)


@pytest.mark.parametrize("axes", CASES.values(), ids=CASES)
def test_pid_answers_with_both_poles_at_the_bandwidth_on_the_axes_it_has(axes):
    # e' = -2 w e - z on each of the two, whatever the third rate does: its coupling is measured and taken out
    step = pid.create(design_of(axes), 0.001, {"attitude_bandwidth": 1e-12, "rate_bandwidth": 3.0})
    own = np.flatnonzero(axes)
    x2 = start = np.array([0.1, -0.2, 0.3])
    x1 = np.array([0.1, 0.2, 0.0])
    reference = None
    for k in range(500):
        # the attitude stands still, so that v1 is constant: that of e(0)
        v2, telemetry = step(0.001 * k, x1, x1, x2)
        reference = telemetry["v1"] if reference is None else reference
        x2 = x2 + 0.001 * (paper.A_M @ x2 + paper.B_M @ v2)
        held = np.flatnonzero(np.logical_not(axes))
        x2[held] = start[held]
    e = (1 - 1.5) * np.exp(-1.5) * (reference - start)[own]
    np.testing.assert_allclose((reference - x2)[own], e, rtol=0.02)
    np.testing.assert_array_equal(v2[held], 0.0)


@pytest.mark.parametrize("axes", CASES.values(), ids=CASES)
def test_lqi_is_the_regulator_of_two_axes(axes):
    # scipy's Riccati equation of the six states that are left, sampled from their own F and G
    design, own = design_of(axes, 0.1), np.flatnonzero(axes)
    part = np.ix_(own, own)
    F, G = np.zeros((6, 6)), np.zeros((6, 2))
    F[0:2, 2:4], F[2:4, 2:4], F[4:6, 0:2] = paper.g1(design.x1_trim)[part], paper.A_M[part], np.eye(2)
    G[2:4] = paper.B_M[part]
    both = expm(H * np.block([[F, G], [np.zeros((2, 8))]]))
    Phi, Gamma = both[:6, :6], both[:6, 6:]
    Q = np.diag(np.radians(np.repeat([5.0, 10.0, 5.0], 2)) ** -2.0)
    R = np.eye(2) / 0.1**2
    S = solve_discrete_are(Phi, Gamma, Q, R)
    expected = np.linalg.solve(R + Gamma.T @ S @ Gamma, Gamma.T @ S @ Phi)
    K = lqi.params(design, H, {})[0]["K"]
    where = block_diag(*[np.diag(np.array(axes, float))] * 3).diagonal() > 0.0
    np.testing.assert_allclose(K[own][:, where], expected, rtol=1e-9)
    assert np.count_nonzero(K) == expected.size


@pytest.mark.parametrize("controller", ["nndondi-l1", "pid"])
def test_a_heading_that_turns_round_does_not_reach_the_other_axes(tmp_path, controller):
    # no part of the law depends on a heading that nobody holds: started anywhere, the flight is the same but for it
    folder = rotational(tmp_path / "wing", "rudder")
    scenario = load_scenario(
        "scenario1", plant="analytic", aircraft=str(folder), controller=controller,
        overrides=["reference={phi_deg: 4, theta_deg: 3}", "duration_s=2"],
    )  # fmt: skip
    flights = []
    for psi in (0.0, 2.5):
        flight = build_flight(scenario)
        flight.plant._state["x1"][0, 2] = psi
        flights.append(fly_to_memory(flight)[0])
    for field in ("v2", "x2"):
        np.testing.assert_array_equal(flights[0][field], flights[1][field])
