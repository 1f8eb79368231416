"""The search for what breaks a controller: distances in closed form, a planted corner, and what a search survives."""

from __future__ import annotations

import io
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import planted
import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from uavftc.cli.app import umbrella
from uavftc.errors import InputError
from uavftc.jobs.campaign.cases import Cases
from uavftc.jobs.campaign.evaluate import Job, Plan, evaluate, prepare
from uavftc.jobs.campaign.sweep import ready
from uavftc.jobs.falsify.job import STRAIN
from uavftc.jobs.falsify.nearest import Nearest
from uavftc.jobs.falsify.search import Search, Told
from uavftc.jobs.falsify.space import Space
from uavftc.scenario.campaign import load_campaign

FILE = """\
name: small
base: scenario3
seed: 7
cases: 6
vary:
  "faults[3].effectiveness": {uniform: [0, 1], nominal: 1}
  "faults[3].bias_deg": {uniform: [-3, 3], nominal: 0}
  "reference.phi_deg": {choice: [3, 5, 8]}
controllers: [nndondi-l1]
plants: [analytic]
"""


@pytest.fixture
def file(tmp_path):
    return written(tmp_path, FILE)


def written(folder, text):
    path = folder / "small.yaml"
    path.write_text(text, encoding="utf-8")
    return path


class Here:
    """An engine that flies in this process: what is tested is the search, and a pool takes seconds to start."""

    def __init__(self, plan):
        prepare(plan)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def fly(self, jobs):
        return map(evaluate, jobs)


@pytest.fixture
def here(monkeypatch):
    monkeypatch.setattr("uavftc.jobs.falsify.job.engine_of", lambda plan, **_: Here(plan))


def run(*arguments):
    return CliRunner().invoke(umbrella, ["falsify", *map(str, arguments)])


def trace_of(folder):
    return pq.read_table(io.BytesIO((folder / "search.parquet").read_bytes()))  # which may be replaced meanwhile


def content(folder):
    table = trace_of(folder)
    return table.select([name for name in table.column_names if not name.startswith("wall_")])


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def space_of(tmp_path, *lines, controllers=""):
    text = "name: space\nbase: scenario3\ncases: 2\nvary:\n" + "".join(f"  {line}\n" for line in lines) + controllers
    campaign = load_campaign(written(tmp_path, text))
    return Space(campaign, campaign.scenario(controller=None, plant="analytic", aircraft=None))


def searched(search, margin):
    """Let a search go over a margin that is a function of its values; return the margins and distances, in order."""
    batches, found = search.batches(), []
    asked = next(batches)
    while True:
        told = [margin(list(ask.values.values())) for ask in asked]
        found += zip(told, [ask.distance for ask in asked], strict=True)
        try:
            asked = batches.send([Told(m, m < 0) for m in told])
        except StopIteration:
            return found


# --- the space -----------------------------------------------------------------------------------------------------


def test_a_distance_is_counted_in_ranges_along_the_scale_of_each_key(tmp_path):
    space = space_of(
        tmp_path,
        '"faults[3].effectiveness": {uniform: [0.1, 0.9]}',  # the base has 0.3
        '"faults[3].start_s": {normal: [7, 0.5]}',  # 8: two of six deviations
        '"controller.inner.adaptation_gain": {log-uniform: [1.0e+3, 1.0e+7]}',  # 1e5: the middle
        '"reference.phi_deg": {choice: [3, 5, 8]}',  # 5
        '"plant": {choice: [1, 2]}'.replace("plant", "seed"),
    )
    values = {
        "faults[3].effectiveness": 0.7,
        "faults[3].start_s": 6.5,
        "controller.inner.adaptation_gain": 1e6,
        "reference.phi_deg": 8,
        "seed": 2,
    }
    parts = space.parts(values)
    expected = [0.5, -0.5, 0.25, 0.6, 2.0]  # seed 0 of the base is two values' distance from 2, in ranges of one
    assert list(parts.values()) == pytest.approx(expected, rel=1e-12)
    assert space.distance(values) == pytest.approx(math.sqrt(sum(p * p for p in expected)), rel=1e-12)
    assert space.nominal_values()["faults[3].start_s"] == 8


def test_nominal_is_what_the_file_says_or_the_base_has_or_the_middle(tmp_path):
    space = space_of(
        tmp_path,
        '"faults[3].effectiveness": {uniform: [0, 1], nominal: 1}',
        '"faults[1].effectiveness": {uniform: [0, 1]}',
        '"faults[4].effectiveness": {uniform: [0, 1]}',  # 0.2*t in the base
        '"sensors.gyro_bias_degps": {choice: [[1, 0, 0], [0, 1, 0]]}',  # none of them in the base: the first
    )
    assert list(space.nominal_values().values()) == [1, 0.7, 0.5, [1, 0, 0]]
    assert space.start() == pytest.approx([1.0, 0.7, 0.5, 0.25])
    away = {**space.nominal_values(), "sensors.gyro_bias_degps": [0, 1, 0]}
    assert space.distance(away) == 1.0


def test_lists_share_a_coordinate_and_counted_values_have_equal_parts(tmp_path):
    space = space_of(
        tmp_path,
        '"faults[3].effectiveness": {list: [0.3, 0.6, 0.9]}',
        '"reference.phi_deg": {grid: [2, 5]}',
        '"faults[1].effectiveness": {list: [0.7, 0.2, 0.1]}',
    )
    assert (space.dimension, space.finite) == (2, 6)
    assert list(space.values(np.array([0.5, 0.49])).values()) == [0.6, 2, 0.2]
    assert list(space.values(np.array([1.0, 1.0])).values()) == [0.9, 5, 0.1]


def test_a_normal_distribution_is_drawn_as_the_campaign_draws_and_searched_for_three_deviations(tmp_path):
    space = space_of(tmp_path, '"reference.phi_deg": {normal: [1, 2]}')
    (at_one,) = space.values(space.drawn(np.array([0.8413447460685429]))).values()  # the quantile of one deviation
    assert at_one == pytest.approx(3.0, abs=1e-9)
    assert [space.values(np.array([s]))["reference.phi_deg"] for s in (0.0, 1.0)] == pytest.approx([-5.0, 7.0])


# --- the searches, on margins in closed form ----------------------------------------------------------------------


def cube(tmp_path, dimension):
    """Return a space of so many keys on [-1/2, 1/2] with nominal 0."""
    keys = [f"faults[{i}].{name}" for i in range(5) for name in ("bias_deg", "effectiveness")][:dimension]
    return space_of(tmp_path, *(f'"{key}": {{uniform: [-0.5, 0.5], nominal: 0}}' for key in keys))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_nearest_failure_of_a_plane_is_its_foot(tmp_path, seed):
    w = np.array([0.9, -0.7, 0.5, 0.0, 0.3, -0.1, 0.0, 0.2])
    far = 0.55  # of the plane from nominal
    found = searched(
        Nearest(cube(tmp_path, 8), 300, seed), lambda x: far * float(np.linalg.norm(w)) - float(w @ np.array(x))
    )
    failures = [distance for margin, distance in found if margin < 0]
    # the foot is far w/|w|, whose largest component 0.38 is inside the cube; a step must gain 1 % of its distance
    assert far <= min(failures) < 1.02 * far
    assert len(found) == 300


def test_the_nearest_failure_is_looked_for_in_more_than_one_place(tmp_path):
    # two corners that are apart; the smaller one is nearer
    def margin(x):
        a, b = np.array(x[:4]), np.array(x[4:])
        return min(0.8 - float(np.sum(np.maximum(a, 0.0))), 0.9 - 2.0 * float(np.sum(np.maximum(-b, 0.0))))

    for seed in (1, 2, 3):
        failures = [far for m, far in searched(Nearest(cube(tmp_path, 8), 500, seed), margin) if m < 0]
        assert min(failures) < 1.05 * 0.9 / 4  # each of four b at 0.1125: 0.225 away; the other corner is 0.4 away


def test_the_lowest_margin_is_found_at_the_corner_of_the_cube(tmp_path):
    w = np.array([0.3, -0.2, 0.1, 0.4, -0.1, 0.2, 0.3, -0.4])
    found = searched(Search(cube(tmp_path, 8), 400, 1), lambda x: 0.9 - float(w @ np.array(x)))
    assert min(margin for margin, _ in found) < 0.9 - 0.5 * float(np.abs(w).sum()) + 0.01  # each x at 1/2 or -1/2


def test_a_space_of_few_values_is_flown_once_each_and_then_the_search_ends(tmp_path):
    space = space_of(tmp_path, '"reference.phi_deg": {choice: [1, 2, 3]}', '"reference.psi_deg": {grid: [4, 5]}')
    for kind in (Search, Nearest):
        search = kind(space, 500, 1)
        assert len(searched(search, lambda x: 1.0)) == 6
        assert len({repr(values) for values in search.flown}) == 6


def test_a_nominal_that_fails_is_its_own_nearest_failure(tmp_path):
    search = Nearest(cube(tmp_path, 3), 500, 1)
    found = searched(search, lambda x: -0.5)
    assert found[0] == (-0.5, 0.0)
    assert search.runs == 0


def test_a_search_leaves_numpys_own_random_numbers_alone_and_does_not_depend_on_them(tmp_path):
    results = []
    for seed in (0, 1):
        np.random.seed(seed)  # noqa: NPY002
        before = np.random.get_state()[1].tolist()  # noqa: NPY002
        results.append(searched(Nearest(cube(tmp_path, 5), 150, 4), lambda x: 0.4 - float(x[0])))
        assert np.random.get_state()[1].tolist() == before  # noqa: NPY002
    assert results[0] == results[1]


def test_a_flight_that_could_not_be_flown_is_no_failure(tmp_path):
    search = Search(cube(tmp_path, 3), 60, 1)
    batches = search.batches()
    asked = next(batches)
    while True:
        try:
            asked = batches.send([Told(None, False)] * len(asked))
        except StopIteration:
            break
    assert len(search.flown) == 60


# --- the planted corner -------------------------------------------------------------------------------------------


def planted_campaign(folder, seed=0):
    text = planted.SCENARIO.format(controller=Path(planted.__file__).as_posix())
    (folder / "planted.yaml").write_text(text, encoding="utf-8")
    return written(folder, planted.CAMPAIGN.format(seed=seed))


def flown(values, number=0):
    return evaluate(Job(number, 0, values))


def first_failure(made, search):
    """Return how many flights a search takes to its first failure; None where it finds none."""
    batches = search.batches()
    asked, before = next(batches), 0
    while True:
        rows = [flown(ask.values, before + i) for i, ask in enumerate(asked)]
        for i, row in enumerate(rows):
            if row["outcome"] == "degraded":
                return before + i + 1
        before += len(rows)
        try:
            asked = batches.send([Told(row["margin"], False, sum(row[name] for name in STRAIN)) for row in rows])
        except StopIteration:
            return None


def test_the_planted_corner_is_a_thousandth_of_the_space_and_the_margin_is_its_height(tmp_path):
    points = np.random.default_rng(3).random((1_000_000, planted.DIMENSION))
    # 1,000 of a million, to three standard deviations of a count
    assert abs(int((planted.height(points) < 0.0).sum()) - 1000) < 3 * math.sqrt(1000)
    made = ready(load_campaign(planted_campaign(tmp_path)))
    prepare(Plan(made.variants, None, "none"))
    for t in (0.35, 0.7, 0.9):
        x = np.array([t, *planted.ridge(t)])
        height = float(planted.height(x))
        row = flown({f"controller.options.x{i + 1}": float(v) for i, v in enumerate(x)})
        expected = height if height >= 0.0 else height / (1.0 - height)
        assert row["margin"] == pytest.approx(expected, abs=1e-4)


def test_the_planted_corner_is_found(tmp_path):
    made = ready(load_campaign(planted_campaign(tmp_path)))
    prepare(Plan(made.variants, None, "none"))
    search = Search(Space(made.campaign, made.variants[0].scenario), planted.BUDGET, 0)
    assert first_failure(made, search) is not None


@pytest.mark.slow
def test_the_planted_corner_is_found_in_nine_of_ten_searches_and_by_sobol_points_in_at_most_half(tmp_path):
    found, by_points = 0, 0
    for seed in range(10):
        made = ready(load_campaign(planted_campaign(tmp_path, seed)))
        prepare(Plan(made.variants, None, "none"))
        search = Search(Space(made.campaign, made.variants[0].scenario), planted.BUDGET, seed)
        found += first_failure(made, search) is not None
        cases = Cases(made.campaign)
        by_points += any(flown(cases.values(i), i)["outcome"] == "degraded" for i in range(planted.BUDGET))
    assert found >= 9
    assert by_points <= 5


# --- the command ---------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_what_was_found_flies_alone_to_the_same_margin_to_the_bit(file, tmp_path, plant):
    out, alone = tmp_path / "out", tmp_path / "alone"
    options = ["--set", f"plants=[{plant}]", "--budget", 24, "--workers", 1, "--no-plots"]
    result = run(file, *options, "--out", out)
    assert result.exit_code == 0, result.output
    found = summary_of(out)["found"]
    assert found["outcome"] == "degraded"
    flight = CliRunner().invoke(
        umbrella, ["fly", str(out / "found.yaml"), "--out", str(alone), "--no-plots", "--quiet"]
    )
    assert flight.exit_code == 0, flight.output
    assert summary_of(alone)["verdict"]["margin"] == found["margin"]
    rows = content(out).to_pylist()
    assert found["margin"] == min(row["margin"] for row in rows)
    assert "warning" not in result.output


@pytest.mark.slow
def test_the_trace_does_not_depend_on_the_workers(file, tmp_path):
    for workers in (1, 2):
        out = tmp_path / str(workers)
        options = ["--objective", "nearest", "--budget", 60, "--seed", 3, "--workers", workers, "--quiet"]
        assert run(file, *options, "--out", out).exit_code == 0
    one, two = content(tmp_path / "1"), content(tmp_path / "2")
    assert one.equals(two)
    assert one["flight"].to_pylist() == list(range(60))
    found = summary_of(tmp_path / "1")["found"]
    assert found["distance"] == min(row["distance"] for row in one.to_pylist() if row["outcome"] == "degraded")
    assert (tmp_path / "1" / "figures" / "falsify.png").is_file()
    assert set(summary_of(tmp_path / "1")["files"]) == {
        "campaign.json",
        "figures/falsify.png",
        "found.yaml",
        "search.parquet",
    }


@pytest.mark.slow
def test_a_search_that_was_killed_is_gone_on_with_and_its_trace_is_that_of_an_undisturbed_one(file, tmp_path):
    options = ["--budget", "70", "--workers", "1", "--no-plots", "--quiet"]
    assert run(file, *options, "--out", tmp_path / "whole").exit_code == 0
    out = tmp_path / "out"
    code = "import uavftc.jobs.falsify.trace as t; t.EVERY_S = t.SPARED = 0; from uavftc.cli.entry import main; main()"
    command = [sys.executable, "-c", code, "falsify", str(file), *options, "--out", str(out)]
    process = subprocess.Popen(command, start_new_session=True)
    deadline = time.monotonic() + 120.0
    try:
        while not (out / "search.parquet").exists() or len(content(out)) < 20:
            assert process.poll() is None, "it ended by itself"
            assert time.monotonic() < deadline
            time.sleep(0.05)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    kept = trace_of(out)
    assert 20 <= len(kept) < 70
    refused = run(file, *options, "--out", out)
    assert (refused.exit_code, "unfinished" in refused.output) == (2, True)
    other = run(file, *options[2:], "--budget", "80", "--out", out, "--resume")
    assert (other.exit_code, "budget" in other.output) == (2, True)
    assert run(file, *options, "--out", out, "--resume").exit_code == 0
    assert content(out).equals(content(tmp_path / "whole"))
    again = trace_of(out).slice(0, len(kept))
    assert again["wall_s"].equals(kept["wall_s"])  # these were not flown again
    assert summary_of(out)["found"] == summary_of(tmp_path / "whole")["found"]


@pytest.mark.usefixtures("here")
def test_it_says_plainly_when_nothing_was_found_and_how_much_was_searched(file, tmp_path):
    out = tmp_path / "out"
    text = FILE.replace("[0, 1], nominal: 1", "[0.9, 1], nominal: 1").replace("[-3, 3]", "[-0.1, 0.1]")
    file.write_text(text, encoding="utf-8")
    result = run(file, "--budget", 24, "--workers", 1, "--out", out, "--no-plots")
    assert result.exit_code == 0, result.output
    told = " ".join(result.output.split())
    assert (
        "nothing was found that breaks it in 24 flights: 17 over the whole ranges, the rest in 1 run of CMA-ES" in told
    )
    # the rule of three: 1 - 0.05^(1/17) of the ranges could fail unseen by 17 independent points
    assert "by the 17 points alone up to 16 % of the ranges may fail" in told
    assert not (out / "found.yaml").exists()
    summary = summary_of(out)
    assert summary["found"] is None
    assert summary["searches"][0]["file"] == "lowest-nndondi-l1.yaml"
    assert (out / "lowest-nndondi-l1.yaml").is_file()


@pytest.mark.usefixtures("here")
def test_each_controller_is_searched_with_the_whole_budget_and_one_can_be_named(file, tmp_path):
    both, one = tmp_path / "both", tmp_path / "one"
    options = [
        "--set",
        "controllers=[nndondi-mrac, nndondi-l1]",
        "--budget",
        20,
        "--workers",
        1,
        "--no-plots",
        "--quiet",
    ]
    assert run(file, *options, "--out", both).exit_code == 0
    assert run(file, *options, "--controller", "nndondi-mrac", "--out", one).exit_code == 0
    table = content(both)
    assert table["controller"].to_pylist() == ["nndondi-l1"] * 20 + ["nndondi-mrac"] * 20
    assert table.slice(20).equals(content(one))
    summary = summary_of(both)
    assert {"found.yaml", "found-nndondi-l1.yaml", "found-nndondi-mrac.yaml"} <= set(summary["files"])
    assert summary["found"]["margin"] == min(table["margin"].to_pylist())


@pytest.mark.parametrize(
    ("change", "options", "said"),
    [
        (("vary:", "other:"), [], "other"),
        (('"reference.phi_deg": {choice: [3, 5, 8]}', '"reference.phy_deg": {choice: [3]}'), [], "phy_deg"),
        (("nominal: 0", "nominal: none"), [], "nominal"),
        (("nominal: 0", "nominal: 0, grid: [1]"), [], "exactly one"),
        (None, ["--controller", "nobody"], "nobody"),
        (None, ["--budget", "0"], "budget"),
        (None, ["--objective", "worst"], "objective"),
        (None, ["--resume"], "campaign.json"),
    ],
)
def test_wrong_input_ends_with_exit_code_2_and_nothing_is_written(file, tmp_path, change, options, said):
    if change is not None:
        file.write_text(FILE.replace(*change), encoding="utf-8")
    result = run(file, *options, "--out", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert said in result.output
    assert os.listdir(tmp_path) == ["small.yaml"]


def test_a_campaign_in_which_nothing_varies_is_refused(tmp_path):
    with pytest.raises(InputError, match="nothing that varies"):
        space_of(tmp_path, "{}")


def test_without_the_package_cma_the_message_says_how_to_install_it(file, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "cma", None)
    result = run(file, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "uavftc[falsify]" in result.output
    assert not (tmp_path / "out").exists()
