"""A comparison flies every combination, measures how far the plants are apart, and writes one folder or none."""

from __future__ import annotations

import csv
import io
import json
import signal
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from uavftc.analysis.metrics import METRICS
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.jobs import compare as comparison
from uavftc.jobs.compare import compare, load_combinations
from uavftc.jobs.fly import fly_mission
from uavftc.report.distance import distance
from uavftc.report.side_by_side import markdown, print_comparison, tidy_csv
from uavftc.results.folder import ResultFolder
from uavftc.results.summary import summary
from uavftc.scenario.load import load_scenario

SHORT = ("duration_s=2",)


def tree(folder: Path) -> set[str]:
    return {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}


def history(rows: int = 2001, **degrees) -> dict[str, np.ndarray]:
    """A level flight of 10 s at 200 Hz; `degrees` are columns without their unit, in deg and deg/s."""
    names = ("phi", "theta", "psi", "phi_ref", "theta_ref", "psi_ref")
    columns = {f"{name}_rad": np.zeros(rows) for name in names} | {f"{name}_radps": np.zeros(rows) for name in "pqr"}
    for name, values in degrees.items():
        unit = "radps" if name in "pqr" else "rad"
        columns[f"{name}_{unit}"] = np.radians(np.broadcast_to(np.asarray(values, float), rows).copy())
    return {"time_s": np.arange(rows) / 200.0, **columns}


# distance


def test_distance_of_a_constant_a_sine_and_a_ramp():
    t = np.arange(2001) / 200.0
    apart = distance(history(phi=1.5, theta=0.3 * np.sin(np.pi * t), p=-0.25, r=0.1 * t), history(phi=1.0))
    angles, rates = apart["attitude_deg"], apart["rates_degps"]
    assert apart["rows"] == 2001
    assert angles["roll"] == {"rms": pytest.approx(0.5), "largest": pytest.approx(0.5)}
    # a sine over whole periods: amplitude over root two, but for one sample of 2001 too many, at its zero
    assert angles["pitch"]["rms"] == pytest.approx(0.3 * np.sqrt(0.5 * 2000 / 2001))
    assert angles["pitch"]["largest"] == pytest.approx(0.3)
    assert angles["yaw"] == {"rms": 0.0, "largest": 0.0}
    assert angles["all"]["rms"] == pytest.approx(np.sqrt((0.25 + 0.045 * 2000 / 2001) / 3))
    assert angles["all"]["largest"] == pytest.approx(0.5)
    assert rates["roll"] == {"rms": pytest.approx(0.25), "largest": pytest.approx(0.25)}
    assert rates["yaw"]["rms"] == pytest.approx(1.0 / np.sqrt(3), rel=1e-3)  # of a ramp from 0 to 1
    assert rates["yaw"]["largest"] == pytest.approx(1.0)


def test_distance_counts_from_the_reference_so_that_another_trim_is_no_difference():
    apart = distance(history(theta=7.0, theta_ref=8.0), history(theta=0.0, theta_ref=1.2))
    assert apart["attitude_deg"]["pitch"]["largest"] == pytest.approx(0.2)


def test_distance_of_headings_goes_the_short_way_round():
    apart = distance(history(psi=179.0), history(psi=-179.5))
    assert apart["attitude_deg"]["yaw"]["largest"] == pytest.approx(1.5)


def test_distance_ends_with_the_shorter_flight_and_passes_over_what_diverged():
    wild = history(rows=401, phi=1.0)
    wild["phi_rad"][-2:] = 1e300, np.inf
    apart = distance(wild, history(phi=0.0))
    assert apart["rows"] == 401
    assert apart["attitude_deg"]["roll"]["largest"] == pytest.approx(1.0)
    assert distance(history(rows=0), history())["attitude_deg"]["all"] == {"rms": None, "largest": None}


# combinations


def test_combinations_are_in_the_order_of_the_lists_and_default_to_the_scenarios_controller():
    assert list(load_combinations("scenario2")) == [("jsbsim", "nndondi-l1"), ("analytic", "nndondi-l1")]
    named = load_combinations("scenario2", plants="analytic", controllers="nndondi-mrac, ndi-l1")
    assert list(named) == [("analytic", "nndondi-mrac"), ("analytic", "ndi-l1")]
    assert [s.controller.inner.kind for s in named.values()] == ["mrac", "l1"]
    changed = load_combinations("scenario2", overrides=["controller.outer.kind=ndi", *SHORT])
    assert list(changed) == [("jsbsim", "ndi-l1"), ("analytic", "ndi-l1")]
    assert {s.duration_s for s in changed.values()} == {2.0}


# the whole job


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """Scenario 3 for 2 s; the airspeed limit is passed on JSBSim, and the analytic model has no airspeed."""
    folder = tmp_path_factory.mktemp("compared") / "deep" / "run"
    overrides = [*SHORT, "envelope.min_airspeed_mps=29.9"]
    scenarios = load_combinations("scenario3", controllers="nndondi-l1,ndi-l1", overrides=overrides)
    return folder, compare(scenarios, folder)


def test_one_lost_vehicle_stops_nobody_and_all_is_written(compared):
    folder, document = compared
    outcomes = {(f["plant"], f["controller"]): f["completed"] for f in document["combinations"]}
    assert outcomes == {
        ("jsbsim", "nndondi-l1"): False, ("jsbsim", "ndi-l1"): False,
        ("analytic", "nndondi-l1"): True, ("analytic", "ndi-l1"): True,
    }  # fmt: skip
    assert document["completed"] is False
    assert "airspeed" in document["combinations"][0]["ended_because"]
    assert json.loads((folder / "summary.json").read_text(encoding="utf-8")) == document
    assert "uavftc" in document["provenance"]
    assert tree(folder) == {
        "summary.json", "scenario.yaml", "comparison.md", "comparison.csv",
        "figures/tracking.png", "figures/commands.png", "figures/difference.png",
        *(f"histories/{p}-{c}.parquet" for p, c in outcomes),
    }  # fmt: skip
    for figure in ("tracking", "commands", "difference"):
        with Image.open(folder / "figures" / f"{figure}.png") as image:
            # 9 in, and of three windows three lines of 0.22 in, three lanes of 0.19 in, 0.06 in below each block
            assert image.size == (1650, 1552)


def test_the_distance_ends_where_the_first_was_lost(compared):
    _, document = compared
    entry = document["distances"][0]
    assert (entry["plants"], entry["controller"]) == (["jsbsim", "analytic"], "nndondi-l1")
    lost = document["combinations"][0]
    assert entry["until_s"] == pytest.approx(lost["ended_at_s"])
    assert entry["rows"] == lost["timing"]["controller_steps"] + 1
    assert 0.0 < entry["attitude_deg"]["all"]["rms"] < entry["attitude_deg"]["all"]["largest"] < 5.0


def test_each_flight_is_as_uavftc_fly_writes_it_to_the_bit(compared, tmp_path):
    folder, document = compared
    scenario = load_scenario(folder / "scenario.yaml")  # as flown, of the first combination
    alone, _ = fly_mission(scenario, tmp_path / "alone", figures=False)
    of_comparison = document["combinations"][0]
    assert set(alone) - set(of_comparison) == {"files", "summary_sha256"}
    assert [k for k in of_comparison if alone[k] != of_comparison[k]] == ["timing"]
    ours = (folder / "histories" / "jsbsim-nndondi-l1.parquet").read_bytes()
    assert ours == (tmp_path / "alone" / "history.parquet").read_bytes()


def test_csv_is_tidy_and_exact_and_markdown_names_the_lost(compared):
    folder, document = compared
    rows = list(csv.DictReader(io.StringIO((folder / "comparison.csv").read_text(encoding="utf-8"))))
    assert len(rows) == 4 * len(AXES) * len(METRICS)
    by_name = {tuple(row[k] for k in ("plant", "controller", "axis", "metric")): row["value"] for row in rows}
    assert by_name["jsbsim", "ndi-l1", "yaw", "convergence_time_s"] == ""  # lost
    assert float(by_name["analytic", "ndi-l1", "yaw", "iae"]) == document["combinations"][3]["axes"]["yaw"]["iae"]
    text = (folder / "comparison.md").read_text(encoding="utf-8")
    assert "| jsbsim, nndondi-l1 (lost) | jsbsim, ndi-l1 (lost) | analytic, nndondi-l1 | analytic, ndi-l1 |" in text
    assert "- jsbsim, nndondi-l1: airspeed" in text
    assert "\x1b" not in text


def test_ctrl_c_in_one_flight_ends_the_job_and_writes_nothing(tmp_path, monkeypatch):
    flown = []

    def stopped(scenario):
        flown.append(scenario)
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(comparison, "fly_one", stopped)
    with pytest.raises(KeyboardInterrupt):
        compare(load_combinations("scenario1", plants="analytic,jsbsim", overrides=SHORT), tmp_path / "a" / "run")
    assert len(flown) == 1
    assert list(tmp_path.iterdir()) == []


def test_one_plant_alone_has_no_distance_and_no_figure_of_it(tmp_path):
    scenarios = load_combinations("scenario1", plants="analytic", controllers="nndondi-l1,ndi-l1", overrides=SHORT)
    document = compare(scenarios, tmp_path / "run")
    assert document["distances"] == []
    assert not (tmp_path / "run" / "figures" / "difference.png").exists()
    assert "against" not in (tmp_path / "run" / "comparison.md").read_text(encoding="utf-8")


# the folder


def test_results_of_another_job_are_ours_but_a_file_put_among_them_is_not(tmp_path):
    scenarios = load_combinations("scenario1", plants="analytic", overrides=SHORT)
    scenario = next(iter(scenarios.values()))
    fly_mission(scenario, tmp_path / "run", figures=False)
    compare(scenarios, tmp_path / "run", figures=False)
    assert "history.parquet" not in tree(tmp_path / "run")
    fly_mission(scenario, tmp_path / "run", figures=False)
    assert tree(tmp_path / "run") == {"summary.json", "history.parquet", "scenario.yaml"}
    (tmp_path / "run" / "comparison.md").write_text("notes of the user", encoding="utf-8")
    with pytest.raises(InputError, match=r"comparison\.md"):
        ResultFolder(tmp_path / "run").check()


# the tables


def document_of(plants: int, controllers: int) -> dict:
    names = ("jsbsim", "analytic")[:plants], ("nndondi-mrac", "nndondi-l1", "ndi-mrac", "ndi-l1")[:controllers]
    values = dict(zip((m.name for m in METRICS), (12.3456, None, 0.17, 123456.7, 1e-7, 0.3, 42.02), strict=True))
    flights = [
        summary(
            scenario="scenario3", aircraft="hale", plant=plant, controller=controller,
            completed=controller != "ndi-l1", ended_because="bank [red]90[/] deg" if controller == "ndi-l1" else None,
            axes=dict.fromkeys(AXES, values), provenance={"uavftc": "0"},
            timing={"flight_wall_s": 1.0, "controller_steps": 4000, "us_per_controller_step": 250.0},
        )
        for plant, controller in product(*names)
    ]  # fmt: skip
    sizes = {axis: {"rms": 0.0123, "largest": None} for axis in (*AXES, "all")}
    apart = {"plants": list(names[0]), "until_s": 12.345, "rows": 9, "attitude_deg": sizes, "rates_degps": sizes}
    return {
        "scenario": "scenario3",
        "aircraft": "hale",
        "plants": names[0],
        "controllers": names[1],
        "combinations": flights,
        "distances": [apart | {"controller": controller} for controller in names[1] if plants == 2],
        "warnings": ["take care"],
    }


@pytest.mark.parametrize(("plants", "controllers"), [(1, 1), (2, 1), (1, 3), (2, 2), (1, 4), (2, 3), (2, 4)])
def test_the_tables_fit_80_columns_uncut_and_take_nothing_for_markup(plants, controllers):
    out = io.StringIO()
    document = document_of(plants, controllers)
    print_comparison(Console(file=out, width=80), document, Path("results/x"))
    text = out.getvalue()
    assert max(map(len, text.splitlines())) <= 80
    assert "…" not in text
    assert text.count("IAE [rad s]") == (6 if plants * controllers > 4 else 3)
    assert text.count("nndondi-mrac") == (plants + (plants == 2))  # heads of columns, and of the distance
    assert text.count("12.3456") == 3 * plants * controllers
    if controllers == 4:
        assert text.count("LOST") == plants
        assert "bank [red]90[/] deg" in text
    assert "take care" in text
    assert text.endswith("results: results/x\n")
    assert len(markdown(document).splitlines()) > 20
    assert tidy_csv(document).count("\n") == 1 + plants * controllers * len(AXES) * len(METRICS)
