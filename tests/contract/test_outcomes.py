"""How a flight ends: to the end, lost, or interrupted; and what is recorded then."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from flying import flown
from uavftc.flight.build import build_flight
from uavftc.flight.fly import CHUNK_ROWS, SLICE_ROWS, fly, fly_to_memory
from uavftc.flight.recorder import MemoryRecorder
from uavftc.jobs.fly import fly_mission
from uavftc.results.history import read_history
from uavftc.scenario.load import load_scenario


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_a_lost_vehicle_is_recorded_up_to_the_loss(plant: str) -> None:
    _, records, outcome = flown("scenario1", plant, None, ("envelope.bank_deg=4",))
    assert not outcome.completed
    assert outcome.ended_because is not None
    assert "bank 4.0 deg, limit 4 deg" in outcome.ended_because
    assert outcome.ended_at_s == records["t"][-1]
    assert np.degrees(records["x1"][-1, 0]) > 4.0 >= np.degrees(records["x1"][-2, 0])
    assert outcome.rows == len(records)


def test_ground_contact_ends_a_flight() -> None:
    _, records, outcome = flown(
        "scenario1", "jsbsim", None, ("initial.altitude_m=10", "reference.theta_deg=-20", "saturation=null")
    )
    assert outcome.ended_because is not None
    assert "ground contact" in outcome.ended_because
    assert records["contact"][-1] < 0.0 == records["contact"][-2]  # pushed up, in body axes with z down
    assert 0.0 < records["height"][-1] < 2.0  # of the centre of gravity, as the skids touch


def test_what_is_not_a_number_is_reported_and_not_recorded() -> None:
    blow = "disturbances=[{kind: angular-acceleration, start_s: 1, p_degps2: 1e300, q_degps2: 1e300}]"
    _, records, outcome = flown("scenario1", "analytic", None, (blow,))
    assert outcome.ended_because == "a state or command is not a number, at t = 1.005 s"
    assert records["t"][-1] == 1.0
    assert np.all(np.isfinite(records["x1"]))
    assert np.all(np.isfinite(records["v2"]))


def test_the_recorder_gets_every_row_once_across_chunks() -> None:
    duration = 2 * CHUNK_ROWS / 200 + 1
    flight = build_flight(load_scenario("scenario2", plant="analytic", overrides=(f"duration_s={duration}",)))
    records, outcome = fly_to_memory(flight)
    assert outcome.rows == len(records) == 2 * CHUNK_ROWS + 201
    np.testing.assert_array_equal(np.diff(np.round(records["t"] * 200)), 1)
    # the flight across chunks is the flight: its beginning is that of a short one
    _, short, _ = flown("scenario2", "analytic")
    assert records[: len(short) - 1].tobytes() == short[:-1].tobytes()


def test_a_flight_ends_where_it_is_stopped_and_keeps_what_was_flown() -> None:
    flight = build_flight(load_scenario("scenario1", plant="jsbsim"))
    memory, flown = MemoryRecorder(), [0]
    outcome = fly(flight, [memory], flown.append, stop=lambda: flown[-1] > 1000)
    assert outcome.interrupted
    assert not outcome.completed
    assert outcome.ended_because is not None
    assert "interrupted" in outcome.ended_because
    assert 1000 < len(memory.records()) == outcome.rows < 1000 + 2 * SLICE_ROWS


def test_ctrl_c_is_pythons_own_where_nobody_asked_to_stop() -> None:
    # a job of many flights cannot use half a flight, and must not go on with the next
    flight = build_flight(load_scenario("scenario1", plant="analytic"))
    memory = MemoryRecorder()
    with pytest.raises(KeyboardInterrupt):
        fly(flight, [memory], lambda rows: signal.raise_signal(signal.SIGINT))
    assert len(memory.records()) == 0
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_a_flight_flown_twice_is_refused_and_nothing_is_recorded(plant: str) -> None:
    # the vehicle stays where the first flight left it: a second one would not begin at the trim
    flight = build_flight(load_scenario("scenario1", plant=plant, overrides=("duration_s=1",)))
    _, outcome = fly_to_memory(flight)
    assert outcome.completed
    again = MemoryRecorder()
    with pytest.raises(RuntimeError, match="build_flight"):
        fly(flight, [again])
    assert len(again.records()) == 0
    _, anew = fly_to_memory(build_flight(flight.scenario))
    assert anew.rows == outcome.rows == 201


def ctrl_c_after(rows: int, times: int) -> Callable[[int], Iterator[Callable[[int], None]]]:
    """A progress bar that presses Ctrl-C, so many times at once, when it is called with more than `rows` rows."""

    @contextmanager
    def progress(total: int) -> Iterator[Callable[[int], None]]:
        def advance(done: int) -> None:
            if done > rows:
                for _ in range(times):
                    signal.raise_signal(signal.SIGINT)

        yield advance

    return progress


def test_ctrl_c_in_a_mission_keeps_what_was_flown(tmp_path: Path) -> None:
    scenario = load_scenario("scenario1", plant="jsbsim")
    document, outcome = fly_mission(scenario, tmp_path / "run", figures=False, progress=ctrl_c_after(1000, times=1))
    assert outcome.interrupted
    assert 1000 < outcome.rows < 1000 + 2 * SLICE_ROWS
    assert json.loads((tmp_path / "run" / "summary.json").read_text(encoding="utf-8")) == document
    assert len(read_history(tmp_path / "run" / "history.parquet")["time_s"]) == outcome.rows
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler  # handed back


def test_a_second_ctrl_c_in_a_mission_acts_at_once_and_nothing_is_written(tmp_path: Path) -> None:
    scenario = load_scenario("scenario1", plant="analytic")
    with pytest.raises(KeyboardInterrupt):
        fly_mission(scenario, tmp_path / "run", progress=ctrl_c_after(0, times=2))
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
