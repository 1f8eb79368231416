"""The flight: rows are filled, flown and handed to the recorders, chunk by chunk."""

from __future__ import annotations

import time
import weakref
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from uavftc.core.program import STOPPED
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight import envelope, numerical
from uavftc.flight.build import Flight
from uavftc.flight.departure import departure
from uavftc.flight.idle import Idle
from uavftc.flight.numerical import Tape
from uavftc.flight.recorder import MemoryRecorder, Recorder

CHUNK_ROWS = 16384  # rows held in memory, and handed on, at a time
SLICE_ROWS = 256  # rows flown between two calls of `progress` and `stop`
SLICE_PLANT_STEPS = 2048  # at most in a slice of more than one row: a row of many plant steps takes its time
SLICE_ROWS_PYTHON = 16  # where a step in plain Python stands, which may be slow; `stop` is asked at each row then

_flown: weakref.WeakValueDictionary[int, Flight] = weakref.WeakValueDictionary()
"""Flights flown already, by identity: as dataclasses they would be compared array by array."""


class Watch(Protocol):
    """Looks at a flight while it flies; it changes nothing of it."""

    rows: int
    """How many rows are flown, at most, before it is shown the last of them."""

    def take(self, row: np.void, stop: Callable[[], bool] | None = None) -> float:
        """Take in a row, and return how long that took, s; give up a wait where `stop` returns true."""


class Outcome(NamedTuple):
    """How a flight ended."""

    completed: bool
    ended_because: str | None
    ended_at_s: float | None
    interrupted: bool
    """Ended by `stop`, on behalf of the user."""
    rows: int
    """Rows recorded; N + 1 of a completed flight."""
    wall_s: float
    """Wall-clock time of the loop, without load, trim and compilation."""
    numerical: bool = False
    """Ended for the sake of its plant step, not of the vehicle; see `numerical`."""
    remarks: tuple[str, ...] = ()
    """What is worth a warning about how it ended, one line each."""


def fly(
    flight: Flight,
    recorders: Sequence[Recorder] = (),
    progress: Callable[[int], None] | None = None,
    *,
    stop: Callable[[], bool] | None = None,
    watch: Watch | None = None,
) -> Outcome:
    """Fly to the end, or until the vehicle is lost, or until `stop` returns true.

    Parameters
    ----------
    flight
        From `build.build_flight`; it can be flown once.
    recorders
        Each takes every row, in order.
    progress
        Called with the number of rows flown so far.
    stop
        Called every `SLICE_ROWS` rows, and at every row where the program has a step in plain Python; if it returns
        true, the flight ends there, and the rows flown so far are recorded, also if a KeyboardInterrupt is raised
        while it returns true. Any other Ctrl-C is left to Python: KeyboardInterrupt, and the recorders are incomplete.
    watch
        Is shown rows while they are flown, and may make the flight wait.

    Raises
    ------
    RuntimeError
        If the flight was flown before; nothing is recorded then.
    """
    if _flown.get(id(flight)) is flight:
        raise RuntimeError(
            "this flight was flown already, and its vehicle is where it ended; build it again with build_flight"
        )
    _flown[id(flight)] = flight
    flight.program.stop = stop
    with flight.program.around():
        return _fly(flight, recorders, progress, stop, watch)


def _fly(
    flight: Flight,
    recorders: Sequence[Recorder],
    progress: Callable[[int], None] | None,
    stop: Callable[[], bool] | None,
    watch: Watch | None,
) -> Outcome:
    slice_rows = _slice_rows(flight) if watch is None else min(_slice_rows(flight), watch.rows)
    unsound, tape, idle = numerical.unsound(flight), Tape(flight), Idle(flight)
    total = 1 if unsound is not None else flight.steps + 1
    wall_s = 0.0
    done = 0
    lost: np.void | None = None
    stopped = stop is not None and stop()
    while done < total and lost is None and not stopped:
        n = min(CHUNK_ROWS, total - done)
        # fresh for each chunk, so that a recorder may keep it without a copy
        rows = empty_rows(n, flight.shape)
        records = as_records(rows, flight.shape)
        flight.inputs.fill(records, done)
        flown = 0
        started = time.perf_counter()
        while flown < n and lost is None and not stopped:
            last = min(flown + slice_rows, n)
            try:
                flown = flight.plant.run(flight.program, rows, flown, last)
            except KeyboardInterrupt:  # a second Ctrl-C, between two steps: the rows of this slice are not kept
                if stop is None or not stop():
                    raise
                stopped = True
                break
            if flown < last:
                stopped = records["status"][flown] == STOPPED
                lost = None if stopped else records[flown].copy()
            if progress is not None:
                progress(done + flown)
            if watch is not None and flown:
                started += watch.take(records[flown - 1], stop)  # a wait is no time of the loop
            stopped = stopped or (stop is not None and stop())
        wall_s += time.perf_counter() - started
        # the row outside the envelope is still valid, unless it is not a number or has no command
        keep = flown + (lost is not None and lost["status"] > envelope.NOT_A_NUMBER)
        for recorder in (*recorders, tape, idle):
            recorder.take(records[:keep])
        done += keep
    if unsound is not None and not stopped:
        return Outcome(False, unsound, 0.0, False, done, wall_s, numerical=True)
    if lost is not None:
        because = _reason(flight, lost)
        if lost["status"] in envelope.OUTSIDE and (began := departure(flight, records[:keep])) is not None:
            because = f"{began}; ended by {because}"
        is_numerical, reason, remarks = numerical.verdict(flight, tape, lost, because, stop)
        at = float(lost["t"])
        return Outcome(False, reason, at, False, done, wall_s, is_numerical, (*remarks, *idle.remarks(at)))
    if done < total:
        at = max(done - 1, 0) / flight.scenario.controller.rate_hz
        return Outcome(False, f"interrupted by the user, at t = {at:.3f} s", at, True, done, wall_s)
    return Outcome(True, None, None, False, done, wall_s, remarks=idle.remarks(flight.scenario.duration_s))


def _slice_rows(flight: Flight) -> int:
    """Return how many rows are flown before `progress` and `stop` are called again."""
    if flight.program.in_python:
        return SLICE_ROWS_PYTHON
    substeps = round(flight.given.h / flight.given.plant_step)
    return max(1, min(SLICE_ROWS, SLICE_PLANT_STEPS // substeps))


def _reason(flight: Flight, lost: np.void) -> str:
    """Return in words why the flight ended at this row."""
    if (failure := flight.program.why(float(lost["status"]))) is not None:
        return f"{failure}, at t = {lost['t']:.3f} s"
    return envelope.reason(flight.envelope[0], lost)


def fly_to_memory(flight: Flight, stop: Callable[[], bool] | None = None) -> tuple[np.ndarray, Outcome]:
    """Fly and return all rows, shape (n,), dtype `signals.ROW`, with the outcome; `stop` as that of `fly`."""
    memory = MemoryRecorder()
    outcome = fly(flight, [memory], stop=stop)
    return memory.records(), outcome
