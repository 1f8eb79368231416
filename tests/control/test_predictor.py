"""The implicit step of predictor and adaptive laws, eqs. (30) and (31)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import paper
from uavftc.control.inner import l1, mrac

N = 5
ESTIMATES = ("omega_hat", "eps_hat", "W_hat")
RATES = [50, 100, 200, 1000]


def backward_euler(h, K_1=paper.K_1, gamma=paper.GAMMA, *, x2_hat, omega, eps, W, v, Phi, x2):
    """The step as one linear system in all 24 unknowns: x2_hat, omega_hat, eps_hat, W_hat after the step."""
    C = paper.B_M.T @ paper.P  # (x2_tilde' P B_m)' = C x2_tilde
    system, right = np.eye(24), np.concatenate([x2_hat, omega, eps, W.ravel()])
    x, o, e = slice(0, 3), slice(3, 6), slice(6, 9)
    system[x, x] -= h * (paper.A_M + K_1)
    right[x] -= h * K_1 @ x2
    system[x, o] = -h * paper.B_M @ np.diag(v)
    system[x, e] = -h * paper.B_M
    system[o, x] = h * gamma * np.diag(v) @ C
    right[o] += h * gamma * v * (C @ x2)
    system[e, x] = h * gamma * C
    right[e] += h * gamma * C @ x2
    for n in range(N):
        w = slice(9 + 3 * n, 12 + 3 * n)
        system[x, w] = -h * paper.B_M * Phi[n]
        system[w, x] = h * gamma * Phi[n] * C
        right[w] += h * gamma * Phi[n] * (C @ x2)
    y = np.linalg.solve(system, right)
    return y[x], y[o], y[e], y[9:].reshape(N, 3)


def stepped(h, stage=l1, *, x2_hat, omega, eps, W, v, Phi, x2, **changes):
    """The same step by the law: its state before is given, x2 is measured after."""
    law = paper.Law(stage.stage, paper.inner_params(stage.PARAMS, h=h, **changes))
    s = law.state
    s["started"], s["x2_hat"], s["omega_hat"], s["eps_hat"], s["W_hat"] = 1.0, x2_hat, omega, eps, W
    s["v_ad"], s["Phi"] = v, Phi
    law(x2_meas=x2)
    return s


def random_state(rng):
    return {
        "x2_hat": rng.normal(scale=0.1, size=3),
        "omega": rng.uniform(0.1, 2.0, size=3),
        "eps": rng.normal(scale=0.05, size=3),
        "W": rng.normal(scale=0.05, size=(N, 3)),
        "v": rng.normal(scale=0.3, size=3),
        "Phi": rng.uniform(0.0, 1.0, size=N),
        "x2": rng.normal(scale=0.1, size=3),
    }


@pytest.mark.parametrize("stage", [l1, mrac])
@pytest.mark.parametrize("h", [0.02, 0.005, 0.0002])
def test_step_solves_the_whole_backward_euler_system(stage, h):
    # the law eliminates the estimates and solves 3x3; all 24 equations solved at once must give the same
    rng = np.random.default_rng(4)
    for _ in range(50):
        state = random_state(rng)
        s = stepped(h, **state, stage=stage)
        expected = backward_euler(h, **state)
        # x2_tilde is small compared with the right side it is computed from: compare on the scale of the state
        np.testing.assert_allclose(s["x2_hat"], expected[0], rtol=0, atol=1e-13)
        for name, value in zip(ESTIMATES, expected[1:], strict=True):
            np.testing.assert_allclose(s[name], value, rtol=0, atol=1e-11)
        np.testing.assert_allclose(s["x2_tilde"], expected[0] - state["x2"], rtol=0, atol=1e-13)


def test_step_takes_any_feedback_of_the_prediction_error():
    # K_1 is not always the identity: it enters through A_s only
    rng = np.random.default_rng(5)
    K_1 = np.array([[0.5, 0.2, 0.0], [-0.1, 1.5, 0.3], [0.0, 0.1, 0.8]])
    state = random_state(rng)
    s = stepped(0.005, **state, A_s=paper.A_M + K_1)
    expected = backward_euler(0.005, K_1, **state)
    np.testing.assert_allclose(s["x2_hat"], expected[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(s["eps_hat"], expected[2], rtol=0, atol=1e-10)


def test_perfect_prediction_leaves_the_estimates_alone():
    # a prediction that comes true carries no information: nothing adapts
    rng = np.random.default_rng(6)
    h, state = 0.005, random_state(rng)
    eta = state["omega"] * state["v"] + state["W"].T @ state["Phi"] + state["eps"]
    # backward Euler of the plant with the same parameters: x2 = x2_hat + h (A_m x2 + B_m eta)
    state["x2"] = np.linalg.solve(np.eye(3) - h * paper.A_M, state["x2_hat"] + h * paper.B_M @ eta)
    s = stepped(h, **state)
    np.testing.assert_allclose(s["x2_tilde"], 0.0, atol=1e-15)
    np.testing.assert_allclose(s["omega_hat"], state["omega"], atol=1e-11)
    np.testing.assert_allclose(s["eps_hat"], state["eps"], atol=1e-11)


HUGE = st.floats(-1e30, 1e30)  # beyond about 1e50 the 3x3 determinant itself overflows, which gives nan


@settings(deadline=None)  # the first example compiles
@given(
    x2=st.lists(HUGE, min_size=3, max_size=3),
    v1=st.lists(HUGE, min_size=3, max_size=3),
    x1=st.lists(HUGE, min_size=3, max_size=3),
    kind=st.sampled_from([l1, mrac]),
    steps=st.integers(1, 5),
)
def test_projection_keeps_every_estimate_inside_its_bounds(x2, v1, x1, kind, steps):
    # whatever is measured and commanded: the bounds are what the proofs and the filter rest on (omega_hat > 0)
    bounds = {"omega_min": 0.1, "omega_max": 2.0, "W_max": 0.7, "eps_max": 0.3}
    law = LAWS.setdefault(kind, paper.Law(kind.stage, paper.inner_params(kind.PARAMS, **bounds)))
    for name in law.state.dtype.names:
        law.state[name] = 0.0
    for k in range(steps + 1):
        law(x2_meas=np.array(x2) * (-1.0) ** k, v1=v1, x1_meas=x1)
        s = law.state
        assert (s["omega_hat"] >= 0.1).all()
        assert (s["omega_hat"] <= 2.0).all()
        assert (np.abs(s["eps_hat"]) <= 0.3).all()
        assert (np.abs(s["W_hat"]) <= 0.7).all()


LAWS: dict[object, paper.Law] = {}


def test_projection_is_to_the_nearest_admissible_point_and_acts_after_the_solve():
    # a bound on one estimate must not change the others: the step of the notes clips after the solve
    rng = np.random.default_rng(7)
    state = random_state(rng)
    free, bound = stepped(0.005, **state), stepped(0.005, **state, eps_max=1e-3, W_max=2e-3, omega_min=0.5)
    np.testing.assert_array_equal(bound["eps_hat"], np.clip(free["eps_hat"], -1e-3, 1e-3))
    np.testing.assert_array_equal(bound["W_hat"], np.clip(free["W_hat"], -2e-3, 2e-3))
    np.testing.assert_array_equal(bound["omega_hat"], np.clip(free["omega_hat"], 0.5, None))
    np.testing.assert_array_equal(bound["x2_hat"], free["x2_hat"])
    assert (bound["eps_hat"] != free["eps_hat"]).any()


def test_nan_measurement_is_not_projected_away():
    # a lost sensor must reach the watch as nan, not become an estimate at its bound
    state = random_state(np.random.default_rng(8)) | {"x2": np.array([np.nan, 0.0, 0.0])}
    s = stepped(0.005, **state, eps_max=1.0, W_max=1.0, omega_min=0.1, omega_max=2.0)
    assert np.isnan(s["eps_hat"]).all()


def generator(v, Phi):
    """Matrix F of the continuous error dynamics (x2_tilde, omega_hat, eps_hat, W_hat) with v and Phi frozen."""
    C = paper.B_M.T @ paper.P
    regressors = [np.diag(v), np.eye(3), *(phi * np.eye(3) for phi in Phi)]
    F = np.zeros((24, 24))
    F[:3, :3] = paper.A_S
    for i, R in enumerate(regressors):
        part = slice(3 + 3 * i, 6 + 3 * i)
        F[:3, part] = paper.B_M @ R
        F[part, :3] = -paper.GAMMA * R @ C
    return F


@pytest.mark.parametrize("rate", RATES)
def test_step_of_the_law_is_stable_where_an_explicit_one_is_not(rate):
    # the adaptation oscillates at krad/s: (I - hF)^-1 never grows, I + hF grows at every rate a flight computer has
    h = 1.0 / rate
    v, Phi = np.array([0.05, -0.03, 0.02]), paper.phi(np.zeros(3), np.zeros(3))
    F = generator(v, Phi)
    # with x2 = 0 and no bound active the law's step is linear: its matrix, column by column
    law = np.empty((24, 24))
    for i, column in enumerate(np.eye(24)):
        x2_hat, omega, eps, W = column[:3], column[3:6], column[6:9], column[9:].reshape(N, 3)
        s = stepped(h, x2_hat=x2_hat, omega=omega, eps=eps, W=W, v=v, Phi=Phi, x2=np.zeros(3))
        law[:, i] = np.concatenate([s["x2_hat"], s["omega_hat"], s["eps_hat"], s["W_hat"].ravel()])
    np.testing.assert_allclose(law, np.linalg.inv(np.eye(24) - h * F), atol=1e-12)
    radius = np.abs(np.linalg.eigvals(law)).max()
    assert radius < 1.0 + 1e-12  # the directions that v and Phi do not excite stay where they are
    assert np.abs(np.linalg.eigvals(np.eye(24) + h * F)).max() > 1.5


def test_stiffness_of_the_adaptation_is_kilo_radians_a_second():
    # the reason for the implicit step: Gamma = 1e5 makes oscillations of 1.6 to 4.4 krad/s
    values = np.linalg.eigvals(generator(np.zeros(3), paper.phi(np.zeros(3), np.zeros(3))))
    fast = np.abs(values[np.abs(values.imag) > 1.0])
    assert len(fast) == 6
    np.testing.assert_allclose([fast.min(), fast.max()], [1.6e3, 4.4e3], rtol=0.03)
