"""A campaign that ends when it knows enough: after cases that depend on the cases alone."""

from __future__ import annotations

import json

import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.stats import binomtest
from typer.testing import CliRunner

from in_process import InProcess
from uavftc.cli.app import umbrella
from uavftc.errors import InputError
from uavftc.jobs.campaign.narrow import Narrow, refuse_counted
from uavftc.jobs.campaign.sweep import Sweep, ready
from uavftc.scenario.campaign import load_campaign

FILE = """\
name: narrow
base: scenario1
seed: 3
cases: 30
vary:
  "reference.phi_deg": {uniform: [1, 8]}
controllers: [ndi-l1, nndondi-mrac]
plants: [analytic]
success: {itae: 0.34}
histories: failures
"""
WIDTH = 0.55


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "narrow.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


@pytest.fixture
def in_process(monkeypatch):
    monkeypatch.setattr("uavftc.jobs.campaign.sweep.engine_of", InProcess)


def content(folder):
    table = pq.read_table(folder / "flights.parquet")
    return table.select([name for name in table.column_names if not name.startswith("wall_")])


def scipy_width(k, n):
    interval = binomtest(k, n).proportion_ci(method="wilson")
    return interval.high - interval.low


def test_whatever_the_order_of_the_flights_the_campaign_ends_after_the_same_cases():
    rng = np.random.default_rng(1)
    success = rng.random((400, 2)) < [0.9, 0.5]
    enough = next(n for n in range(1, 401) if all(scipy_width(int(k), n) <= 0.2 for k in success[:n].sum(axis=0)))
    for order in (np.arange(800), rng.permutation(800), np.arange(800)[::-1]):
        narrow = Narrow(0.2, 400, 2)
        for flight in order:
            narrow.take(flight // 2, flight % 2, bool(success[flight // 2, flight % 2]))
        assert narrow.after == enough


def test_flights_that_could_not_be_flown_count_neither_way():
    narrow = Narrow(0.02, 1000, 1)
    for case in range(1000):
        narrow.take(case, 0, None if case < 100 else True)
    assert narrow.after == 289  # 189 successes, as the closed form has it
    nothing = Narrow(0.02, 50, 1)
    for case in range(50):
        nothing.take(case, 0, None)
    assert nothing.after is None


def test_what_is_kept_is_the_beginning_of_the_whole_in_any_order_and_after_an_interruption(file, tmp_path, in_process):
    begun_interrupted_and_ended(file, tmp_path)


@pytest.mark.slow
def test_what_is_kept_is_the_beginning_of_the_whole_for_any_workers(file, tmp_path):
    begun_interrupted_and_ended(file, tmp_path)


def begun_interrupted_and_ended(file, tmp_path):
    made = ready(load_campaign(file))
    Sweep(made, tmp_path / "whole").fly(workers=1)
    whole = content(tmp_path / "whole")
    success = np.array(whole["success"].to_pylist()).reshape(-1, 2)
    enough = next(n for n in range(1, 31) if all(scipy_width(int(k), n) <= WIDTH for k in success[:n].sum(axis=0)))
    assert 3 < enough < 30
    assert 0 < success[:enough].sum() < 2 * enough  # some of both, or nothing were shown

    def interrupted(done, total, failures):
        if done >= 6:
            raise KeyboardInterrupt

    for workers in (1, 2):
        out = tmp_path / str(workers)
        with pytest.raises(KeyboardInterrupt):
            Sweep(made, out, until_width=WIDTH).fly(workers=workers, progress=interrupted)
        with pytest.raises(InputError, match=r"until_width: was 0.55, is 0.5"):
            Sweep(made, out, until_width=0.5, resume=True).fly(workers=workers)
        summary = Sweep(made, out, until_width=WIDTH, resume=True).fly(workers=workers)
        assert (summary["cases"], summary["flights"], summary["narrow"]) == (enough, 2 * enough, True)
        assert content(out).equals(whole.slice(0, 2 * enough))
        failed = {
            f"{row['case']:06d}-{row['controller']}.parquet"
            for row in whole.slice(0, 2 * enough).to_pylist()
            if not row["success"]
        }
        assert {path.name for path in (out / "histories").iterdir()} == failed
        counts = {name: one["success"] for name, one in summary["controllers"].items()}
        assert list(counts.values()) == success[:enough].sum(axis=0).tolist()


def test_where_it_stays_wide_all_cases_are_flown_and_the_summary_says_so(file, tmp_path, in_process):
    arguments = ["sweep", file, "--until-width", "0.01", "--set", "cases=4", "--out", tmp_path / "out"]
    result = CliRunner().invoke(umbrella, list(map(str, arguments)))
    assert result.exit_code == 0, result.output
    assert "an interval of success is still wider than 0.01" in result.output
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert (summary["cases"], summary["narrow"], summary["until_width"]) == (4, False, 0.01)


def test_cases_that_are_counted_off_are_refused(file):
    file.write_text(FILE.replace("{uniform: [1, 8]}", "{grid: [1, 8]}"), encoding="utf-8")
    with pytest.raises(InputError, match="no sample of all"):
        refuse_counted(load_campaign(file))
