"""Campaigns: cases that depend on nothing but the file, the table, and what a campaign survives."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.stats import qmc
from typer.testing import CliRunner

from in_process import InProcess
from uavftc.cli.app import umbrella
from uavftc.config.shipped import scenario_dir
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.campaign import sweep
from uavftc.jobs.campaign.cases import Cases, quantile
from uavftc.jobs.campaign.engine import rows
from uavftc.jobs.campaign.evaluate import Job, Plan, evaluate, prepare
from uavftc.jobs.campaign.local import LocalEngine
from uavftc.jobs.campaign.sweep import ready
from uavftc.jobs.campaign.table import content
from uavftc.jobs.campaign.variants import reached, variants_of
from uavftc.report.rate import line
from uavftc.scenario.campaign import Vary, load_campaign
from uavftc.scenario.changed import changed
from uavftc.scenario.load import load_scenario

FILE = """\
name: small
base: scenario1
seed: 7
cases: 6
vary:
  "reference.phi_deg": {uniform: [1, 5]}
  "reference.theta_deg": {choice: [0, 2]}
controllers: [ndi-l1, nndondi-mrac]
plants: [analytic]
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


def cases_of(file, *overrides):
    return Cases(load_campaign(file, overrides))


def run(*arguments):
    return CliRunner().invoke(umbrella, ["sweep", *map(str, arguments)])


# --- cases ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("design", ["random", "sobol", "lhs"])
def test_a_case_is_the_same_alone_in_any_order_and_in_another_process_order(file, design):
    whole = list(cases_of(file, f"design={design}", "cases=600"))
    again = cases_of(file, f"design={design}", "cases=600")
    assert [again.values(case) for case in (599, 3, 300)] == [whole[case] for case in (599, 3, 300)]


@pytest.mark.parametrize("design", ["random", "sobol"])
def test_more_cases_leave_the_first_ones_as_they_were(file, design):
    few = list(cases_of(file, f"design={design}", "cases=5"))
    assert list(cases_of(file, f"design={design}", "cases=500"))[:5] == few


def test_another_seed_gives_other_cases_and_another_key_does_not(file):
    first = cases_of(file).values(0)
    assert cases_of(file, "seed=8").values(0) != first
    more = cases_of(file, "vary.duration_s={choice: [5, 6]}").values(0)
    assert {key: more[key] for key in first} == first


def test_sobol_points_are_those_of_scipy_scrambled_by_the_stream_of_the_seed(file):
    from uavftc.core.random import stream

    points = qmc.Sobol(2, scramble=True, seed=stream(7, "campaign sobol")).random(512)
    cases = cases_of(file, "design=sobol", "cases=512")
    phi = [cases.values(case)["reference.phi_deg"] for case in range(512)]
    assert np.allclose(phi, 1.0 + 4.0 * points[:, 0], rtol=0, atol=1e-12)


def test_a_latin_hypercube_has_one_case_in_each_of_as_many_slices(file):
    phi = [values["reference.phi_deg"] for values in cases_of(file, "design=lhs", "cases=50")]
    assert sorted(int((value - 1.0) / 4.0 * 50) for value in phi) == list(range(50))


def test_quantiles_are_those_of_the_distributions():
    assert quantile(Vary(uniform=(2, 6)), 0.25) == 3.0
    assert quantile(Vary(normal=(1, 2)), 0.5) == 1.0
    assert quantile(Vary(normal=(1, 2)), 0.8413447460685429) == pytest.approx(3.0, abs=1e-12)  # one deviation above
    assert quantile(Vary(log_uniform=(1, 100)), 0.5) == pytest.approx(10.0, rel=1e-15)
    assert [quantile(Vary(integer=(3, 5)), u) for u in (0.01, 0.34, 0.99)] == [3, 4, 5]
    assert [quantile(Vary(choice=("a", 2)), u) for u in (0.49, 0.51)] == ["a", 2]


def test_a_grid_is_counted_off_with_lists_in_step(file):
    text = FILE.replace("{uniform: [1, 5]}", "{grid: [1, 2, 3]}").replace("{choice: [0, 2]}", "{list: [0, 2]}")
    text = text.replace("cases: 6\n", "").replace("seed: 7", "design: grid")
    text = text.replace("controllers", '  "reference.psi_deg": {list: [5, 6]}\ncontrollers')
    file.write_text(text, encoding="utf-8")
    cases = [tuple(values.values()) for values in cases_of(file)]
    assert cases == [(1, 0, 5), (2, 0, 5), (3, 0, 5), (1, 2, 6), (2, 2, 6), (3, 2, 6)]


# --- flights -------------------------------------------------------------------------------------------------------


def test_a_row_is_what_the_flight_alone_gives(file):
    made = ready(load_campaign(file))
    prepare(Plan(made.variants, None, "none"))
    values = made.cases.values(2)
    row = evaluate(Job(2, 0, values))
    scenario = changed(load_scenario("scenario1", plant="analytic", controller="ndi-l1"), values)
    flight = build_flight(scenario)
    records, _ = fly_to_memory(flight)
    monitor = flight.monitor()
    monitor.take(records)
    assert row["margin"] == min(one.margin for one in monitor.found())
    assert (row["case"], row["controller"], row["reference.phi_deg"]) == (2, "ndi-l1", values["reference.phi_deg"])


def test_a_key_inside_a_value_that_is_chosen_leaves_the_choice_as_the_file_has_it(file):
    # the fault is chosen, and its onset drawn: an onset that stayed in the choice would be in the rows of other cases
    vary = "{faults: {choice: [[{kind: stuck, surface: rudder}]]}, 'faults[0].start_s': {uniform: [1, 2]}}"
    made = ready(load_campaign(file, [f"vary={vary}"]))
    fault = {"kind": "stuck", "surface": "rudder"}
    prepare(Plan(made.variants, None, "none"))
    for case in range(2):
        values = made.cases.values(case)
        assert (values["faults"], evaluate(Job(case, 0, values))["faults"]) == ([fault], [fault])


def test_what_did_not_reach_the_flight_is_seen():
    scenario = load_scenario("scenario3")
    asked = {"faults[0].effectiveness": 0.5, "faults[4].effectiveness": "0.2*t", "sensors.gyro_bias_degps": 0}
    assert reached(scenario, asked) == []
    assert reached(scenario, {**asked, "faults[0].effectiveness": 0.4, "faults[9].start_s": 1}) == [
        "faults[0].effectiveness",
        "faults[9].start_s",
    ]


def test_the_table_does_not_depend_on_the_workers_and_the_controllers_fly_the_same_cases(file, tmp_path):
    for workers in (1, 2):
        result = run(file, "--workers", workers, "--out", tmp_path / str(workers), "--quiet")
        assert result.exit_code == 0, result.output
    one, two = content(tmp_path / "1"), content(tmp_path / "2")
    assert one.equals(two)
    rows = one.to_pylist()
    assert [(row["case"], row["controller"]) for row in rows] == [
        (case, controller) for case in range(6) for controller in ("ndi-l1", "nndondi-mrac")
    ]
    inputs = ("reference.phi_deg", "reference.theta_deg")
    assert all(a[key] == b[key] for a, b in zip(rows[::2], rows[1::2], strict=True) for key in inputs)
    assert not (tmp_path / "1" / "parts").exists()
    summary = json.loads((tmp_path / "1" / "summary.json").read_text(encoding="utf-8"))
    assert summary["flights"] == 12
    assert {"campaign.json", "flights.parquet"} <= set(summary["files"])


def test_histories_of_the_worst_are_kept_and_are_those_of_the_flights(file, tmp_path):
    out = tmp_path / "out"
    assert run(file, "--set", "histories={worst: 2}", "--out", out, "--quiet").exit_code == 0
    rows = sorted(content(out).to_pylist(), key=lambda row: row["margin"])[:2]
    names = {f"{row['case']:06d}-{row['controller']}.parquet" for row in rows}
    assert {path.name for path in (out / "histories").iterdir()} == names
    row = rows[0]
    history = pq.read_table(out / "histories" / f"{row['case']:06d}-{row['controller']}.parquet")
    assert history["phi_ref_rad"][-1].as_py() == pytest.approx(np.radians(row["reference.phi_deg"]), rel=1e-12)


def _plan(file):
    return Plan(variants_of(load_campaign(file)), None, "none")


def test_a_worker_that_is_killed_costs_nothing_and_the_flight_is_flown_again(file):
    plan, killed, rows = _plan(file), [], []
    jobs = (Job(i, 0, {"reference.phi_deg": 1.0}) for i in range(40))
    with LocalEngine(plan, 1, 60.0) as engine:
        for row in engine.fly(jobs):
            if row is None:
                continue
            rows.append(row)
            if len(rows) == 3:
                import multiprocessing

                killed = [child.pid for child in multiprocessing.active_children()]
                for pid in killed:
                    os.kill(pid, signal.SIGKILL)
    assert killed
    assert sorted(row["case"] for row in rows) == list(range(40))
    assert {row["outcome"] for row in rows} <= {"survived", "degraded"}


def test_workers_that_die_while_there_is_nothing_to_fly_cost_nothing(file):
    import multiprocessing

    jobs = [Job(i, 0, {"duration_s": 1.0}) for i in range(4)]
    with LocalEngine(_plan(file), 1, 60.0) as engine:
        first = rows(engine, jobs)
        for child in multiprocessing.active_children():
            child.kill()
            child.join()
        time.sleep(0.5)
        second = rows(engine, jobs)
    assert [row["case"] for row in second] == [0, 1, 2, 3]
    assert [row["margin"] for row in second] == [row["margin"] for row in first]


def test_a_flight_that_takes_too_long_is_an_error_and_the_others_are_flown(file):
    long = Job(0, 0, {"duration_s": 3000.0})
    short = Job(1, 0, {"duration_s": 1.0})
    with LocalEngine(_plan(file), 1, 0.05) as engine:
        engine._timeout_s = 60.0
        first = [row for row in engine.fly(iter([short])) if row]  # loads and compiles
        engine._timeout_s = 0.05
        late = [row for row in engine.fly(iter([long])) if row]
        engine._timeout_s = 60.0
        last = [row for row in engine.fly(iter([short])) if row]
    assert [row["outcome"] for row in late] == ["error"]
    assert late[0]["reason"] == "not done within 0.05 s"
    assert first[0]["margin"] == last[0]["margin"]


# --- what it survives ----------------------------------------------------------------------------------------------

SCRIPT = """\
from uavftc.cli import entry
import uavftc.jobs.campaign.sweep as sweep
sweep.PART_S = 0.1
if __name__ == "__main__":
    entry.main()
"""


def begun(file, tmp_path, out, *more):
    """Start a campaign in a process of its own, and return it when two more parts are there."""
    before = len(list((out / "parts").glob("part-*")))
    script = tmp_path / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    command = [sys.executable, script, "sweep", file, "--workers", "1", "--out", out, "--quiet", *more]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    limit = time.monotonic() + 300
    while len(list((out / "parts").glob("part-*"))) < before + 2:
        assert process.poll() is None, process.communicate()[0]
        assert time.monotonic() < limit
        time.sleep(0.02)
    return process


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no kill -9 here")
def test_what_kill_9_and_ctrl_c_leave_is_gone_on_with_and_the_table_is_the_same(file, tmp_path):
    many = ("--set", "cases=250")
    whole, out = tmp_path / "whole", tmp_path / "out"
    process = begun(file, tmp_path, out, *many)
    process.kill()
    process.communicate()
    parts = sorted((out / "parts").glob("part-*.parquet"))
    torn = parts[-1].read_bytes()
    parts[-1].write_bytes(torn[: len(torn) // 2])  # as a power cut may leave it
    (out / "parts" / ".part-000099.parquet").write_bytes(b"PAR1")

    refused = run(file, *many, "--out", out)
    assert refused.exit_code == 2
    assert "an unfinished campaign" in refused.output

    other = run(file, "--set", "cases=251", "--out", out, "--resume")
    assert other.exit_code == 2
    assert "campaign.cases: was 250, is 251" in other.output

    process = begun(file, tmp_path, out, *many, "--resume")
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[0]
    assert process.returncode == 130, said
    assert "--resume flies the rest" in said

    assert run(file, *many, "--out", out, "--resume", "--quiet", "--workers", "2").exit_code == 0
    assert run(file, *many, "--out", whole, "--quiet", "--workers", "2").exit_code == 0
    assert content(out).equals(content(whole))
    assert run(file, *many, "--out", out, "--resume", "--quiet").exit_code == 0  # nothing is left to fly


@pytest.fixture
def full_disk(monkeypatch):
    """Let the disk be full after some writes, as `table.whole` meets it."""
    room = {}

    def limit(kind, writes):
        room[kind] = writes

    opened = Path.open

    def maybe_full(path, mode="r", *arguments, **named):
        kind = "histories" if path.parent.name == "histories" else "part" if "part-" in path.name else None
        if "w" in mode and kind in room:
            room[kind] -= 1
            if room[kind] < 0:
                raise OSError(errno.ENOSPC, "No space left on device", str(path))
        return opened(path, mode, *arguments, **named)

    monkeypatch.setattr(Path, "open", maybe_full)
    return limit


@pytest.mark.parametrize("kind", ["histories", "part"])
def test_a_full_disk_ends_the_campaign_which_goes_on_when_there_is_room(file, tmp_path, full_disk, monkeypatch, kind):
    monkeypatch.setattr(sweep, "engine_of", InProcess)
    monkeypatch.setattr(sweep, "PART_ROWS", 3)
    out, more = tmp_path / "out", ("--set", "histories=all", "--out", tmp_path / "out", "--quiet")
    full_disk(kind, 5 if kind == "histories" else 1)
    full = run(file, *more)
    assert full.exit_code == 1, full.output
    kept = sum(pq.read_metadata(path).num_rows for path in (out / "parts").glob("part-*.parquet"))
    said = " ".join(full.output.split())
    assert "No space left on device" in said
    assert f"{kept} of 12 flights are kept" in said
    assert "Traceback" not in said
    assert kept == (5 if kind == "histories" else 3)  # all whose history is there; the rows of the first part
    assert not list(out.rglob(".*"))  # nothing half written

    full_disk(kind, 1000)
    assert run(file, *more, "--resume").exit_code == 0
    assert len(list((out / "histories").iterdir())) == 12
    assert run(file, "--set", "histories=all", "--out", tmp_path / "whole", "--quiet").exit_code == 0
    assert content(out).equals(content(tmp_path / "whole"))


def test_parts_that_a_kill_left_behind_a_summary_are_removed_at_resume(file, tmp_path, monkeypatch):
    monkeypatch.setattr(sweep, "engine_of", InProcess)
    out = tmp_path / "out"
    assert run(file, "--out", out, "--quiet").exit_code == 0
    (out / "parts").mkdir()
    for name in ("part-000001.parquet", ".part-000002.parquet"):
        (out / "parts" / name).write_bytes((out / "flights.parquet").read_bytes())
    before = content(out)
    assert run(file, "--out", out, "--resume", "--quiet").exit_code == 0
    assert not (out / "parts").exists()
    assert content(out).equals(before)


def test_the_progress_says_rate_time_left_and_failures():
    assert line(30, 100, 1, 20, 10.0) == "30 of 100 flights (30 %), 2 a second, 35 s left, 1 failure"
    assert line(100, 100, 0, 100, 10.0) == "100 of 100 flights (100 %), 10 a second, 0 failures"


def test_a_dry_run_shows_cases_and_count_and_writes_nothing(file, tmp_path):
    result = run(file, "--dry-run", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "6 cases, 12 flights" in result.output
    assert f"reference.phi_deg = {cases_of(file).values(0)['reference.phi_deg']:.6g}" in result.output
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(path.stem for path in (scenario_dir() / "campaigns").glob("*.yaml")))
def test_shipped_campaigns_can_be_flown(name):
    made = ready(load_campaign(name))
    prepare(Plan(made.variants, made.campaign.success, "none"))
    for place in range(len(made.variants)):
        assert evaluate(Job(0, place, made.cases.values(0)))["outcome"] != "error"


# --- wrong input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("seed: 7", "sed: 7", "line 3, key sed"),
        ("uniform: [1, 5]", "uniform: [5, 1]", "line 6, key vary.reference.phi_deg.uniform"),
        ("uniform: [1, 5]", "uniform: [1, 5], grid: [1]", "uniform and grid"),
        ("uniform: [1, 5]", "unifrom: [1, 5]", "did you mean uniform?"),
        ("uniform: [1, 5]", "normal: [1, 0]", "the second above 0"),
        ("reference.phi_deg", "reference.phi", "line 6, key reference.phi"),
        ("reference.phi_deg", "faults[3].effectiveness", "line 6, key faults[3].effectiveness"),
        ("reference.phi_deg", "duration_s", "whole number of"),
        ("reference.theta_deg", "reference", "line 7, key reference"),
        ("reference.theta_deg", "plant", "plants: [...]"),
        ("base: scenario1", "base: scenario0", "line 2, key base"),
        ("cases: 6", "cases: 0", "at least 1"),
        ("cases: 6", "design: grid", "grid or list, because design is grid"),
        ("ndi-l1,", "ndi-l7,", "ndi-l7"),
        ("ndi-l1,", "nndondi-mrac,", "a second time"),
        ("seed: 7", "success: {itaee: 1}", "did you mean itae?"),
        ("seed: 7", "histories: some", "none, failures, all, or worst: 10"),
    ],
)
def test_a_wrong_campaign_is_refused_with_its_line_and_nothing_is_written(file, tmp_path, old, new, said):
    file.write_text(FILE.replace(old, new, 1), encoding="utf-8")
    result = run(file, "--out", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert said in " ".join(result.output.split())
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_not_ours_is_left_alone(file, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "thesis.txt").write_text("mine", encoding="utf-8")
    for more in ((), ("--resume",)):
        assert run(file, "--out", out, *more).exit_code == 2
    assert [path.name for path in out.iterdir()] == ["thesis.txt"]


def test_a_campaign_that_is_not_there_names_the_shipped_ones():
    with pytest.raises(InputError, match="paper-faults"):
        load_campaign("paper-fault")


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("tcp://127.0.0.1:1", ("no scheduler there", "dask scheduler")),
        ("nonsense://", ("no scheduler there", "tcp://host:8786")),
    ],
)
def test_a_cluster_that_is_not_there_is_refused_and_nothing_is_written(file, tmp_path, monkeypatch, address, said):
    pytest.importorskip("distributed")
    from uavftc.jobs.campaign import cluster

    monkeypatch.setattr(cluster, "CONNECT_S", 0.5)
    result = run(file, "--cluster", address, "--out", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert all(text in " ".join(result.output.split()) for text in said)
    assert not (tmp_path / "out").exists()


def test_a_cluster_without_the_extra_is_refused_with_what_to_install(file, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "uavftc.jobs.campaign.cluster", raising=False)
    result = run(file, "--cluster", "tcp://127.0.0.1:1", "--out", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert 'pip install "uavftc[campaign]"' in " ".join(result.output.split())
    assert not (tmp_path / "out").exists()
