"""Exported histories read back to the bit, by readers of other makers."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import loadmat, whosmat
from typer.testing import CliRunner

import uavftc
from uavftc.cli.app import umbrella
from uavftc.jobs.export.as_csv import write_csv
from uavftc.jobs.export.as_mat import KEYWORDS, field_names, unit_of_column, write_mat
from uavftc.results.history import read_history


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("export") / "flight"
    uavftc.fly("scenario3", plant="analytic", set={"duration_s": 1, "seed": 2**62 + 1}).save(out)
    return out


def run(*arguments: str | Path) -> Any:
    return CliRunner().invoke(umbrella, ["export", *map(str, arguments)])


def bits(values: np.ndarray) -> list[int]:
    return np.asarray(values, dtype=float).view(np.uint64).tolist()


def read_csv(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as stream:
        names, *rows = list(csv.reader(stream))
    cells = [[float(cell) if cell else np.nan for cell in row] for row in rows]
    return dict(zip(names, np.array(cells).T, strict=True))


def test_csv_and_mat_read_back_to_the_bit(folder: Path, tmp_path: Path) -> None:
    done = run(folder, "--csv", tmp_path / "a.csv", "--mat", tmp_path / "a.mat")
    assert done.exit_code == 0, done.output
    history = read_history(folder / "history.parquet")
    table = read_csv(tmp_path / "a.csv")
    flight = loadmat(tmp_path / "a.mat", simplify_cells=True)["flight"]
    assert list(table) == list(history) == list(flight["history"])
    assert len(history["time_s"]) == 201
    for name, values in history.items():
        assert bits(table[name]) == bits(values), name
        assert bits(flight["history"][name]) == bits(values), name
    assert np.isnan(history["airspeed_mps"]).all()  # null in the analytic plant: an empty cell, and NaN


def test_the_struct_holds_units_summary_and_scenario(folder: Path, tmp_path: Path) -> None:
    assert run(folder, "--mat", tmp_path / "a.mat").exit_code == 0
    assert whosmat(tmp_path / "a.mat") == [("flight", (1, 1), "struct")]
    flight = loadmat(tmp_path / "a.mat", simplify_cells=True)["flight"]
    raw = loadmat(tmp_path / "a.mat")["flight"][0, 0]
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert raw["history"]["phi_rad"][0, 0].shape == (201, 1)
    units = flight["units"]
    assert (units["time_s"], units["phi_rad"], units["q_radps"], units["f_hat_p_radps2"]) == (
        "s", "rad", "rad/s", "rad/s^2",
    )  # fmt: skip
    assert (units["roll_moment_asked_nm"], units["dynamic_pressure_pa"], units["load_factor_x"]) == ("N m", "Pa", "1")
    assert flight["names"]["phi_rad"] == "phi_rad"
    assert flight["summary"]["axes"]["roll"]["iae"] == summary["axes"]["roll"]["iae"]
    assert flight["summary"]["verdict"]["outcome"] == summary["verdict"]["outcome"]
    assert flight["summary"]["verdict"]["requirements"][0]["name"] == "flown"
    assert flight["summary"]["provenance"]["seed"] == 2**62 + 1  # beyond what a double holds
    assert flight["summary"]["completed"] == 1
    assert raw["summary"]["ended_because"][0, 0].shape == (0, 0)  # null
    assert "files" not in flight["summary"]
    assert flight["scenario"] == (folder / "scenario.yaml").read_text(encoding="utf-8")


def test_any_double_reads_back(tmp_path: Path) -> None:
    # every exponent, random mantissas, subnormal ones and both zeros
    rng = np.random.default_rng(0)
    values = rng.integers(0, 2**64, 4000, dtype=np.uint64).view(float)
    values = np.where(np.isnan(values), 0.1, values)
    values[:6] = [0.0, -0.0, 5e-324, np.finfo(float).max, 1 / 3, -1e22]
    write_csv(tmp_path / "a.csv", {"x": values})
    assert bits(read_csv(tmp_path / "a.csv")["x"]) == bits(values)
    write_mat(tmp_path / "a.mat", {"x": values}, {}, "")
    assert bits(loadmat(tmp_path / "a.mat", simplify_cells=True)["flight"]["history"]["x"]) == bits(values)


def test_fields_are_names_of_matlab_and_no_two_the_same() -> None:
    long = "own_" + "a" * 70
    names = ["phi_rad", "end", "1st", "a-b", "a_b", "a b", long + "1", long + "2", "", "ä", "_x"]
    fields = field_names(names)
    assert list(fields) == names
    assert fields["phi_rad"] == "phi_rad"
    assert fields["a_b"] == "a_b"  # whoever needs no change has its own name
    assert len(set(fields.values())) == len(names)
    for field in fields.values():
        assert field.isidentifier()
        assert field.isascii()
        assert field[0].isalpha()
        assert len(field) <= 63
        assert field not in KEYWORDS


def test_long_names_are_kept_next_to_their_fields(tmp_path: Path) -> None:
    name = "own_" + "a" * 80 + "_rad"
    write_mat(tmp_path / "a.mat", {name: np.arange(3.0)}, {"warnings": [], "each": [1, None, "x"]}, "")
    flight = loadmat(tmp_path / "a.mat", simplify_cells=True)["flight"]
    (field,) = flight["history"]
    assert len(field) == 63
    assert flight["names"][field] == name
    assert flight["units"][field] == unit_of_column(name) == "rad"
    assert [flight["summary"]["each"][0], flight["summary"]["each"][2]] == [1, "x"]


def test_each_flight_of_a_comparison_has_its_file(tmp_path: Path) -> None:
    out = tmp_path / "compared"
    compared = uavftc.compare("scenario1", controllers=["ndi-l1", "pid"], plants=["analytic"], set={"duration_s": 0.5})
    compared.save(out)
    done = run(out, "--csv", tmp_path / "all.csv", "--mat", tmp_path / "all.mat")
    assert done.exit_code == 0, done.output
    for name in ("ndi-l1", "pid"):
        history = read_history(out / "histories" / f"analytic-{name}.parquet")
        table = read_csv(tmp_path / f"all-analytic-{name}.csv")
        assert {key: bits(values) for key, values in table.items()} == {k: bits(v) for k, v in history.items()}
        summary = loadmat(tmp_path / f"all-analytic-{name}.mat", simplify_cells=True)["flight"]["summary"]
        assert summary["controller"] == name
    assert not (tmp_path / "all.csv").exists()


def refused(done: Any, *texts: str) -> None:
    said = " ".join(done.stderr.split())
    assert done.exit_code == 2
    for text in texts:
        assert text in said


def test_nothing_is_overwritten_unless_asked(folder: Path, tmp_path: Path) -> None:
    kept = tmp_path / "a.csv"
    kept.write_text("mine", encoding="utf-8")
    refused(run(folder, "--csv", kept, "--mat", tmp_path / "a.mat"), "a file that is there already", "add --force")
    assert kept.read_text(encoding="utf-8") == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]  # not one of the two is written
    assert run(folder, "--csv", kept, "--force").exit_code == 0
    assert kept.read_text(encoding="utf-8").startswith("time_s,phi_rad,")


def test_what_cannot_be_exported_is_refused(folder: Path, tmp_path: Path) -> None:
    refused(run(folder), "neither --csv nor --mat")
    refused(run(tmp_path / "none", "--csv", tmp_path / "a.csv"), "no such folder")
    refused(run(tmp_path, "--csv", tmp_path / "a.csv"), "without a summary.json")
    refused(run(folder, "--csv", tmp_path / "none" / "a.csv"), "which is no folder")
    refused(run(folder, "--csv", folder / "a.csv"), "inside a result folder")
    refused(run(folder, "--csv", tmp_path / "a.x", "--mat", tmp_path / "a.x"), "one file for both")
    assert list(tmp_path.iterdir()) == []
