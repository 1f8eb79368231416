"""`uavftc-fly` as a user runs it: in a separate process, in an empty folder."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from uavftc.cli.fly import next_steps
from uavftc.config.shipped import aircraft_dir, scenario_dir
from uavftc.results.history import read_history, read_metadata

COMMAND = [sys.executable, "-c", "from uavftc.cli.app import main_fly; main_fly()"]


def fly(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, text=True, check=False, timeout=120)


def test_a_shipped_scenario_flies_by_name_and_writes_the_contract(tmp_path: Path) -> None:
    done = fly(tmp_path, "scenario3")
    assert done.returncode == 0, done.stderr
    assert "IAE [rad s]" in done.stdout
    assert "results/scenario3-nndondi-l1-jsbsim" in done.stdout
    folder = tmp_path / "results" / "scenario3-nndondi-l1-jsbsim"
    names = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    assert names >= {"summary.json", "history.parquet", "scenario.yaml", "figures/tracking.png", "figures/control.png"}
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["completed"] is True
    assert summary["ended_because"] is None
    assert summary["timing"]["controller_steps"] == 4000
    assert set(summary["axes"]["pitch"]) == {
        "steady_state_error_deg", "convergence_time_s", "iae", "ise", "itae", "itse", "control_activity_rad",
    }  # fmt: skip
    assert {"uavftc", "jsbsim", "numpy", "python", "seed", "scenario_sha256", "aircraft_sha256"} <= set(
        summary["provenance"]
    )
    history = read_history(folder / "history.parquet")
    assert len(history["time_s"]) == 4001
    assert history["time_s"][-1] == 20.0
    assert "duration_s: 20.0" in read_metadata(folder / "history.parquet")["scenario"]


def test_flown_twice_and_flown_again_from_its_own_scenario_the_history_is_the_same(tmp_path: Path) -> None:
    bias = ("--set", "sensors.gyro_bias_degps=[0.1, 0.2, 0.3]", "--no-plots", "--quiet")
    assert fly(tmp_path, "scenario3", *bias, "--out", "a").returncode == 0
    assert fly(tmp_path, "scenario3", *bias, "--out", "b").returncode == 0
    assert fly(tmp_path, "a/scenario.yaml", "--no-plots", "--quiet", "--out", "c").returncode == 0
    a, b, c = ((tmp_path / name / "history.parquet").read_bytes() for name in "abc")
    assert a == b == c
    summaries = [json.loads((tmp_path / name / "summary.json").read_text(encoding="utf-8")) for name in "abc"]
    for summary in summaries:
        del summary["timing"]
    assert summaries[0] == summaries[1] == summaries[2]


def test_quiet_is_silent(tmp_path: Path) -> None:
    done = fly(tmp_path, "scenario1", "--quiet", "--no-plots", "--plant", "analytic")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_options_name_the_folder(tmp_path: Path) -> None:
    done = fly(
        tmp_path, "scenario1", "--aircraft", "hale", "--controller", "ndi-l1", "--plant", "analytic", "--no-plots"
    )
    assert done.returncode == 0, done.stderr
    assert [p.name for p in (tmp_path / "results").iterdir()] == ["scenario1-ndi-l1-analytic-hale"]


def test_a_lost_vehicle_is_exit_code_3_and_written(tmp_path: Path) -> None:
    done = fly(tmp_path, "scenario1", "--set", "envelope.bank_deg=2", "--out", "lost")
    assert done.returncode == 3
    assert "bank 2.0 deg, limit 2 deg" in " ".join(done.stdout.split())
    summary = json.loads((tmp_path / "lost" / "summary.json").read_text(encoding="utf-8"))
    assert summary["completed"] is False
    assert "t = " in summary["ended_because"]
    assert summary["axes"]["roll"]["steady_state_error_deg"] is None
    assert summary["axes"]["roll"]["convergence_time_s"] is None
    assert summary["axes"]["roll"]["iae"] > 0.0


def _scenario(folder: Path, old: str, new: str) -> str:
    text = (scenario_dir() / "scenario3.yaml").read_text(encoding="utf-8")
    assert old in text
    (folder / "mine.yaml").write_text(text.replace(old, new, 1), encoding="utf-8")
    return "mine.yaml"


def _aircraft(folder: Path, old: str, new: str) -> str:
    shutil.copytree(aircraft_dir() / "hale", folder / "bird")
    (folder / "bird" / "hale.xml").rename(folder / "bird" / "bird.xml")
    xml = folder / "bird" / "bird.xml"
    text = xml.read_text(encoding="utf-8")
    assert old in text
    xml.write_text(text.replace(old, new), encoding="utf-8")
    return "bird"


WRONG = {
    "a missing file": (lambda d: ["nowhere.yaml"], ["nowhere.yaml", "no such file"]),
    "a tab": (lambda d: [_scenario(d, "  outer:", "\touter:")], ["mine.yaml, line", "tab"]),
    "an unknown key": (
        lambda d: [_scenario(d, "duration_s: 20", "duration_s: 20\ndurations_s: 3")],
        ["mine.yaml, line", "durations_s", "duration_s"],
    ),
    "a negative duration": (
        lambda d: [_scenario(d, "duration_s: 20", "duration_s: -20")],
        ["mine.yaml, line", "duration_s", "-20"],
    ),
    "effectiveness high": (
        lambda d: ["scenario3", "--set", "faults[1].effectiveness=high"],
        ["--set faults[1].effectiveness=high", "'high'", "expression of t"],
    ),
    "an unknown surface": (
        lambda d: [_scenario(d, "surface: aileron", "surface: flap")],
        ["mine.yaml, line", "faults[0].surface", "flap", "aileron, elevator"],
    ),
    "overlapping faults": (
        lambda d: ["scenario3", "--set", "faults[0].end_s=9"],
        ["faults[0]", "faults[2]", "overlap"],
    ),
    "code in an expression": (
        lambda d: ["scenario3", "--set", "faults[0].bias_deg=\"__import__('os')\""],
        ["faults[0].bias_deg", "__import__"],
    ),
    "no such aircraft": (
        lambda d: ["scenario3", "--aircraft", "./nowhere"],
        ["--aircraft", "nowhere", "does not exist"],
    ),
    "an aircraft by a wrong name": (lambda d: ["scenario3", "--aircraft", "hail"], ["aircraft", "hail", "hale"]),
    "a typo in the aircraft": (
        lambda d: ["scenario3", "--aircraft", _aircraft(d, "emptywt", "emptywgt")],
        ["bird.xml, line", "emptywgt", "emptywt"],
    ),
    "an aircraft that aborts JSBSim": (
        lambda d: ["scenario3", "--aircraft", _aircraft(d, "aero/beta-rad", "aero/betta-rad")],
        ["bird.xml", "betta-rad"],
    ),
    "an unknown option": (lambda d: ["scenario3", "--fast"], ["--fast"]),
    "an unknown controller": (lambda d: ["scenario3", "--controller", "pdi"], ["pdi", "nndondi-l1"]),
    "turbulence of no strength": (
        lambda d: ["scenario1", "--set", "disturbances=[{kind: turbulence}]"],
        ["disturbances[0].severity", "light, moderate or severe", "sigma_mps"],
    ),
    "turbulence on the analytic plant": (
        lambda d: ["scenario1", "--plant", "analytic", "--set", "disturbances=[{kind: turbulence, severity: light}]"],
        ["disturbances[0].kind", "rotational only", "jsbsim"],
    ),
    "air on the analytic plant": (lambda d: ["gust", "--plant", "analytic"], ["rotational only", "jsbsim"]),
    "no trim at this speed": (
        lambda d: ["scenario1", "--set", "initial.airspeed_mps=150"],
        ["trim at 150 m/s", "initial.airspeed_mps"],
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_reported_and_nothing_is_written(case: str, tmp_path: Path) -> None:
    arguments, words = WRONG[case]
    given = arguments(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    done = fly(tmp_path, *given)
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    for word in words:
        assert word in done.stderr, done.stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_a_folder_of_the_users_is_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work", encoding="utf-8")
    done = fly(tmp_path, "scenario1", "--out", "mine", "--no-plots")
    assert done.returncode == 2
    assert "thesis.tex" in done.stderr
    assert [p.name for p in (tmp_path / "mine").iterdir()] == ["thesis.tex"]


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_ctrl_c_ends_a_flight_with_what_was_flown_on_disk(tmp_path: Path) -> None:
    arguments = ["scenario1", "--set", "duration_s=3600", "--out", "long", "--no-plots"]
    process = subprocess.Popen(
        [*COMMAND, *arguments], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60.0
    while not list(tmp_path.glob(".long.partial-*/history.parquet")) and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(0.7)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    summary = json.loads((tmp_path / "long" / "summary.json").read_text(encoding="utf-8"))
    assert summary["completed"] is False
    assert "interrupted" in summary["ended_because"]
    steps = summary["timing"]["controller_steps"]
    assert 0 < steps < 720_000
    assert len(read_history(tmp_path / "long" / "history.parquet", ["time_s"])["time_s"]) == steps + 1
    assert not list(tmp_path.glob(".long*"))


def test_the_umbrella_command_carries_fly(tmp_path: Path) -> None:
    umbrella = [sys.executable, "-m", "uavftc"]
    done = subprocess.run(
        [*umbrella, "fly", "scenario1", "--plant", "analytic", "--no-plots", "--out", "x"],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    version = subprocess.run([*umbrella, "--version"], capture_output=True, text=True, check=True, timeout=60)
    assert version.stdout.startswith("uavftc ")


def test_the_scenario_of_a_result_folder_is_not_lost_edited_or_not(tmp_path: Path) -> None:
    # the first thing a user does with it: open it, add a comment, fly it with the same default folder
    short = ("--plant", "analytic", "--no-plots", "--set", "duration_s=1")
    assert fly(tmp_path, "scenario1", *short).returncode == 0
    scenario = tmp_path / "results" / "scenario1-nndondi-l1-analytic" / "scenario.yaml"
    for words in ("which is to be flown, inside it", "which was changed after uavftc wrote it"):
        before = scenario.read_bytes()
        done = fly(tmp_path, str(scenario), "--no-plots", "--set", "duration_s=2")
        assert done.returncode == 2
        assert words in done.stderr
        assert scenario.read_bytes() == before
        scenario.write_bytes(b"# mine\n" + before)
    assert fly(tmp_path, str(scenario), "--no-plots", "--out", "elsewhere").returncode == 0


@pytest.mark.skipif(os.name == "nt", reason="flock")
def test_two_flights_into_one_folder_at_a_time_are_one_flight_and_a_message(tmp_path: Path) -> None:
    arguments = ["scenario1", "--set", "duration_s=3600", "--out", "one", "--no-plots"]
    with subprocess.Popen([*COMMAND, *arguments], cwd=tmp_path, stdout=-3, stderr=-3) as first:
        deadline = time.monotonic() + 60.0
        while not list(tmp_path.glob(".one.partial-*/history.parquet")) and time.monotonic() < deadline:
            time.sleep(0.02)
        second = fly(tmp_path, "scenario1", "--out", "one", "--no-plots")
        first.send_signal(signal.SIGINT)
        assert first.wait(timeout=60) == 130
    assert second.returncode == 2
    assert "another uavftc that is writing to it" in second.stderr
    assert os.listdir(tmp_path) == ["one"]


def test_json_is_the_summary_and_nothing_else_on_standard_output(tmp_path):
    options = ["--plant", "analytic", "--set", "duration_s=2", "--no-plots", "--json", "--out", str(tmp_path / "a")]
    run = subprocess.run(
        [sys.executable, "-m", "uavftc", "fly", "scenario1", *options], capture_output=True, text=True, check=True
    )
    assert json.loads(run.stdout) == json.loads((tmp_path / "a" / "summary.json").read_text(encoding="utf-8"))
    assert run.stderr.count("next:") == 0  # which is for a terminal


def test_what_to_do_next_fits_what_came_of_the_flight(tmp_path: Path) -> None:
    def lines(outcome: str) -> list[str]:
        return next_steps({"verdict": {"outcome": outcome}}, ["my file.yaml", "--set=seed=1"], tmp_path)

    assert lines("survived") == [f"uavftc report {tmp_path}  (one page, to zoom and play)"]
    assert lines("lost")[0].startswith("uavftc survivable 'my file.yaml' --set=seed=1")
    assert lines("numerical")[0].startswith("uavftc fly 'my file.yaml' --set=seed=1 --set simulation.substeps=N")
    assert next_steps({"verdict": None}, ["scenario1"], tmp_path) == []
