"""`uavftc aircraft`, on a short list; the whole list is slow."""

from __future__ import annotations

import functools
import json
import os
import signal
import subprocess
import sys
import time

import pytest
from typer.testing import CliRunner

from uavftc.aircraft.definition import Aircraft
from uavftc.cli.app import umbrella
from uavftc.core.cache import cache_folder
from uavftc.jobs.design import fleet

FEW = ["hale", "jsbsim:c172p", "jsbsim:mk82"]
KEYS = {
    "aircraft", "measured", "mass_kg", "span_m", "engines", "trims", "method", "airspeed_mps", "altitude_m", "flyable",
    "weakest_axis", "ratio", "reason", "without",
}  # fmt: skip


@pytest.fixture
def few(monkeypatch, tmp_path):
    """Three aircraft, and rows that are measured anew (their models may come from the cache)."""
    monkeypatch.setattr(fleet, "names", lambda: FEW)
    monkeypatch.setattr(fleet, "cache_folder", functools.partial(cache_folder, home=tmp_path / "cache"))


def run(*arguments):
    return CliRunner().invoke(umbrella, ["aircraft", *arguments])


def as_json(*arguments):
    done = run("--json", *arguments)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_each_aircraft_has_its_row(few, monkeypatch):
    rows = as_json()
    assert [row["aircraft"] for row in rows] == FEW
    assert all(row.keys() == KEYS for row in rows)
    hale, cessna, bomb = rows
    assert (hale["mass_kg"], hale["span_m"], hale["engines"]) == (pytest.approx(425.0), 50.0, 2)
    assert (hale["trims"], hale["method"], hale["airspeed_mps"]) == (True, "own", 30.0)
    assert cessna["span_m"] == pytest.approx(10.9, abs=0.1)  # a Cessna 172: 36 ft, give or take a wing tip
    assert cessna["flyable"] is True
    assert cessna["ratio"] > 1.0
    assert bomb["trims"] is bomb["flyable"] is False
    assert "no steady flight" in bomb["reason"]
    assert bomb["mass_kg"] is bomb["span_m"] is None
    # The second time, nothing is measured.
    monkeypatch.setattr(fleet, "row_of", None)
    assert as_json() == rows


def test_for_reading_it_is_one_aligned_line_each(few):
    done = run()
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert len(lines) == 2 + len(FEW) + 2
    assert max(map(len, lines)) <= 80
    for name, line in zip(FEW, lines[2:], strict=False):
        assert line.startswith(name)
    assert "yes (yaw 3.8 times)" in lines[3]
    assert "no steady flight found" in lines[4]
    assert lines[-1] == "3 aircraft: 2 can be flown, 0 trim but cannot be flown, 1 do not trim or load"


def test_quick_measures_nothing(few, monkeypatch):
    monkeypatch.setattr(fleet, "row_of", None)
    rows = as_json("--quick")
    assert not any(row["measured"] for row in rows)
    assert all(row["flyable"] is None for row in rows)
    assert "3 not measured yet" in run("--quick").stdout


def test_what_was_not_finished_is_not_kept(few, monkeypatch):
    found = fleet._row("hale", measured=True, reason="JSBSim does not finish loading and trimming it within 120 s")
    monkeypatch.setattr(fleet, "row_of", lambda name: found | {"aircraft": name})
    assert as_json()[0]["reason"].startswith("JSBSim does not finish")
    assert fleet.cached("hale") is None


def test_a_change_of_the_files_is_measured_anew(few, monkeypatch, tmp_path):
    before = fleet._file("hale")
    assert before != fleet._file("jsbsim:c172p")
    monkeypatch.setattr(Aircraft, "sha256", lambda self: "0" * 64)
    assert fleet._file("hale") != before


CTRL_C = """
import sys
from uavftc.jobs.design import fleet
from uavftc.cli.app import main
import subprocess
fleet.names = lambda: ["hale", "jsbsim:c172p", "jsbsim:737"]
fleet.cached = lambda name: None
def slow(name):
    print("begun", flush=True)
    done = subprocess.run([sys.executable, "-c", "import time; time.sleep(60)"], capture_output=True)
    return fleet._row(name, measured=True, reason="JSBSim crashes (SIGINT)" if done.returncode < 0 else None)
fleet.row_of = slow
sys.argv = ["uavftc", "aircraft"]
main()
"""


@pytest.mark.skipif(os.name != "posix", reason="a process group is signalled, as a terminal does")
def test_ctrl_c_ends_it_at_once():
    command, pipe = [sys.executable, "-c", CTRL_C], subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True) as child:
        try:
            assert child.stdout is not None
            assert child.stdout.readline().startswith("begun")
            time.sleep(0.5)
            os.killpg(child.pid, signal.SIGINT)
            _, errors = child.communicate(timeout=20)
        finally:
            child.kill()
    assert child.returncode == 130
    assert errors.splitlines()[-1] == "interrupted"
    assert "Traceback" not in errors


@pytest.mark.slow
def test_the_whole_list(monkeypatch):
    rows = as_json()
    assert len(rows) > 40
    assert sum(row["flyable"] for row in rows) >= 26
    assert all(row["reason"] for row in rows if not row["flyable"])


def test_what_design_has_measured_is_known_to_the_list(few):
    assert CliRunner().invoke(umbrella, ["design", "jsbsim:c172p"]).exit_code == 0
    assert [row["measured"] for row in as_json("--quick")] == [False, True, False]
    assert CliRunner().invoke(umbrella, ["design", "hale", "--airspeed-mps", "32"]).exit_code == 0  # not as listed
    assert [row["measured"] for row in as_json("--quick")] == [False, True, False]


def test_a_long_reason_goes_on_in_the_next_line():
    from uavftc.report import fleet_table

    row = fleet._row("jsbsim:wrightFlyer1903", measured=True, reason="one word after another " * 6)
    lines = fleet_table.lines([row])
    assert max(map(len, lines)) <= 80
    assert " ".join(" ".join(lines[2:-2]).split()).endswith(("one word after another " * 6).strip())
