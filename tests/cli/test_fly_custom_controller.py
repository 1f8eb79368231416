"""Custom controllers from the command line: flown, lost, compared, and wrong."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from uavftc.results.history import read_history

GOOD = """
import numpy as np
def create(design, h, options):
    B_inverse = np.linalg.inv(design.B)
    return lambda t, x1_c, x1, x2: B_inverse @ (options.get("gain", 4.0) * (0.5 * (x1_c - x1) - x2))
"""
FAILS_AT = """
def create(design, h, options):
    def step(t, x1_c, x1, x2):
        if t >= {}:
            raise RuntimeError("enough")
        return 0, 0, 0
    return step
"""


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "uavftc", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


def test_a_file_and_a_module_of_the_working_folder_fly_and_fly_again(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(GOOD, encoding="utf-8")
    gain = ("--set", "controller.options.gain=5", "--no-plots")
    done = run(tmp_path, "fly", "scenario3", "--controller", "./mine.py", *gain)
    assert done.returncode == 0, done.stderr
    assert "scenario3: mine on hale, jsbsim" in done.stdout
    first = tmp_path / "results" / "scenario3-mine-jsbsim"
    summary = json.loads((first / "summary.json").read_text(encoding="utf-8"))
    assert summary["controller"] == "mine"
    assert len(summary["provenance"]["controller_sha256"]) == 64
    assert f'kind: "{tmp_path / "mine.py"}"' in (first / "scenario.yaml").read_text(encoding="utf-8")
    assert run(tmp_path, "fly", str(first / "scenario.yaml"), "--no-plots", "--out", "b").returncode == 0
    assert (first / "history.parquet").read_bytes() == (tmp_path / "b" / "history.parquet").read_bytes()
    history = read_history(first / "history.parquet", ["p_ref_radps", "aileron_cmd_rad"])
    assert np.all(np.isnan(history["p_ref_radps"]))
    assert not np.any(np.isnan(history["aileron_cmd_rad"]))
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "law.py").write_text(GOOD, encoding="utf-8")
    assert run(tmp_path, "fly", "scenario3", "--controller", "pack.law", *gain, "--out", "c").returncode == 0
    same = read_history(tmp_path / "c" / "history.parquet", ["aileron_cmd_rad"])
    np.testing.assert_array_equal(same["aileron_cmd_rad"], history["aileron_cmd_rad"])


@pytest.mark.parametrize("at", [1.0, 0.0])
def test_an_exception_in_flight_is_a_lost_vehicle(tmp_path: Path, at: float) -> None:
    # the trial ends at 0.005 s; at 0 the trial itself would fail, so the step fails there on what only a flight has
    source = FAILS_AT.format(at) if at else FAILS_AT.format("0 and x1_c[0] > 0.05")
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    figures = ["--no-plots"] if at else []  # those of a flight without a row are drawn too
    done = run(tmp_path, "fly", "scenario1", "--controller", "mine.py", "--out", "lost", *figures)
    assert done.returncode == 3, done.stderr
    assert "Traceback" not in done.stderr
    summary = json.loads((tmp_path / "lost" / "summary.json").read_text(encoding="utf-8"))
    assert summary["completed"] is False
    for word in ("RuntimeError: enough", f"{tmp_path / 'mine.py'}, line 5", f"at t = {at:.3f} s"):
        assert word in summary["ended_because"]
    assert len(read_history(tmp_path / "lost" / "history.parquet")["time_s"]) == round(200 * at)


def test_custom_controllers_are_compared_and_their_results_replaced(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(GOOD, encoding="utf-8")
    arguments = (
        "compare",
        "scenario3",
        "--plants",
        "analytic",
        "--controllers",
        "ndi-l1,pid,./mine.py",
        "--out",
        "c",
        "--no-plots",
    )
    done = run(tmp_path, *arguments)
    assert done.returncode == 0, done.stderr
    names = {path.name for path in (tmp_path / "c" / "histories").iterdir()}
    assert names == {"analytic-ndi-l1.parquet", "analytic-pid.parquet", "analytic-mine.parquet"}
    assert run(tmp_path, *arguments).returncode == 0  # its own folder is replaced
    (tmp_path / "c" / "histories" / "analytic-thesis.parquet").write_text("years of work", encoding="utf-8")
    done = run(tmp_path, *arguments)  # one that no controller of it has written is not
    assert done.returncode == 2
    assert "analytic-thesis.parquet" in done.stderr
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.py").write_text(GOOD, encoding="utf-8")
    done = run(tmp_path, "compare", "scenario1", "--controllers", "./mine.py,./other/mine.py")
    assert done.returncode == 2
    assert "two controllers with the name mine" in done.stderr


WRONG = {
    "a typo": (
        None,
        "pdi",
        ["--controller pdi", "one of ndi-l1", "pid, lqi", "mean pid?", "./my_controller.py"],
    ),
    "no file": (None, "./nowhere.py", ["--controller ./nowhere.py", "not a file", "looked in"]),
    "no such module": (None, "numpy.nowhere", ["numpy.nowhere", "no module numpy.nowhere"]),
    "no controller": ("x = 1", "mine.py", ["mine.py", "neither create", "create(design, h, options)"]),
    "a wrong signature": ("def create(design): pass", "mine.py", ["mine.py, create", "create(design)"]),
    "a bug": (FAILS_AT.format(0), "mine.py", ["RuntimeError: enough", "line 5", "correct line 5"]),
    "a wrong result": (
        GOOD.replace("- x2)", "- x2)[:2]").replace("B_inverse @", ""),
        "mine.py",
        ["mine.py, step", "three"],
    ),
    "an option of pid": (None, "pid", ["controller.options.speed", "rate_bandwidth"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_controllers_are_reported_and_nothing_is_written(case: str, tmp_path: Path) -> None:
    source, controller, words = WRONG[case]
    if source is not None:
        (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    more = ["--set", "controller.options.speed=1"] if case == "an option of pid" else []
    before = sorted(tmp_path.rglob("*"))
    done = run(tmp_path, "fly", "scenario1", "--controller", controller, *more)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    for word in words:
        assert word in done.stderr, done.stderr
    assert sorted(tmp_path.rglob("*")) == before
