"""The flight: rows are filled, flown and handed to the recorders, chunk by chunk."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from uavftc import envelope
from uavftc.build import Flight
from uavftc.recorder import Recorder
from uavftc.signals import as_records, empty_rows

CHUNK_ROWS = 16384  # rows held in memory, and handed on, at a time
SLICE_ROWS = 256  # rows flown between two looks at the clock and at Ctrl-C


class Outcome(NamedTuple):
    """How a flight ended."""

    completed: bool
    ended_because: str | None
    ended_at_s: float | None
    interrupted: bool
    """Ended by Ctrl-C."""
    rows: int
    """Rows recorded; N + 1 of a completed flight."""
    wall_s: float
    """Wall-clock time of the loop, without load, trim and compilation."""


def fly(flight: Flight, recorders: Sequence[Recorder] = (), progress: Callable[[int], None] | None = None) -> Outcome:
    """Fly to the end, or until the vehicle is lost, or until Ctrl-C.

    Parameters
    ----------
    flight
        From `build.build`; it can be flown once.
    recorders
        Each takes every row, in order.
    progress
        Called with the number of rows flown so far.
    """
    total = flight.steps + 1
    rows = empty_rows(min(CHUNK_ROWS, total))
    records = as_records(rows)
    wall_s = 0.0
    done = 0
    interrupted = lost = False
    try:
        while done < total and not (interrupted or lost):
            n = min(len(rows), total - done)
            rows[:n] = 0.0
            flight.inputs.fill(records[:n], done)
            flown = 0
            started = time.perf_counter()
            try:
                while flown < n and not lost:
                    stop = min(flown + SLICE_ROWS, n)
                    reached = flight.plant.run(flight.program, rows, flown, stop)
                    lost = reached < stop
                    if progress is not None:
                        progress(done + reached)
                    flown = reached
            except KeyboardInterrupt:
                interrupted = True
            wall_s += time.perf_counter() - started
            keep = flown
            if lost and int(records[flown]["status"]) != envelope.NOT_A_NUMBER:
                keep = flown + 1  # the row outside the envelope is still a true one
            for recorder in recorders:
                recorder.take(records[:keep])
            last = records[flown].copy() if lost else None
            done += keep
    except KeyboardInterrupt:
        interrupted = True
    if lost and last is not None:
        return Outcome(False, envelope.reason(flight.envelope[0], last), float(last["t"]), False, done, wall_s)
    if interrupted and done < total:
        at = max(done - 1, 0) / flight.scenario.controller.rate_hz
        return Outcome(False, f"interrupted by the user, at t = {at:.3f} s", at, True, done, wall_s)
    return Outcome(True, None, None, False, done, wall_s)


def fly_to_memory(flight: Flight) -> tuple[np.ndarray, Outcome]:
    """Fly and return all rows, shape (n,), dtype `signals.ROW`, with the outcome."""
    from uavftc.recorder import MemoryRecorder  # noqa: PLC0415

    memory = MemoryRecorder()
    outcome = fly(flight, [memory])
    return memory.records(), outcome
