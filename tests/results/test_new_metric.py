"""A new metric is one entry of the table in `analysis.metrics`: everything that lists metrics has it then."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from uavftc.analysis import metrics
from uavftc.analysis.metrics import Metric, Piece
from uavftc.core.signals import AXES
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.campaign.pool import fly_one
from uavftc.jobs.compare import compare
from uavftc.jobs.fly import fly_mission
from uavftc.report.side_by_side import markdown, metric_tables, tidy_csv
from uavftc.report.table import metric_table
from uavftc.scenario.load import load_scenario

NAME = "largest_error_deg"


class LargestError:
    """The largest |e|, deg, over the whole flight."""

    def __init__(self) -> None:
        self._largest = np.zeros(3)

    def take(self, piece: Piece) -> None:
        self._largest = np.maximum(self._largest, np.degrees(piece.error.max(axis=0)))

    def values(self) -> Sequence[float | None]:
        return list(self._largest)


@pytest.fixture(autouse=True)
def _one_more_metric(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = Metric(NAME, "largest error", "deg", LargestError, digits=3)
    monkeypatch.setattr(metrics, "METRICS", (*metrics.METRICS, entry))


def text_of(table) -> str:
    out = io.StringIO()
    Console(file=out, width=100).print(table)
    return out.getvalue()


def test_it_is_in_the_summary_and_on_the_terminal(tmp_path: Path) -> None:
    # scenario 1 begins with a step of 5 deg on each axis, and its error never exceeds that
    scenario = load_scenario("scenario1", plant="analytic", overrides=("duration_s=2",))
    document, _ = fly_mission(scenario, tmp_path / "run", figures=False)
    for axis in AXES:
        assert list(document["axes"][axis])[-1] == NAME
        assert document["axes"][axis][NAME] == pytest.approx(5.0)
    (line,) = [line for line in text_of(metric_table(document)).splitlines() if "largest error [deg]" in line]
    assert line.split()[-3:] == ["5.000"] * 3


def test_it_is_in_every_table_of_a_comparison(tmp_path: Path) -> None:
    scenario = load_scenario("scenario1", plant="analytic", overrides=("duration_s=2",))
    document = compare({("analytic", "nndondi-l1"): scenario}, tmp_path / "run", figures=False)
    (table,) = metric_tables(document)
    assert text_of(table).count("largest error [deg]") == 3
    assert "| yaw: largest error [deg] | 5.000 |" in markdown(document)
    rows = list(csv.DictReader(io.StringIO(tidy_csv(document))))
    values = {row["axis"]: float(row["value"]) for row in rows if row["metric"] == NAME}
    assert values == pytest.approx(dict.fromkeys(AXES, 5.0))


def test_it_is_among_the_metrics_of_one_flight_among_many() -> None:
    scenario = load_scenario("scenario1", plant="analytic", overrides=("duration_s=2",))
    records, _ = fly_to_memory(build_flight(scenario))
    expected = np.degrees(np.abs(records["x1_c"] - records["x1"])).max(axis=0)
    axes = fly_one(scenario, keep_history=False).axes
    np.testing.assert_allclose([axes[axis][NAME] for axis in AXES], expected)
