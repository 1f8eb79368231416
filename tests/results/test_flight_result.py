"""What is kept of a flight says the same in one process as in another, alone as among many."""

from __future__ import annotations

import hashlib
import pickle
from pathlib import Path

import numpy as np
import pytest

from uavftc.flight.fly import Outcome
from uavftc.jobs.campaign.pool import fly_one
from uavftc.results.flight import FlightResult, metadata_of
from uavftc.results.history import read_history, read_metadata
from uavftc.scenario.load import load_scenario, scenario_text


@pytest.fixture(scope="module")
def result() -> FlightResult:
    return fly_one(load_scenario("scenario3", plant="analytic", overrides=("duration_s=13",)))


def test_it_comes_back_whole_from_another_process(result: FlightResult) -> None:
    # a campaign's workers send it to the job by pickle
    back = pickle.loads(pickle.dumps(result))
    assert back.summary() == result.summary()
    assert back.figure_context() == result.figure_context()
    assert back.history.keys() == result.history.keys()
    np.testing.assert_array_equal(back.history["phi_rad"], result.history["phi_rad"])


def test_the_summary_is_that_of_the_flight(result: FlightResult) -> None:
    document = result.summary()
    assert (document["scenario"], document["controller"], document["plant"]) == ("scenario3", "nndondi-l1", "analytic")
    assert document["completed"] is True
    assert document["timing"]["controller_steps"] == 2600  # 13 s at 200 Hz
    assert document["axes"] == result.axes
    text = scenario_text(result.scenario)
    assert document["provenance"]["scenario_sha256"] == hashlib.sha256(text.encode()).hexdigest()


def test_the_figures_are_given_faults_limits_and_disturbances(result: FlightResult) -> None:
    context = result.figure_context()
    assert context.title == "scenario3: nndondi-l1 on hale, analytic"
    same = dict.fromkeys(("aileron", "elevator", "rudder", "left_aileron"), (-0.05, 0.1))
    assert context.limits_rad == {**same, "right_aileron": (-0.1, 0.05)}
    assert [(w.kind, w.what) for w in context.windows] == [
        ("fault", "aileron"),
        ("fault", "elevator"),
        ("disturbance", "disturbance"),
        ("fault", "aileron"),
        ("fault", "elevator"),
        ("fault", "rudder"),
        ("disturbance", "disturbance"),
    ]  # fmt: skip  (the disturbance that begins at 13 s is past the flight)
    last = context.windows[5]
    assert (last.start_s, last.end_s, last.label) == (8.0, 12.0, "ω = 0.2*t\nbias 3*cos(0.1*t) deg")
    assert context.limiting == ("tracking", 9.75)  # asked from the last quarter of the 13 s on, and worst at once
    assert context.twin is None


def test_the_figures_of_a_lost_flight_say_so_in_the_title(result: FlightResult) -> None:
    lost = result._replace(outcome=Outcome(False, "bank 90 deg", 3.0, False, 601, 0.1))
    assert lost.figure_context().title.splitlines() == ["scenario3: nndondi-l1 on hale, analytic", "LOST: bank 90 deg"]


def test_the_history_is_written_with_scenario_and_provenance(result: FlightResult, tmp_path: Path) -> None:
    result.write_history(tmp_path / "h.parquet")
    assert len(read_history(tmp_path / "h.parquet")["time_s"]) == 2601
    kept = read_metadata(tmp_path / "h.parquet")
    assert kept == metadata_of(result.scenario, result.origin)
    assert kept["scenario"] == scenario_text(result.scenario)
