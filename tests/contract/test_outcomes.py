"""How a flight ends: to the end, lost, or interrupted; and what is recorded then."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from flying import flown
from uavftc.flight.build import build_flight
from uavftc.flight.fly import CHUNK_ROWS, SLICE_ROWS, fly, fly_to_memory
from uavftc.results.history import MemoryRecorder
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


def test_ctrl_c_keeps_what_was_flown() -> None:
    flight = build_flight(load_scenario("scenario1", plant="jsbsim"))
    memory = MemoryRecorder()

    def interrupt(rows: int) -> None:
        if rows > 1000:
            signal.raise_signal(signal.SIGINT)

    outcome = fly(flight, [memory], interrupt)
    assert outcome.interrupted
    assert not outcome.completed
    assert outcome.ended_because is not None
    assert "interrupted" in outcome.ended_because
    assert 1000 < len(memory.records()) == outcome.rows < 1000 + 2 * SLICE_ROWS
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler  # handed back
