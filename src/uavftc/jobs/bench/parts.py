"""The parts of a sample: the controller's call, what crosses between Python and JSBSim, a row recorded."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np

from uavftc.core.program import Program
from uavftc.core.signals import empty_rows
from uavftc.core.stage import Block, PythonBlock
from uavftc.flight.build import build_flight
from uavftc.flight.recorder import MemoryRecorder
from uavftc.jobs.bench.flights import flown, jsbsim_plant, scenario
from uavftc.jobs.bench.measure import Figure, Job, alternately, computed, of, timed
from uavftc.results.history import ParquetRecorder


def controller_step_us(rounds: int) -> Figure:
    """One compiled call of the controller from Python on one row, through the measurements of a flight."""
    records = flown("scenario3", "jsbsim").copy()
    rows = records.view(np.float64).reshape(len(records), -1)
    nothing = Program([])
    controller, crossing = alternately(
        rounds, lambda: _one_by_one(Program(_controller_blocks()), rows), lambda: _one_by_one(nothing, rows)
    )
    n = len(rows) * 1e-6
    return Figure([s / n for s in controller], {"empty_call_us": of([s / n for s in crossing])})


def _controller_blocks() -> list[Block | PythonBlock]:
    """Return the controller of scenario 3, at its start."""
    return build_flight(scenario("scenario3", plant="jsbsim")).controller.blocks


def _one_by_one(program: Program, rows: np.ndarray) -> float:
    run = program.on(rows)

    def calls() -> None:
        for k in range(len(rows)):
            run(k, k + 1)

    return computed(calls)


class _NoProgram:
    """Takes the place of the compiled call."""

    def on(self, _rows: np.ndarray) -> Callable[[int, int], int]:
        return lambda _first, last: last


class _NoFdm:
    """Takes the place of JSBSim's frame; the properties stay those of the real one."""

    def run(self) -> bool:
        return True


def bridge_io_us(rounds: int) -> Figure:
    """The loop over JSBSim without program and frames: state read and packed, commands unpacked and written."""
    flight = build_flight(scenario("scenario3", plant="jsbsim"))
    plant, rows = jsbsim_plant(flight), empty_rows(flight.steps, len(flight.given.effectors))
    fdm, plant.fdm = plant.fdm, cast(Any, _NoFdm())
    program, frame = _NoProgram(), _NoFdm()

    step = program.on(rows)

    def stand_ins() -> None:
        for k in range(len(rows)):
            step(k, k + 1)
            frame.run()

    whole, empty = alternately(
        rounds, lambda: computed(lambda: plant.run(cast(Any, program), rows, 0, len(rows))), lambda: computed(stand_ins)
    )
    del fdm  # until here the properties needed it
    return Figure([1e6 * (a - b) / len(rows) for a, b in zip(whole, empty, strict=True)])


def record_us(rounds: int) -> dict[str, Figure]:
    """A row of a flight of 20 s handed to a recorder: copied in memory, written to Parquet (file closed)."""
    records = flown("scenario3", "jsbsim")

    def in_memory() -> float:
        return timed(lambda: MemoryRecorder().take(records))

    def in_parquet() -> float:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "history.parquet"

            def write() -> None:
                with ParquetRecorder(path, {}) as recorder:
                    recorder.take(records)

            return timed(write)

    jobs: dict[str, Job] = {"memory": in_memory, "parquet": in_parquet}
    seconds = alternately(rounds, *jobs.values())
    per_row: Callable[[float], float] = lambda s: 1e6 * s / len(records)  # noqa: E731
    return {name: Figure([*map(per_row, column)]) for name, column in zip(jobs, seconds, strict=True)}
