"""Section 4 flown again, from the flights up: scores, claims, findings, and the folder."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from uavftc.analysis.metrics import INTEGRALS
from uavftc.errors import InputError
from uavftc.jobs.paper import plan, printed
from uavftc.jobs.paper.findings import scores_by_scale
from uavftc.jobs.paper.reproduction import Reproduction, reproduce
from uavftc.jobs.paper.tables import BEST

PLANTS = ("analytic", "jsbsim")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("reproduction") / "out"


@pytest.fixture(scope="module")
def result(folder: Path) -> Reproduction:
    return reproduce(PLANTS, folder, figures=False, advance=lambda done, total, label: None)


def test_every_printed_number_appears_next_to_ours_on_both_plants(result: Reproduction, folder: Path) -> None:
    rows = json.loads((folder / "reproduce.json").read_text(encoding="utf-8"))
    assert len(rows) == 2 * len(printed.tables())
    named = ["table", "scenario", "controller", "saturation", "plant", "axis", "metric"]
    assert list(rows[0]) == [*named, "printed", "ours"]
    for plant in PLANTS:
        mine = [r for r in rows if r["plant"] == plant]
        keys = ("table", "scenario", "controller", "saturation", "axis", "metric")
        for row, p in zip(mine, printed.tables(), strict=True):
            assert tuple(row[k] for k in keys) == (p.table, p.scenario, p.controller, p.saturation, p.axis, p.metric)
            assert row["printed"] == p.value
            assert row["metric"] == "convergence_time_s" or row["ours"] > 0.0
    with (folder / "tables.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(rows)
    page = (folder / "reproduction.md").read_text(encoding="utf-8")
    for number in (2, 3, 4, 5, 6):
        assert f"## Table {number}." in page


@pytest.mark.parametrize("plant", PLANTS)
def test_the_scores_meet_their_bars(result: Reproduction, plant: str) -> None:
    literal, fit = result.scores[plant].values()
    assert literal["all"] <= 0.20  # units as printed
    assert fit["all"] <= 0.12  # with the one scale that was searched, and is labelled a fit
    assert any(label.startswith("a fit:") for label in result.scores[plant])


@pytest.mark.parametrize("plant", PLANTS)
def test_the_fit_is_the_best_of_its_neighbourhood(result: Reproduction, plant: str) -> None:
    scores = {s: v[0] for s, v in scores_by_scale(result.flights, plant).items()}
    best = min(scores, key=lambda s: scores[s])
    assert plan.COARSE[0] < best < plan.COARSE[-1]
    for neighbour in (best - plan.FINE_STEP, best + plan.FINE_STEP):
        assert scores[round(neighbour, 4)] >= scores[best]


@pytest.mark.parametrize("plant", PLANTS)
def test_the_observer_is_idle_and_ndi_l1_is_tied_everywhere(result: Reproduction, plant: str) -> None:
    claims = [c for c in result.claims[plant] if c.improvement.over == "ndi-l1"]
    assert len(claims) == 24
    assert {c.answer for c in claims} == {"tied; confirmed only with a gyro bias of 0.3 deg/s"}


def test_each_finding_has_numbers_and_a_command(result: Reproduction) -> None:
    assert len(result.findings) == 2 * 7
    for finding in result.findings:
        assert finding.rows
        assert finding.command.startswith(("uavftc ", "uavftc-fly "))
        assert "nan" not in finding.statement
        assert all(len(row) == len(finding.header) for row in finding.rows)


@pytest.mark.parametrize("plant", PLANTS)
def test_mrac_works_the_surfaces_and_l1_does_not(result: Reproduction, plant: str) -> None:
    flown = plan.of_variant(result.flights, plant, "delay", 10.0)
    l1, mrac = (
        max(v["control_activity_rad"] or np.inf for v in flown["scenario2", c].axes.values())
        for c in (plan.L1, plan.MRAC)
    )
    assert l1 < 0.3
    assert mrac > 50.0


@pytest.mark.parametrize("plant", PLANTS)
def test_the_artefact_is_claimed_for_the_axes_it_meets_and_no_other(result: Reproduction, plant: str) -> None:
    # Table 3, MRAC under explicit Euler: yaw's ITAE is printed as 1.129 and comes out below half; the L1 flight under
    # the same step ends tens of degrees off, and is completed all the same.
    (finding,) = (f for f in result.findings if (f.key, f.plant) == ("explicit-integration", plant))
    explicit = plan.of_variant(result.flights, plant, "explicit")
    assert explicit["scenario2", plan.MRAC].axes["yaw"]["itae"] < 0.5
    assert finding.title.endswith("in roll and pitch, not in yaw")
    assert "is printed as 1.13" in finding.statement
    assert explicit["scenario2", plan.L1].outcome.completed
    ended = [explicit["scenario2", plan.L1].axes[axis]["steady_state_error_deg"] for axis in ("roll", "pitch", "yaw")]
    assert "/".join(f"{error:.0f}" for error in ended) + " deg off" in finding.statement
    assert "lost" not in finding.statement


def test_ours_are_recomputed_from_the_histories(result: Reproduction) -> None:
    # an integral by another rule than the metrics' own, from the published columns
    flown = plan.of_variant(result.flights, "jsbsim", "paper")["scenario3", BEST]
    assert flown.history is not None
    t = flown.history["time_s"]
    error = np.abs(flown.history["theta_ref_rad"] - flown.history["theta_rad"])
    simpson = np.sum((error[:-2:2] + 4 * error[1:-1:2] + error[2::2]) / 6) * (t[2] - t[0])
    assert flown.axes["pitch"]["iae"] == pytest.approx(simpson, rel=1e-4)
    assert set(INTEGRALS) < set(flown.axes["pitch"])


def test_a_folder_of_the_users_is_refused_before_anything_is_flown(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"notes\.txt"):
        reproduce(PLANTS, tmp_path / "mine", figures=False, advance=lambda *_: None)
