"""The flight: rows are filled, flown and handed to the recorders, chunk by chunk."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import STEP_FAILED
from uavftc.flight import envelope
from uavftc.flight.build import Flight
from uavftc.results.history import Recorder

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
        From `build.build_flight`; it can be flown once.
    recorders
        Each takes every row, in order.
    progress
        Called with the number of rows flown so far.
    """
    total = flight.steps + 1
    wall_s = 0.0
    done = 0
    lost: np.void | None = None
    with _ctrl_c() as stopped:
        while done < total and lost is None and not stopped.is_set():
            n = min(CHUNK_ROWS, total - done)
            rows = empty_rows(n)  # fresh for each chunk, so that a recorder may keep it without a copy
            records = as_records(rows)
            flight.inputs.fill(records, done)
            flown = 0
            started = time.perf_counter()
            while flown < n and lost is None and not stopped.is_set():
                stop = min(flown + SLICE_ROWS, n)
                flown = flight.plant.run(flight.program, rows, flown, stop)
                if flown < stop:
                    lost = records[flown].copy()
                if progress is not None:
                    progress(done + flown)
            wall_s += time.perf_counter() - started
            # the row outside the envelope is still a true one, unless it is no number or has no command
            keep = flown + (lost is not None and lost["status"] not in (envelope.NOT_A_NUMBER, STEP_FAILED))
            for recorder in recorders:
                recorder.take(records[:keep])
            done += keep
    if lost is not None:
        return Outcome(False, _reason(flight, lost), float(lost["t"]), False, done, wall_s)
    if done < total:
        at = max(done - 1, 0) / flight.scenario.controller.rate_hz
        return Outcome(False, f"interrupted by the user, at t = {at:.3f} s", at, True, done, wall_s)
    return Outcome(True, None, None, False, done, wall_s)


def _reason(flight: Flight, lost: np.void) -> str:
    """Return in words why the flight ended at this row."""
    if flight.program.failure is not None:
        return f"{flight.program.failure}, at t = {lost['t']:.3f} s"
    return envelope.reason(flight.envelope[0], lost)


@contextmanager
def _ctrl_c() -> Iterator[threading.Event]:
    """Yield an event that Ctrl-C sets, so that it ends a flight between two slices and never tears a recorder.

    A second Ctrl-C acts at once. Off the main thread Python delivers no signals and the event stays clear.
    """
    stopped = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stopped
        return

    def stop(_signal: int, _frame: object) -> None:
        stopped.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield stopped
    finally:
        signal.signal(signal.SIGINT, before)


def fly_to_memory(flight: Flight) -> tuple[np.ndarray, Outcome]:
    """Fly and return all rows, shape (n,), dtype `signals.ROW`, with the outcome."""
    from uavftc.results.history import MemoryRecorder  # noqa: PLC0415

    memory = MemoryRecorder()
    outcome = fly(flight, [memory])
    return memory.records(), outcome
