"""`uavftc compare` as a user meets it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uavftc.cli.app import umbrella

SHORT = ("--set", "duration_s=2", "--no-plots")


def run(*arguments: str):
    return CliRunner().invoke(umbrella, ["compare", *arguments])


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")


def test_both_plants_by_default_in_the_default_folder():
    done = run("scenario3", *SHORT)
    assert done.exit_code == 0, done.output
    assert "jsbsim against analytic" in done.stdout
    assert "results: " + str(Path("results/compare-scenario3")) in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80
    summary = json.loads(Path("results/compare-scenario3/summary.json").read_text(encoding="utf-8"))
    assert [(f["plant"], f["controller"]) for f in summary["combinations"]] == [
        ("jsbsim", "nndondi-l1"), ("analytic", "nndondi-l1"),
    ]  # fmt: skip
    assert 0.0 < summary["distances"][0]["attitude_deg"]["roll"]["rms"] < 1.0


def test_json_alone_on_standard_output_in_a_process_of_its_own(tmp_path):
    command = [sys.executable, "-m", "uavftc", "compare", "scenario2", "--json", *SHORT, "--controllers", "ndi-l1"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document == json.loads(Path("results/compare-scenario2/summary.json").read_text(encoding="utf-8"))
    assert document["controllers"] == ["ndi-l1"]
    assert "IAE [rad s]" in done.stderr


def test_quiet_says_nothing_and_the_aircraft_names_the_folder():
    done = run("scenario1", "--plants", "analytic", "--aircraft", "hale", "--quiet", *SHORT)
    assert (done.exit_code, done.output) == (0, "")
    assert [p.name for p in Path("results").iterdir()] == ["compare-scenario1-hale"]
    assert run("scenario1", "--plants", "analytic", "--quiet", "--json", *SHORT).stderr == ""


def test_a_lost_vehicle_is_exit_code_3_with_everything_written():
    done = run("scenario3", *SHORT, "--set", "envelope.min_airspeed_mps=29.9", "--out", "lost")
    assert done.exit_code == 3
    assert "LOST" in done.stdout
    assert "jsbsim, nndondi-l1: lost: airspeed" in done.stdout
    assert sorted(p.name for p in Path("lost/histories").iterdir()) == [
        "analytic-nndondi-l1.parquet", "jsbsim-nndondi-l1.parquet",
    ]  # fmt: skip


WRONG = {
    "an unknown plant": (
        ["scenario1", "--plants", "jsbsim,analytc"],
        ["--plants", "'analytc'", "did you mean analytic"],
    ),
    "a plant twice": (["scenario1", "--plants", "jsbsim,jsbsim"], ["--plants", "jsbsim twice", "jsbsim, analytic"]),
    "nothing between commas": (["scenario1", "--plants", "jsbsim,"], ["--plants", "''", "jsbsim, analytic"]),
    "an unknown controller": (["scenario1", "--controllers", "pdi"], ["--controllers pdi", "'pdi'", "nndondi-l1"]),
    "a controller twice": (["scenario1", "--controllers", "ndi-l1, ndi-l1"], ["--controllers", "ndi-l1 twice"]),
    "air on the analytic plant": (["gust"], ["rotational only", "jsbsim"]),
    "a plant by --set": (["scenario1", "--set", "plant=analytic"], ["--set plant", "analytic", "--plants"]),
    "a controller by --set": (
        ["scenario1", "--controllers", "ndi-l1", "--set", "controller.inner.kind=mrac"],
        ["--set controller", "ndi-mrac", "--controllers"],
    ),
    "an unknown scenario": (["scenari1"], ["scenari1", "did you mean scenario1"]),
    "an unknown aircraft": (["scenario1", "--aircraft", "hail"], ["hail", "hale"]),
    "a flight that cannot be trimmed": (
        ["scenario1", "--plants", "analytic,jsbsim", "--set", "initial.airspeed_mps=150"],
        ["trim at 150 m/s"],
    ),
    "an unknown option": (["scenario1", "--plant", "jsbsim"], ["--plant"]),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_input_is_reported_and_nothing_is_written(case: str, tmp_path: Path):
    arguments, words = WRONG[case]
    done = run(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    for word in words:
        assert word in done.stderr, done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_foreign_file_in_the_result_folder_is_named_and_kept():
    Path("mine").mkdir()
    Path("mine/thesis.tex").write_text("years of work", encoding="utf-8")
    done = run("scenario1", *SHORT, "--out", "mine")
    assert done.exit_code == 2
    assert "thesis.tex" in done.stderr
    assert [p.name for p in Path("mine").iterdir()] == ["thesis.tex"]


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_ctrl_c_ends_it_at_once_and_leaves_nothing(tmp_path):
    script = (
        "import uavftc.jobs.compare as c; fly = c.fly_one\n"
        "def fly_one(scenario): print('flying', flush=True); return fly(scenario)\n"
        "c.fly_one = fly_one\n"
        "from uavftc.cli.app import main; main()"
    )
    arguments = ["compare", "scenario1", "--set", "duration_s=3600", "--out", "deep/run"]
    process = subprocess.Popen(
        [sys.executable, "-c", script, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "flying\n"
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert out == ""  # no second flight was begun
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_every_one_of_six_controllers_is_shown_in_80_columns():
    six = "nndondi-l1,ndi-l1,nndondi-mrac,ndi-mrac,pid,lqi"
    done = run("scenario3", *SHORT, "--plants", "analytic", "--controllers", six)
    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    headings = [line.split() for line in lines if line.split() and set(line.split()) <= set(six.split(","))]
    assert [name for heading in headings for name in heading] == six.split(",")
    assert sum(line.startswith("IAE") for line in lines) == 3 * len(headings)  # each block has its axes
    assert "…" not in done.stdout


def test_the_scenario_inside_the_result_folder_is_not_lost():
    assert run("scenario3", *SHORT, "--plants", "analytic", "--out", "mine").exit_code == 0
    before = Path("mine/scenario.yaml").read_bytes()
    done = run("mine/scenario.yaml", "--plants", "analytic", "--set", "duration_s=1", "--out", "mine")
    assert done.exit_code == 2
    assert "scenario.yaml, which is to be flown, inside it" in done.stderr
    assert Path("mine/scenario.yaml").read_bytes() == before
