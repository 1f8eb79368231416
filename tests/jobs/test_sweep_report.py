"""The report of a campaign: its numbers against counts and scipy, and every campaign that has little to say."""

from __future__ import annotations

import itertools
import json
import shlex
import shutil
import subprocess

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from PIL import Image
from scipy.stats import binomtest, ks_2samp
from typer.testing import CliRunner

import uavftc
from in_process import InProcess
from uavftc.cli.app import single, umbrella
from uavftc.errors import InputError
from uavftc.jobs.campaign.cases import Cases
from uavftc.jobs.campaign.identity import identity
from uavftc.jobs.campaign.sweep import Sweep, ready
from uavftc.jobs.campaign.table import as_cell, schema_of, write
from uavftc.jobs.campaign.variants import variants_of
from uavftc.jobs.sweep_report.compare import interval, pairs, spread
from uavftc.jobs.sweep_report.influence import index, influence, order
from uavftc.jobs.sweep_report.job import sweep_report
from uavftc.report.campaign_map import axis_of, near, plain
from uavftc.report.campaign_text import folded, percent
from uavftc.scenario.campaign import load_campaign

BASE = """\
name: short
duration_s: 4
plant: analytic
reference: {phi_deg: 5, theta_deg: 2, psi_deg: 0}
faults: [{surface: aileron, start_s: 0.5, effectiveness: 0.5}]
"""
FILE = """\
name: small
base: short.yaml
seed: 7
cases: 24
vary:
  "faults[0].effectiveness": {uniform: [0.02, 1]}
  "faults[0].bias_deg": {choice: [0, "0.5*sin(3*t) + 1", "1.5"]}
  "reference.phi_deg": {normal: [4, 0.5]}
controllers: [ndi-l1, pid]
success: {iae: 0.11}
"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A campaign that was flown, with a space and a quote in the name of its folder."""
    folder = tmp_path_factory.mktemp("it's a campaign")
    (folder / "short.yaml").write_text(BASE, encoding="utf-8")
    (folder / "small.yaml").write_text(FILE, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("uavftc.jobs.campaign.sweep.engine_of", InProcess)
        Sweep(ready(load_campaign(folder / "small.yaml")), folder / "out").fly(workers=1)
    return folder / "out"


def run(*arguments):
    return CliRunner().invoke(umbrella, ["sweep-report", *map(str, arguments)])


def made(folder, text, outcome, *, finished=True, cases=None):
    """Write the folder of a campaign without flying it; `outcome` gives success and margin of values and controller."""
    folder.mkdir()
    (folder / "short.yaml").write_text(BASE, encoding="utf-8")
    (folder / "made.yaml").write_text(text, encoding="utf-8")
    campaign = load_campaign(folder / "made.yaml")
    variants, out = variants_of(campaign), folder / "out"
    rows = []
    for case, values in enumerate(Cases(campaign)):
        for variant in variants:
            success, margin = outcome(values, variant.controller)
            said = "error" if success is None else "survived" if margin >= 0 else "degraded"
            given = {"success": success, "margin": margin, "outcome": said, "limiting": "tracking", "roll_iae": margin}
            rows.append({"case": case, "controller": variant.controller, **values, **given})
    schema = schema_of(campaign)
    cells = [{field.name: as_cell(row.get(field.name), field.type) for field in schema} for row in rows]
    table = pa.Table.from_pylist(cells[:cases], schema=schema)
    out.mkdir()
    (out / "campaign.json").write_text(json.dumps(identity(campaign, variants)), encoding="utf-8")
    if finished:
        write(out / "flights.parquet", [table], schema)
        summary = {"provenance": {"uavftc": uavftc.__version__}, "files": {}}
        (out / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    else:
        order = np.random.default_rng(2).permutation(len(table))  # flights end in any order
        write(out / "parts" / "part-000001.parquet", [table.take(order[::2])], schema)
        write(out / "parts" / "part-000002.parquet", [table.take(order[1::2])], schema)
    return out


# --- a campaign that was flown -------------------------------------------------------------------------------------


def test_shares_pairs_and_spreads_are_those_counted_from_the_table(flown):
    _, document = sweep_report(flown)
    table = pq.read_table(flown / "flights.parquet").to_pylist()
    by = {name: [row for row in table if row["controller"] == name] for name in ("ndi-l1", "pid")}
    for one in document["variants"]:
        k, n = sum(row["success"] for row in by[one["name"]]), len(by[one["name"]])
        theirs = binomtest(k, n).proportion_ci(method="wilson")
        assert (one["successes"], one["flights"]) == (k, n)
        assert one["interval"] == pytest.approx([theirs.low, theirs.high], abs=1e-12)
    (pair,) = document["pairs"]
    both = [(a["success"], b["success"]) for a, b in zip(by["ndi-l1"], by["pid"], strict=True)]
    counted = [both.count(one) for one in ((True, True), (True, False), (False, True), (False, False))]
    assert [pair[key] for key in ("both", "only_first", "only_second", "neither")] == counted
    assert 0 < pair["only_second"] + pair["only_first"] < 24
    assert pair["p"] == binomtest(pair["only_first"], pair["only_first"] + pair["only_second"]).pvalue
    d = [a["margin"] - b["margin"] for a, b in zip(by["ndi-l1"], by["pid"], strict=True)]
    assert pair["margin"]["mean"] == pytest.approx(np.mean(d), rel=1e-12)
    assert pair["margin"]["median"] == pytest.approx(np.median(d), rel=1e-12)
    assert pair["margin"]["mean_interval"][0] < np.mean(d) < pair["margin"]["mean_interval"][1]
    metric = next(one for one in document["metrics"] if (one["axis"], one["name"]) == ("pitch", "itae"))
    theirs = np.quantile([row["pitch_itae"] for row in by["pid"]], 0.95)
    assert metric["variants"]["pid"]["p95"] == pytest.approx(theirs, rel=1e-12)


def test_the_same_table_gives_the_same_report(flown):
    assert json.dumps(sweep_report(flown)[1]) == json.dumps(sweep_report(flown)[1])


def words_of(command):
    """Return the words that a shell makes of a command."""
    said = subprocess.run(["sh", "-c", f"printf '%s\\0' {command}"], capture_output=True, check=True).stdout
    return said.decode().split("\0")[:-1]


def margin_of(words, out):
    result = CliRunner().invoke(single, [*words[1:], "--out", str(out), "--no-plots", "--quiet"])
    assert result.exit_code in (0, 3), result.output
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))["verdict"]["margin"]


def test_the_commands_fly_the_worst_cases_again_to_the_bit(flown, tmp_path):
    result = run(flown, "--no-plots", "--json", "--quiet")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    table = pq.read_table(flown / "flights.parquet").to_pylist()
    smallest = sorted({min(r["margin"] for r in table if r["case"] == case) for case in range(24)})[:10]
    assert [one["margin"] for one in document["worst"]] == smallest
    text = next(one for of in document["worst_of"].values() for one in of if "sin" in one["command_with_values"])
    for i, one in enumerate([*document["worst"][:2], text]):  # a text has brackets and a star, which a shell knows too
        for kind in ("command", "command_with_values"):
            words = words_of(one[kind])
            assert words == shlex.split(one[kind])
            assert margin_of(words, tmp_path / f"{kind}-{i}") == one["margin"]
        assert words_of("\n".join(folded(one["command_with_values"]))) == words


def test_the_folder_is_ours_with_its_report_and_a_new_campaign_replaces_both(flown, tmp_path, monkeypatch):
    for _ in range(2):  # again, over the first
        result = run(flown, "--no-plots")
        assert result.exit_code == 0, result.output
    shown = [line for line in result.stdout.splitlines() if "report" not in line]  # a path is as long as it is
    assert max(map(len, shown)) <= 80
    assert "ndi-l1" in (flown / "report" / "report.md").read_text(encoding="utf-8")
    monkeypatch.setattr("uavftc.jobs.campaign.sweep.engine_of", InProcess)
    monkeypatch.chdir(tmp_path)
    shutil.copytree(flown.parent, tmp_path / "copy")
    made = ready(load_campaign(tmp_path / "copy" / "small.yaml", ["cases=1"]))
    assert Sweep(made, tmp_path / "copy" / "out").fly(workers=1)["flights"] == 2
    assert not (tmp_path / "copy" / "out" / "report").exists()


@pytest.mark.slow
def test_every_figure_is_drawn_and_stands_on_the_page(flown, tmp_path):
    axes = "faults[0].bias_deg, reference.phi_deg"
    result = run(flown, "--map", axes, "--out", tmp_path / "r", "--json", "--quiet")
    assert json.loads(result.stdout)["map"] == axes.split(", ")
    drawn = {path.name for path in (tmp_path / "r" / "figures").iterdir()}
    assert drawn >= {"success.png", "margins.png", "metrics.png", "map.png"}
    page = (tmp_path / "r" / "report.md").read_text(encoding="utf-8")
    assert all(f"(figures/{name})" in page for name in drawn)
    for path in (tmp_path / "r" / "figures").iterdir():
        with Image.open(path) as image:
            assert min(image.size) > 300


# --- what matters --------------------------------------------------------------------------------------------------


def test_what_matters_is_found_and_what_does_not_is_not():
    pytest.importorskip("SALib")
    rng = np.random.default_rng(4)
    inputs = {name: (rng.random(800), None) for name in ("strong", "weak", "nothing")}
    inputs["kind"] = rng.integers(0, 3, 800).astype(float), ["a", "b", "c"]
    inputs["idle"] = rng.integers(0, 3, 800).astype(float), ["a", "b", "c"]
    inputs["same"] = np.ones(800), None
    margin = -inputs["strong"][0] + 0.3 * inputs["weak"][0] + 0.4 * (inputs["kind"][0] == 1)
    margin[:20] = np.nan
    found = influence(inputs, margin, seed=1)
    above = {key for key, one in found.items() if one["index"] > one["chance"]}
    assert above == {"strong", "weak", "kind"}
    assert found["strong"]["rank_correlation"] < -0.8 < 0 < found["weak"]["rank_correlation"]
    assert found["kind"]["rank_correlation"] is None
    assert order([found], list(inputs))[:2] == ["strong", "kind"]
    assert influence(inputs, margin, seed=1) == found


def test_the_index_is_the_median_distance_between_slices_and_the_whole():
    pytest.importorskip("SALib")
    rng = np.random.default_rng(5)
    x = rng.random(500)
    y = x**2 + 0.1 * rng.random(500)
    edges = np.quantile(x, np.linspace(0.0, 1.0, 11))
    slices = [y[(x >= a) & (x < b)] for a, b in itertools.pairwise(edges)]
    assert index(x, y, sliced=False) == pytest.approx(np.median([ks_2samp(s, y).statistic for s in slices]), rel=1e-9)
    two = np.array([0.0, 1.0] * 50)  # a value that decides all: half of the margins on either side of the other half
    assert index(two, two, sliced=True) == pytest.approx(0.5, abs=1e-12)


def test_without_salib_inputs_are_ranked_by_correlation(tmp_path, monkeypatch):
    monkeypatch.setattr("uavftc.jobs.sweep_report.influence.has_salib", lambda: False)
    folder = made(tmp_path / "a", FILE.replace("24", "60"), lambda v, c: (True, v["reference.phi_deg"] - 4))
    result = run(folder, "--no-plots")
    assert result.exit_code == 0, result.output
    assert "SALib is not installed" in result.stdout
    assert "+1.00" in result.stdout


# --- the map -------------------------------------------------------------------------------------------------------


def test_the_boundary_of_a_slope_is_where_the_margin_is_0():
    rng = np.random.default_rng(6)
    a, b = rng.random((2, 40_000))
    x, y = axis_of("a", a, None, "uniform"), axis_of("b", b, None, "uniform")
    mean = near(x, y, a + b - 1.0)
    inside = slice(15, -15)  # a mean over both sides needs both sides
    expected = x.middles[None, inside] + y.middles[inside, None] - 1.0
    assert np.abs(mean[inside, inside] - expected).max() < 0.03


def test_values_that_stand_alone_are_not_mixed():
    x = axis_of("kind", np.array([0.0, 0.0, 1.0, 1.0]), ["stuck", "float"], "choice")
    y = axis_of("speed", np.array([30.0, 40.0, 30.0, 40.0]), None, "grid")
    assert (x.labels, y.labels) == (["stuck", "float"], ["30", "40"])
    assert near(x, y, np.array([0.1, 0.2, 0.3, np.nan])) == pytest.approx(
        np.array([[0.1, 0.3], [0.2, np.nan]]), nan_ok=True
    )


def test_a_section_is_named_in_plain_words():
    assert plain('{"kind": "stuck", "surface": "rudder", "at_deg": 2}') == "stuck rudder, at_deg 2"
    assert plain('[{"kind": "loss", "engine": 1}]') == "loss engine 1"
    assert plain("0.5*sin(3*t) + 1") == "0.5*sin(3*t) + 1"


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ("faults[0].effectivenes,reference.phi_deg", "did you mean faults[0].effectiveness?"),
        ("reference.phi_deg", "1 key(s)"),
        ("reference.phi_deg,reference.phi_deg", "1 key(s)"),
        ("reference.phi_deg,duration_s", "duration_s, which does not vary"),
    ],
)
def test_a_map_over_what_does_not_vary_is_refused(flown, asked, said):
    result = run(flown, "--map", asked)
    assert result.exit_code == 2
    assert said in " ".join(result.output.split())


def test_panels_of_the_map_say_where_there_is_no_boundary(flown):
    from uavftc.report.campaign_map import map_figure

    read, document = sweep_report(flown, "reference.phi_deg,faults[0].bias_deg")
    margin = np.stack([read.input("reference.phi_deg")[0] - 4.0, np.ones(24)], axis=1)
    inputs = {key: read.input(key) for key in document["map"]}
    figure = map_figure(document, margin, inputs, {"reference.phi_deg": "normal", "faults[0].bias_deg": "choice"})
    assert [ax.get_title() for ax in figure.axes[:2]] == ["ndi-l1", "pid: no boundary"]
    assert figure.axes[0].get_xlabel() == "reference.phi_deg"
    assert {text.get_text() for text in figure.axes[0].get_yticklabels()} == {"0", "0.5*sin(3*t) + 1", "1.5"}


# --- campaigns with little to say ----------------------------------------------------------------------------------


def test_a_folder_that_is_no_campaign_is_refused(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    (tmp_path / "other").mkdir()
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "campaign.json").write_text("{}", encoding="utf-8")
    for name, said in (
        ("nothing", "no such folder"),
        ("file", "a file"),
        ("other", "no campaign.json in it"),
        ("broken", "something else than uavftc sweep writes there"),
    ):
        result = run(tmp_path / name)
        assert result.exit_code == 2
        assert said in " ".join(result.output.split())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["broken", "file", "other"]


def test_of_an_unfinished_campaign_the_whole_cases_count_and_nothing_is_written(tmp_path):
    def outcome(values, controller):
        return values["reference.phi_deg"] > 4, values["reference.phi_deg"] - 4

    whole = sweep_report(made(tmp_path / "whole", FILE, outcome))[1]
    folder = made(tmp_path / "some", FILE, outcome, finished=False, cases=31)  # 15 cases and a half
    (folder / "parts" / "part-000003.parquet").write_bytes(b"PAR1")
    before = sorted(path.name for path in folder.rglob("*"))
    result = run(folder, "--json")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert (document["cases"], document["finished"]) == (15, False)
    assert "not finished: 15 of 24 cases" in " ".join(result.stderr.split())
    assert "1 torn part(s)" in result.stderr
    assert sorted(path.name for path in folder.rglob("*")) == before
    there = [Cases(load_campaign(tmp_path / "some" / "made.yaml")).values(i)["reference.phi_deg"] for i in range(15)]
    assert document["variants"][1]["successes"] == sum(phi > 4 for phi in there)
    assert whole["cases"] == 24
    (folder / "parts" / "part-000001.parquet").unlink()
    (folder / "parts" / "part-000002.parquet").unlink()
    assert "nothing was flown yet" in run(folder).output


def test_a_campaign_with_errors_alone_says_so(tmp_path):
    folder = made(tmp_path / "a", FILE, lambda v, c: (None, None))
    result = run(folder)
    assert result.exit_code == 0, result.output
    assert "all of 24 flights could not be flown" in " ".join(result.stdout.split())
    document = json.loads((folder / "report" / "summary.json").read_text(encoding="utf-8"))
    assert [one["success"] for one in document["variants"]] == [None, None]
    assert [one["interval"] for one in document["variants"]] == [[0.0, 1.0]] * 2
    assert document["worst"] == []


def test_one_controller_that_always_succeeds_with_one_input(tmp_path):
    text = FILE.replace("[ndi-l1, pid]", "[pid]").replace("normal: [4, 0.5]", "choice: [4]")
    text = text.replace('  "faults[0].bias_deg": {choice: [0, "0.5*sin(3*t) + 1", "1.5"]}\n', "")
    folder = made(tmp_path / "a", text, lambda v, c: (True, 0.5))
    result = run(folder)
    assert result.exit_code == 0, result.output
    said = " ".join(result.stdout.split())
    assert "one controller: there is nothing to compare" in said
    assert "the same in all cases, and so without influence: reference.phi_deg" in said
    assert "one key varies: there is no map" in said
    assert "how rare a failure may still be" in said
    assert "no sensitivity" in said
    document = json.loads((folder / "report" / "summary.json").read_text(encoding="utf-8"))
    assert document["variants"][0]["interval"][0] == pytest.approx(24 / (24 + 1.959963984540054**2), rel=1e-12)
    assert (document["pairs"], document["map"]) == ([], None)


def test_a_table_that_is_torn_is_refused(tmp_path):
    folder = made(tmp_path / "a", FILE, lambda v, c: (True, 0.5))
    (folder / "flights.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match="a table that cannot be read"):
        sweep_report(folder)


# --- small things --------------------------------------------------------------------------------------------------


def test_pairs_differ_in_one_thing_and_p_values_count_them():
    variants = [("a", "jsbsim", "hale"), ("b", "jsbsim", "hale"), ("a", "analytic", "hale"), ("b", "analytic", "hale")]
    success = np.array([[1.0, 0.0, 1.0, 1.0]] * 10)
    found = pairs(variants, ["a1", "b1", "a2", "b2"], success, np.zeros((10, 4)), seed=0)
    assert [(one["first"], one["second"]) for one in found] == [("a1", "b1"), ("a1", "a2"), ("b1", "b2"), ("a2", "b2")]
    assert found[0]["p"] == pytest.approx(2.0**-9, rel=1e-12)  # ten coins that fall alike
    assert found[0]["p_adjusted"] == pytest.approx(4 * 2.0**-9, rel=1e-12)


def test_the_bootstrap_interval_of_a_mean_is_that_of_the_normal_distribution():
    d = np.random.default_rng(8).normal(0.3, 2.0, 4000)
    low, high = interval(d, np.mean, np.random.default_rng(9))
    half = 1.96 * d.std() / np.sqrt(4000)
    assert [low, high] == pytest.approx([d.mean() - half, d.mean() + half], abs=0.15 * half)


def test_what_is_not_there_is_no_number():
    assert spread(np.array([np.nan, np.nan]))["median"] is None
    assert spread(np.array([1.0, np.nan, 3.0]))["median"] == 2.0
    assert percent(0.99999) == "99.999"
    assert percent(1.0) == "100.0"
