"""The gallery in docs: a picture and an entry for each shipped scenario, checked without a flight."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import pytest

from uavftc.config.shipped import scenario_names


@pytest.fixture
def tool():
    file = Path(__file__).parents[1] / "tools" / "gallery.py"
    spec = importlib.util.spec_from_file_location("gallery", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def copied(tool, tmp_path, monkeypatch):
    """The tool on a copy of the page and of two scenarios and their pictures."""
    pictures = tmp_path / "images" / "gallery"
    pictures.mkdir(parents=True)
    for name in ("fault-stuck", "fault-drift"):
        shutil.copy(tool.PICTURES / f"beyond-{name}.png", pictures)
    shutil.copytree(tool.scenario_dir() / "beyond", tmp_path / "scenarios" / "beyond")
    monkeypatch.setattr(tool, "scenario_dir", lambda: tmp_path / "scenarios")
    monkeypatch.setattr(tool, "families", lambda: {"Damage": ["beyond/fault-stuck", "beyond/fault-drift"]})
    flown = tool.flown_in(tool.PAGE.read_text(encoding="utf-8"))
    monkeypatch.setattr(tool, "DOCS", tmp_path)
    monkeypatch.setattr(tool, "PICTURES", pictures)
    monkeypatch.setattr(tool, "PAGE", tmp_path / "gallery.md")
    tool.PAGE.write_text(tool.page(flown), encoding="utf-8", newline="\n")
    return tool


def test_page_and_pictures_are_those_of_the_scenarios(tool):
    assert tool.problems() == []


def test_every_scenario_of_the_folders_is_in_it_once(tool):
    names = [name for part in tool.families().values() for name in part]
    assert sorted(names) == sorted([*scenario_names("beyond"), *scenario_names("damage"), "gust"])


def test_what_is_out_of_date_is_said(copied):
    assert copied.problems() == []
    file = copied.scenario_dir() / "beyond" / "fault-stuck.yaml"
    file.write_text(file.read_text(encoding="utf-8").replace("start_s: 1", "start_s: 2"), encoding="utf-8")
    (copied.PICTURES / "beyond-fault-drift.png").unlink()
    (copied.PICTURES / "old.png").write_bytes(bytes(copied.LARGEST + 1))
    assert copied.problems() == [
        "gallery.md is not what the scenarios say",
        "beyond-fault-drift.png is missing",
        "old.png is of no scenario",
        "old.png has 80001 bytes, more than 80000",
    ]
    copied.PAGE.unlink()
    assert copied.problems()[:2] == ["beyond/fault-stuck has not been flown", "beyond/fault-drift has not been flown"]


def test_a_scenario_is_shown_as_it_is_and_a_long_one_without_its_comments(tool):
    short = (tool.scenario_dir() / "beyond" / "servo-rate-c172p.yaml").read_text(encoding="utf-8")
    assert tool.shown_text("beyond/servo-rate-c172p") == short.strip()
    assert "#" in short
    long = tool.shown_text("damage/fin-off")
    assert "#" not in long
    assert long.startswith("name: fin-off\ndescription: ")
    assert "    control_power: {rudder: 0}" in long


def test_the_line_of_a_flight_has_its_end_and_its_metrics(tool):
    axis = {"steady_state_error_deg": 0.01234, "iae": 0.5, "control_activity_rad": 1.0}
    summary = {"completed": True, "ended_because": None, "ended_at_s": None, "axes": dict.fromkeys(tool.AXES, axis)}
    judged = {"verdict": {"outcome": "degraded", "margin": -0.25, "limiting": "calm"}}
    assert tool.line_of(summary | judged) == (
        "**degraded**, margin −0.25 (calm); error at the end 0.012, 0.012, 0.012 deg; IAE 0.500, 0.500, 0.500 rad s; "
        "control activity 1.00, 1.00, 1.00 rad."
    )
    none = {"steady_state_error_deg": None, "iae": 0.5, "control_activity_rad": 1.0}
    summary["axes"] = {"roll": none, "pitch": none, "yaw": dict.fromkeys(none)}
    assert tool.line_of(summary | judged).split("; ")[1:] == [
        "IAE 0.500, 0.500, - rad s", "control activity 1.00, 1.00, - rad."
    ]  # fmt: skip
