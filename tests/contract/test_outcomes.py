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
    with pytest.raises(RuntimeError, match=r"flown already.*build it again with build_flight"):
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


SLOW = """
import signal, time
def create(design, h, options):
    def step(t, x1_c, x1, x2):
        if t > 0.5:
            for _ in range(options["presses"]):
                signal.raise_signal(signal.SIGINT)
            time.sleep(options["sleep"])
        return 0, 0, 0
    return step
"""


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
@pytest.mark.parametrize(("presses", "sleep", "rows"), [(1, 0.0, 102), (2, 3600.0, 101)])
def test_ctrl_c_waits_for_one_python_step_at_most_and_a_second_breaks_into_it(
    tmp_path: Path, plant: str, presses: int, sleep: float, rows: int
) -> None:
    # the step at 0.505 s: the first Ctrl-C lets it end, the second does not; the rows before it are kept either way
    file = tmp_path / "mine.py"
    file.write_text(SLOW, encoding="utf-8")
    options = (f"controller.options={{presses: {presses}, sleep: {sleep}}}", "controller.timeout_s=60")
    scenario = load_scenario("scenario1", plant=plant, controller=str(file), overrides=options)
    document, outcome = fly_mission(scenario, tmp_path / "run", figures=False)
    assert outcome.interrupted
    assert document["ended_because"].startswith("interrupted by the user")
    history = read_history(tmp_path / "run" / "history.parquet")
    assert len(history["time_s"]) == outcome.rows == rows
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_in_a_python_step_is_pythons_own_where_nobody_asked_to_stop(tmp_path: Path) -> None:
    # a comparison must not take it for a failure of the controller, and go on
    file = tmp_path / "mine.py"
    file.write_text(SLOW, encoding="utf-8")
    options = ("controller.options={presses: 1, sleep: 0}",)
    flight = build_flight(load_scenario("scenario1", plant="analytic", controller=str(file), overrides=options))
    with pytest.raises(KeyboardInterrupt):
        fly_to_memory(flight)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_row_of_many_plant_steps_is_a_slice_of_its_own() -> None:
    # Ctrl-C and the progress bar wait for 2048 plant steps at most: with 1000 in a row, for two rows
    overrides = ("simulation.substeps=1000", "duration_s=0.1")
    flight = build_flight(load_scenario("scenario1", plant="analytic", overrides=overrides))
    seen: list[int] = []
    assert fly(flight, [], seen.append).completed
    assert seen == [2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 21]


def test_a_second_ctrl_c_in_a_mission_acts_at_once_and_nothing_is_written(tmp_path: Path) -> None:
    scenario = load_scenario("scenario1", plant="analytic")
    with pytest.raises(KeyboardInterrupt):
        fly_mission(scenario, tmp_path / "run", progress=ctrl_c_after(0, times=2))
    assert list(tmp_path.iterdir()) == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
