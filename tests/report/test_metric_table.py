"""The closing block says everything in 80 columns, with and without colour."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from uavftc.analysis.metrics import METRICS
from uavftc.report.table import metric_table, print_result
from uavftc.results.summary import summary

ROLL = dict(
    zip((metric.name for metric in METRICS), (0.0021, 9.153, 0.16854, 0.0081, 0.3073, 0.0076, 0.1234), strict=True)
)


def document(**changes):
    pitch = ROLL | {"steady_state_error_deg": 0.05, "convergence_time_s": None}
    yaw = ROLL | {
        "steady_state_error_deg": 1.2,
        "convergence_time_s": None,
        "iae": 2e-6,
        "control_activity_rad": 123456,
    }
    arguments = {
        "scenario": "scenario3",
        "aircraft": "hale",
        "plant": "jsbsim",
        "controller": "nndondi-l1",
        "completed": True,
        "ended_because": None,
        "axes": {"roll": ROLL, "pitch": pitch, "yaw": yaw},
        "timing": {"flight_wall_s": 0.213, "controller_steps": 4000, "us_per_controller_step": 53.25},
        "provenance": {"uavftc": "0"},
    }
    return summary(**(arguments | changes))


def printed(made, folder=None, **console):
    out = io.StringIO()
    print_result(Console(file=out, width=80, **console), made, folder)
    return out.getvalue()


def row(text: str, label: str) -> list[str]:
    (line,) = [line for line in text.splitlines() if line.strip().startswith(label)]
    return line.split(label)[1].split()


def test_each_row_has_its_unit_and_each_axis_its_number():
    text = printed(document())
    assert row(text, "steady-state error [deg]") == ["0.0021", "0.0500", "1.2000"]
    assert row(text, "IAE [rad s]") == ["0.1685", "0.1685", "2.0e-06"]
    assert row(text, "ISE [rad^2 s]") == ["0.0081"] * 3
    assert row(text, "ITAE [rad s^2]") == ["0.3073"] * 3
    assert row(text, "ITSE [rad^2 s^2]") == ["0.0076"] * 3
    assert row(text, "control activity [rad]") == ["0.1234", "0.1234", "1.2e+05"]
    assert row(text, "convergence time [s]") == ["9.15", "not", "within", "not", "within"]
    assert text.count("the flight") == 2


def test_title_names_scenario_controller_aircraft_and_plant():
    assert printed(document()).splitlines()[0].strip() == "scenario3: nndondi-l1 on hale, jsbsim"


@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_nothing_but_the_path_is_wider_than_80_columns_in_any_encoding(encoding):
    raw = io.BytesIO()
    out = io.TextIOWrapper(raw, encoding=encoding, errors="strict")
    folder = Path("/somewhere") / ("long" * 20) / "scenario3-nndondi-l1-jsbsim"
    made = document(warnings=["a remark " * 20], scenario="a-scenario-with-a-name-of-great-length-" * 2)
    print_result(Console(file=out, width=80), made, folder)
    out.flush()
    lines = raw.getvalue().decode(encoding).splitlines()
    assert f"results: {folder}" in lines  # whole, so that it can be copied
    assert max(len(line) for line in lines if "results:" not in line) <= 80


def test_colour_shows_how_near_but_is_not_needed(monkeypatch):
    made = document()
    cells = metric_table(made).columns
    styles = [column._cells[0].style for column in cells[1:]]
    assert styles == ["green", "yellow", "red"]  # 0.0021, 0.05 and 1.2 deg
    plain = printed(made)
    assert "\x1b" not in plain
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[3" not in printed(made, force_terminal=True)


def test_a_lost_vehicle_gets_time_and_reason_and_no_convergence_verdict():
    axes = {a: ROLL | {"steady_state_error_deg": None, "convergence_time_s": None} for a in ("roll", "pitch", "yaw")}
    text = printed(
        document(completed=False, ended_because="ground contact, at t = 8.345 s", ended_at_s=8.345, axes=axes)
    )
    assert "lost: ground contact, at t = 8.345 s" in text
    assert row(text, "convergence time [s]") == ["-"] * 3  # the flight has no end to be within
    assert row(text, "steady-state error [deg]") == ["-"] * 3
    assert "completed" not in text


def test_an_interrupted_flight_is_not_called_lost():
    text = printed(document(completed=False, ended_because="interrupted by the user, at t = 2.000 s", ended_at_s=2.0))
    assert "interrupted by the user, at t = 2.000 s" in text
    assert "lost" not in text


def test_names_are_text_and_not_markup():
    made = document(scenario="[bold]x[/bold]", aircraft=":smile:", warnings=["key [rudder] is odd"])
    text = printed(made, Path("results/[red]x"))
    for literal in ("[bold]x[/bold]", ":smile:", "warning: key [rudder] is odd", "results: results/[red]x"):
        assert literal in text
