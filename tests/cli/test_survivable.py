"""`uavftc survivable` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uavftc.cli.app import umbrella

QUICK = ("--plant", "analytic", "--no-sweep")


def run(*arguments: str):
    return CliRunner().invoke(umbrella, ["survivable", *arguments])


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")


def test_an_answer_a_folder_and_exit_code_0():
    done = run("scenario3", "--plant", "analytic")
    assert done.exit_code == 0, done.output
    assert "a steady state exists at the reference, in every phase" in " ".join(done.stdout.split())
    assert max(map(len, done.stdout.splitlines())) <= 80
    folder = Path("results/survivable-scenario3")
    assert f"results: {folder}" in done.stdout
    assert sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()) == [
        "figures/survivable.png", "scenario.yaml", "summary.json",
    ]  # fmt: skip


def test_a_no_is_an_answer_too():
    stuck = "faults=[{kind: stuck, surface: elevator, at_deg: 3}]"
    done = run("scenario1", *QUICK, "--set", stuck)
    assert done.exit_code == 0, done.output
    assert "no controller is to blame" in " ".join(done.stdout.split())


def test_json_alone_on_standard_output_is_the_summary():
    done = run("scenario2", *QUICK, "--json", "--out", "here")
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert document == json.loads(Path("here/summary.json").read_text(encoding="utf-8"))
    assert document["survivable"] is True
    assert "authority left" in done.stderr


def test_quiet_says_nothing_and_the_aircraft_names_the_folder():
    done = run("scenario1", *QUICK, "--aircraft", "hale", "--quiet", "--no-plots")
    assert (done.exit_code, done.output) == (0, "")
    assert [p.name for p in Path("results").iterdir()] == ["survivable-scenario1-hale"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("scenario1", "--within-deg", "0"), "--within-deg 0"),
        (("scenario1", "--within-deg", "nan"), "an angle above 0, up to 45"),
        (("scenario1", "--within-deg", "90"), "leave it out for 1 deg"),
        (("scenario9",), "scenario9"),
        (("scenario1", "--set", "duration_s=-1"), "duration_s"),
        (("scenario1", "--plant", "paper"), "plant"),
        (("scenario1", "--set", "faults=[{kind: stuck, surface: flap, at_deg: 3}]"), "flap"),
        (("scenario1", "--aircraft", "jsbsim:nothing"), "nothing"),
    ],
)
def test_wrong_input_ends_with_2_and_nothing_is_written(arguments, said):
    done = run(*arguments)
    assert done.exit_code == 2
    assert done.stderr.startswith("error: ")
    assert said in done.stderr
    assert "Traceback" not in done.output
    assert not Path("results").exists()


def test_a_folder_with_something_else_in_it_is_left_alone():
    Path("mine").mkdir()
    Path("mine/notes.txt").write_text("keep", encoding="utf-8")
    done = run("scenario1", *QUICK, "--out", "mine")
    assert done.exit_code == 2
    assert [p.name for p in Path("mine").iterdir()] == ["notes.txt"]
