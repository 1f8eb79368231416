"""`uavftc design` as a user or another tool meets it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from control.paper import A_M, A_S, B_M, K_2_PRINTED, P_PRINTED
from uavftc.cli.app import umbrella
from uavftc.resources import scenario_dir


def run(folder: Path, *arguments: str) -> Result:
    """In this process, which is quicker; one test below has a process of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return CliRunner().invoke(umbrella, ["design", *arguments])


def refuse_constant(name: str) -> None:
    raise AssertionError(f"{name} is not JSON")


def as_json(text: str) -> dict:
    return json.loads(text, parse_constant=refuse_constant)


def document(folder: Path, *arguments: str) -> dict:
    done = run(folder, "hale", "--json", *arguments)
    assert done.exit_code == 0, done.output
    return as_json(done.stdout)


@pytest.fixture(scope="module")
def hale(tmp_path_factory):
    return document(tmp_path_factory.mktemp("design"))


def test_the_document_holds_the_contract(hale):
    assert {
        "trim", "A", "B", "A_m", "A_s", "K", "K_0", "P", "l1_norm_H", "l1_norm_G", "l1_norm_HCK", "l1_norm_H_A_m",
        "l1_norm_G_A_m", "l1_norm_HCK_A_m", "condition_holds", "sigma_0", "sigma_r", "r_max", "delta_5", "lipschitz",
        "lipschitz_max", "gamma_1", "gamma_2", "reason",
    } <= set(hale)  # fmt: skip


def test_the_matrices_are_the_papers(hale):
    # P and K_2 to the four decimals of section 4; K = B_m^-1 A_m; eigenvalues from the matrices as printed.
    np.testing.assert_allclose(hale["A_m"], A_M)
    np.testing.assert_allclose(hale["A_s"], A_S)
    np.testing.assert_allclose(hale["P"], P_PRINTED, atol=5.1e-5)
    np.testing.assert_allclose(hale["K_2"], K_2_PRINTED, atol=5.1e-5)
    np.testing.assert_allclose(B_M @ np.array(hale["K"]), A_M, atol=1e-12)
    assert hale["lyapunov_residual"] < 1e-12
    np.testing.assert_array_equal(hale["K_0"], np.zeros((3, 3)))
    for name, A in (("eigenvalues_A_m", A_M), ("eigenvalues_A_s", A_S)):
        found = np.array([complex(*pair) for pair in hale[name]])
        np.testing.assert_allclose(np.sort(found.real), np.sort(np.linalg.eigvals(A).real), rtol=1e-9)


def test_trim_and_linear_pair_are_those_of_the_aircraft(hale):
    # aircraft/hale/README.md: level at alpha = 0, throttle 0.29099; damping from its rate derivatives, q S b^2/(2 V)
    # and the inertia of the paper. The propellers add a little to the yawing row.
    trim = hale["trim"]
    assert trim["alpha_rad"] == pytest.approx(0.0, abs=1e-6)
    assert trim["theta_rad"] == trim["alpha_rad"]
    assert trim["throttle"] == pytest.approx(0.29099, abs=1e-5)
    assert (trim["airspeed_mps"], trim["altitude_m"]) == (30.0, 1000.0)
    assert max(abs(value) for value in trim["residual"].values()) < 1e-6
    np.testing.assert_allclose(hale["B"], B_M, atol=1e-3)
    J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])
    scale = 500.25 * 80.0 / (2.0 * 30.0)
    Cl_p, Cl_r, Cn_p, Cn_r, Cm_q = -0.5, 0.0282533, -0.0130179, -0.00975105, -13.7951
    b, c = 50.0, 1.634
    moments = scale * np.array([[b * b * Cl_p, 0, b * b * Cl_r], [0, c * c * Cm_q, 0], [b * b * Cn_p, 0, b * b * Cn_r]])
    np.testing.assert_allclose(hale["A"], np.linalg.solve(J, moments), atol=6e-3)


def test_the_norms_are_those_of_the_page(hale):
    # docs/theory.md prints them; they are computed and checked by quadrature in tests/analysis.
    for name, value in {
        "l1_norm_H": 16.1313, "l1_norm_G": 0.37453, "l1_norm_HCK": 3.49613,
        "l1_norm_H_A_m": 6.31802, "l1_norm_G_A_m": 0.33303, "l1_norm_HCK_A_m": 1.75283,
    }.items():  # fmt: skip
        assert hale[name] == pytest.approx(value, abs=1e-4), name


def test_what_is_not_stated_is_null_with_a_reason(hale):
    for name in ("sigma_0", "sigma_r", "r_max", "delta_5", "lipschitz", "condition_holds", "gamma_1", "gamma_2"):
        assert hale[name] is None, name
    assert "sigma_r" in hale["condition_reason"]
    assert "gamma_0" in hale["reason"]
    assert hale["lipschitz_max"] == pytest.approx(1.0 / hale["l1_norm_G"])
    assert "supremum" in hale["lipschitz_max_is"]
    assert hale["theorem_2"]["per_V"] is None
    assert "lambda_min" in hale["theorem_2"]["reason"]


def test_with_everything_stated_condition_and_bounds_are_numbers(tmp_path):
    stated = {"sigma_0": 0.0, "sigma_r": 1.0, "r_max": 0.1, "delta_5": 0.05, "lipschitz": 0.5, "gamma_0": 1e-6}
    options = [text for name, value in stated.items() for text in (f"--{name.replace('_', '-')}", str(value))]
    found = document(tmp_path, *options, "--omega", "0.5,0.7,1")
    assert {name: found[name] for name in stated} == stated
    assert found["omega"] == [0.5, 0.7, 1.0]
    assert found["condition_holds"] is True
    room = 1.0 - 0.1 * found["l1_norm_HCK"]
    assert found["lipschitz_max"] == pytest.approx(room / found["l1_norm_G"] - 0.05)
    assert found["gamma_1"] == pytest.approx(1e-6 * found["l1_norm_HCH_s"] / (1.0 - 0.5 * found["l1_norm_G"]))
    assert found["gamma_2"] > 0.0
    assert found["reason"] is None


def test_the_controller_can_come_from_a_scenario(tmp_path):
    text = (scenario_dir() / "scenario1.yaml").read_text(encoding="utf-8")
    other = text.replace("kind: l1", "kind: l1, reference_gain: printed")
    assert other != text
    (tmp_path / "mine.yaml").write_text(other, encoding="utf-8")
    found = document(tmp_path, "--scenario", "mine.yaml", "--set", "controller.inner.filter_bandwidth=30")
    assert found["filter_bandwidth"] == 30.0
    np.testing.assert_allclose(found["K"], found["K_2"])
    assert found["l1_norm_G"] > 0.5  # half the bandwidth leaves more to the disturbance than 0.37


def test_a_flight_is_set_beside_its_bounds(tmp_path):
    # In a process of its own: one document on standard output, and nothing in the folder.
    # Scenario 1 meets the assumptions: bounds of the continuous law, and the maxima of the sampled flight.
    command = [sys.executable, "-m", "uavftc", "design", "hale", "--json", "--flight", "scenario1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.iterdir()) == []
    flight = as_json(done.stdout)["flight"]
    jsbsim, analytic = flight["flights"]
    assert (jsbsim["plant"], analytic["plant"]) == ("jsbsim", "analytic")
    assert jsbsim["reference_system"] is None
    assert "analytic" in jsbsim["reason"]
    assert 0.0 < jsbsim["gamma_0"] < 1e-4
    assert analytic["assumptions_not_met"] == []
    assert analytic["reference_system"]["A_m"]["share_of_max_r"] < 0.03
    assert analytic["reference_system"]["A_s"]["share_of_max_r"] > 0.5
    assert analytic["bounds"]["A_m"]["gamma_1"] == pytest.approx(1.6669 * analytic["gamma_0"], rel=1e-3)
    assert analytic["bounds"]["A_m"]["x2_within"] is False  # sampled: see docs/theory.md


def test_a_flight_that_meets_no_assumptions_has_no_bounds(tmp_path):
    analytic = document(tmp_path, "--flight", "scenario3")["flight"]["flights"][1]
    assert analytic["bounds"] is None
    assert analytic["reason"] == "no bound: assumptions are not met"
    assert len(analytic["assumptions_not_met"]) == 4
    assert analytic["reference_system"]["A_m"]["largest_radps"] > 0.0


def test_for_reading_it_prints_a_summary(tmp_path):
    done = run(tmp_path, "hale", "--flight", "scenario2")
    assert done.exit_code == 0, done.output
    for words in ("level trim on JSBSim", "||H C K||", "16.1313", "no bound of Theorem 2", "d2 is discontinuous"):
        assert words in done.stdout
    assert list(tmp_path.iterdir()) == []


WRONG = {
    "an unknown aircraft": (["hail"], ["AIRCRAFT", "hail", "hale"]),
    "a negative bound": (["hale", "--sigma-0", "-1"], ["--sigma-0", "0 or above"]),
    "a bound of zero": (["hale", "--sigma-r", "0"], ["--sigma-r", "above 0"]),
    "no number": (["hale", "--lipschitz", "nan"], ["--lipschitz", "finite"]),
    "a text": (["hale", "--lipschitz", "much"], ["--lipschitz"]),
    "effectiveness over one": (["hale", "--omega", "1.5"], ["--omega", "at most 1"]),
    "two factors": (["hale", "--omega", "1,1"], ["--omega", "three"]),
    "a missing scenario": (["hale", "--scenario", "nowhere.yaml"], ["nowhere.yaml", "no such file"]),
    "a scenario without L1": (["hale", "--scenario", "mrac.yaml"], ["controller.inner.kind", "mrac"]),
    "a flight of another design": (
        ["hale", "--scenario", "slow.yaml", "--flight", "scenario1"],
        ["another inner loop"],
    ),
    "nothing to change": (["hale", "--set", "controller.rate_hz=100"], ["--set", "--scenario or --flight"]),
    "no aircraft": ([], ["AIRCRAFT"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_told(case, tmp_path):
    text = (scenario_dir() / "scenario1.yaml").read_text(encoding="utf-8")
    (tmp_path / "mrac.yaml").write_text(text.replace("kind: l1", "kind: mrac"), encoding="utf-8")
    slow = text.replace("kind: l1", "kind: l1, filter_bandwidth: 30")
    (tmp_path / "slow.yaml").write_text(slow, encoding="utf-8")
    arguments, words = WRONG[case]
    done = run(tmp_path, *arguments, "--json")
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
