"""The MRAC comparator: the L1 law without its filter."""

from __future__ import annotations

import numpy as np

import paper
from uavftc.control.inner import l1, mrac
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario


def samples(n):
    """Measurements and commands of a smooth flight; the command is zero in the first sample."""
    t = np.arange(n) * 0.005
    x2 = np.radians([3.0, 2.0, 4.0]) * np.sin(np.outer(t, [2.0, 3.0, 1.0]))
    v1 = np.radians([2.0, 4.0, 1.0]) * np.sin(np.outer(t, [1.0, 0.7, 1.6]))
    x1 = np.radians([5.0, 5.0, 5.0]) * (1.0 - np.exp(-t))[:, None]
    return x1, x2, v1


def flown(stage, n=200, **changes):
    law = paper.Law(stage.stage, paper.inner_params(stage.PARAMS, omega_min=0.1, omega_max=2.0, **changes))
    x1, x2, v1 = samples(n)
    return np.array([law(x1_meas=x1[k], x2_meas=x2[k], v1=v1[k])["v2"].copy() for k in range(n)]), law


def test_command_is_the_formula():
    # v_ad = -(W' Phi + eps + K r)/omega, v2 = -K_0' x2 + v_ad, from given estimates
    rng = np.random.default_rng(10)
    x1, x2, r, eps = (rng.normal(scale=0.1, size=3) for _ in range(4))
    W, K_0, omega = rng.normal(scale=0.1, size=(5, 3)), rng.normal(size=(3, 3)), np.array([0.4, 1.0, 1.6])
    law = paper.Law(mrac.stage, paper.inner_params(mrac.PARAMS, Gamma=0.0, K_0=K_0))
    s = law.state
    s["started"], s["x2_hat"], s["omega_hat"], s["eps_hat"], s["W_hat"] = 1.0, x2, omega, eps, W
    law(x1_meas=x1, x2_meas=x2, v1=r)
    f = W.T @ paper.phi(x1, x2) + eps
    v_ad = -(f + np.linalg.inv(paper.B_M) @ paper.A_M @ r) / omega
    np.testing.assert_allclose(law.row["v2"], v_ad - K_0.T @ x2, rtol=1e-12)
    np.testing.assert_allclose(s["v_ad"], v_ad, rtol=1e-12)
    np.testing.assert_allclose(law.row["f_hat"], paper.B_M @ f, rtol=1e-12)


def test_is_the_limit_of_L1_for_an_infinite_filter_bandwidth():
    # a = exp(-k h omega_hat) -> 0 at a fixed rate: the two laws become one, bit for bit once a underflows
    reference, _ = flown(mrac)
    limit, _ = flown(l1, filter_bandwidth=1e9)
    np.testing.assert_array_equal(limit, reference)
    near, _ = flown(l1, filter_bandwidth=60.0)
    assert np.abs(near - reference).max() > 1e-3  # at the paper's bandwidth they are two laws


def test_difference_to_L1_falls_as_the_filter_opens():
    # the limit is approached: with a = e^-k h the difference falls with every step of the bandwidth;
    # on so few samples that MRAC, fed rates that do not answer it, has not yet blown the difference up
    n = 40
    reference, _ = flown(mrac, n)
    differences = [np.abs(flown(l1, n, filter_bandwidth=k)[0] - reference).max() for k in (60.0, 600.0, 2400.0, 6000.0)]
    assert (np.diff(differences) < 0.0).all()
    assert differences[0] > 0.1
    assert differences[-1] < 1e-11


def test_tracks_as_well_as_L1_on_a_perfect_loop_and_works_the_surfaces_harder_on_a_late_one():
    # what sets the two apart is not accuracy but robustness: 10 ms of delay make MRAC chatter
    metrics = {}
    for kind in ("l1", "mrac"):
        for delay in (0.0, 0.01):
            scenario = Scenario.model_validate(
                {
                    "name": "step", "duration_s": 20, "plant": "analytic",
                    "reference": {"phi_deg": 5, "theta_deg": 5, "psi_deg": 5},
                    "controller": {"inner": {"kind": kind}, "delay_s": delay},
                    "saturation": {"min_rad": -0.05, "max_rad": 0.1},
                }
            )  # fmt: skip
            records, outcome = fly_to_memory(build_flight(scenario))
            assert outcome.completed
            iae = np.abs(records["x1_c"] - records["x1"]).sum(axis=0) / 200.0
            metrics[kind, delay] = iae, np.abs(np.diff(records["v2"], axis=0)).sum(axis=0)
    np.testing.assert_allclose(metrics["mrac", 0.0][0], metrics["l1", 0.0][0], rtol=0.03)
    assert metrics["l1", 0.01][1].max() < 0.2
    assert metrics["mrac", 0.01][1].max() > 50.0
