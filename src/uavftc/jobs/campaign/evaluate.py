"""One flight of a campaign in a worker: from the values of its case to a row of the table.

A worker keeps the variants' scenarios; what it reads, trims and compiles for one flight is there for the next.
"""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from multiprocessing import parent_process
from typing import Any, NamedTuple

from uavftc.aircraft.definition import Aircraft, load_aircraft
from uavftc.analysis.metrics import METRICS, controlled_of
from uavftc.analysis.verdict import SURVIVED
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.recorder import published
from uavftc.jobs.campaign.pool import judged
from uavftc.jobs.campaign.variants import Variant, names_of, reached
from uavftc.results.flight import FlightResult, origin_of
from uavftc.scenario.changed import Changing

ERROR = "error"
"""Outcome of a flight that could not be flown, whose worker died, or that took too long."""
PLACE, HISTORY = "_variant", "_history"
"""What a row has that is no column: the place of its variant, and the bytes of the history where it is kept."""
METRIC_COLUMNS = tuple(f"{axis}_{metric.name}" for axis in AXES for metric in METRICS)


class Job(NamedTuple):
    """One flight that is to be flown."""

    case: int
    variant: int
    """Its place in the list of variants."""
    values: Mapping[str, Any]
    """Of the varied keys."""
    history: bool = False
    """Whether its row brings its history, whatever the plan says."""


class Plan(NamedTuple):
    """What a worker is given once."""

    variants: Sequence[Variant]
    success: Mapping[str, float] | None
    """Greatest values of metrics, or None for outcome `survived`."""
    histories: str
    """Which rows bring the bytes of a history: `none`, `failures` or `all`."""


class Evaluator:
    """Flies the jobs of one plan in this process.

    Parameters
    ----------
    plan
        What they share.
    limit_s
        Wall-clock limit of a flight's loop, which is looked at every few rows; infinite where something else ends it.
    """

    def __init__(self, plan: Plan, limit_s: float = math.inf) -> None:
        self._plan, self._limit_s = plan, limit_s
        self._changing = [Changing(variant.scenario) for variant in plan.variants]
        self._aircraft: dict[int, Aircraft] = {}

    def __call__(self, job: Job) -> dict[str, Any]:
        """Fly one case by one variant, and return its row."""
        started = time.perf_counter()
        row = row_of(self._plan.variants[job.variant], job)
        try:
            row |= self._flown(job)
        except InputError as error:
            row["reason"] = _short(error)
        except (ArithmeticError, ValueError, RuntimeError, TypeError, AttributeError, LookupError) as error:
            row["reason"] = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"
        return row | {"wall_s": time.perf_counter() - started}

    def _flown(self, job: Job) -> dict[str, Any]:
        scenario = self._changing[job.variant](job.values)
        if job.variant not in self._aircraft:
            self._aircraft[job.variant] = load_aircraft(scenario.aircraft)
        flight = build_flight(scenario, self._aircraft[job.variant])
        if lost := reached(flight.scenario, job.values):
            return {"reason": f"{', '.join(lost)} did not reach the flight"}
        records, result = judged(flight, self._stop())
        if result.outcome.interrupted:
            return {"reason": late(self._limit_s)}
        found = _results(result, self._plan.success)
        failed = self._plan.histories == "failures" and not found["success"]
        if job.history or failed or self._plan.histories == "all":
            whole = result._replace(history=published(records, flight.columns), origin=origin_of(flight))
            found[HISTORY] = whole.history_bytes()
        return found

    def _stop(self) -> Callable[[], bool] | None:
        if self._limit_s == math.inf:
            return None
        end = time.monotonic() + self._limit_s
        return lambda: time.monotonic() > end


def late(limit_s: float) -> str:
    """Return the reason of a flight that took too long."""
    return f"not done within {limit_s:g} s"


_evaluator: Evaluator | None = None


def prepare(plan: Plan) -> None:
    """Take in what all flights of this worker share, and end with the process that started it.

    It does next to nothing: a worker that dies here would take a flight with it that nobody waits for.
    """
    global _evaluator  # noqa: PLW0603 - a worker of a pool flies for one campaign
    _evaluator = Evaluator(plan)
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()  # a parent that was killed ends nobody
    os._exit(1)


def evaluate(job: Job) -> dict[str, Any]:
    """Fly a job of the plan that this worker has, and return its row."""
    assert _evaluator is not None
    return _evaluator(job)


def row_of(variant: Variant, job: Job) -> dict[str, Any]:
    """Return the row of a flight of which nothing is known yet: an error."""
    return {
        "case": job.case,
        "controller": variant.controller,
        "plant": variant.plant,
        "aircraft": variant.aircraft,
        **job.values,
        "outcome": ERROR,
        PLACE: job.variant,
    }


def _results(result: FlightResult, success: Mapping[str, float] | None) -> dict[str, Any]:
    verdict, outcome = result.verdict, result.outcome
    assert verdict is not None  # no user ends a single flight of a campaign
    axes = {f"{axis}_{metric.name}": result.axes[axis].get(metric.name) for axis in AXES for metric in METRICS}
    return {
        "outcome": verdict.outcome,
        "success": verdict.outcome == SURVIVED if success is None else succeeded(result, success),
        "margin": verdict.margin,
        "limiting": verdict.limiting,
        **axes,
        "ended_at_s": outcome.ended_at_s,
        "reason": outcome.ended_because,
        "wall_loop_s": outcome.wall_s,
    }


def succeeded(result: FlightResult, success: Mapping[str, float]) -> bool:
    """Return whether a flight completed, and every metric named is at most its limit on every controlled axis."""
    controlled = controlled_of(result.axes)
    axes = [axis for axis, own in zip(AXES, controlled, strict=True) if own]
    values = [(result.axes[axis][name], limit) for axis in axes for name, limit in success.items()]
    return result.outcome.completed and all(value is not None and value <= limit for value, limit in values)


def history_name(variants: Sequence[Variant], case: int, place: int) -> str:
    """Return the name of a flight's history: its case and the name of its variant."""
    return f"{case:06d}-{names_of(variants)[place]}.parquet"


def _short(error: InputError) -> str:
    return f"{error.where}: found {error.found}, expected {error.expected}"[:500]
