"""Measuring: jobs in turn, one round after another, and the results as a figure."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

Job = Callable[[], float]
"""Prepares what it needs, does it, and returns the seconds that the part to be measured took."""


class NotMeasuredError(Exception):
    """Raised by a job that cannot be done here; its text becomes the figure's reason."""


class Bar(NamedTuple):
    """What a figure has to reach."""

    limit: float
    at_least: bool = False
    """The limit is the least; otherwise the most."""

    def met(self, value: float) -> bool:
        """Whether a value reaches the bar."""
        return value >= self.limit if self.at_least else value <= self.limit


class Figure(NamedTuple):
    """One measured figure: its value in every round, or the reason why there is none."""

    values: Sequence[float]
    details: dict[str, Any] = {}  # noqa: RUF012 - never written to
    reason: str | None = None

    def document(self, bar: Bar | None = None) -> dict[str, Any]:
        """Return the figure as `uavftc bench --json` prints it."""
        if self.reason is not None:
            return {"median": None, "spread": None, "reason": self.reason}
        median = statistics.median(self.values)
        document: dict[str, Any] = {"median": median, "spread": [min(self.values), max(self.values)]}
        if bar is not None:
            document |= {"at_least" if bar.at_least else "at_most": bar.limit, "met": bar.met(median)}
        return document | self.details


Figures = Figure | dict[str, Figure]
"""A figure, or several of one kind by name."""


def of(values: Sequence[float]) -> dict[str, Any]:
    """Return median and spread, as a detail of a figure."""
    return {"median": statistics.median(values), "spread": [min(values), max(values)]}


def ratios(above: Sequence[float], below: Sequence[float]) -> list[float]:
    """Return the ratio of two jobs, round by round."""
    return [a / b for a, b in zip(above, below, strict=True)]


def alternately(rounds: int, *jobs: Job, warm_up: bool = True) -> list[list[float]]:
    """Return the seconds of each job in each round.

    The jobs of a round follow each other at once, in the opposite order in every second round, so that a machine that
    becomes slower or faster does so for all of them. With `warm_up` one round before the first does not count.
    """
    seconds: list[list[float]] = [[] for _ in jobs]
    if warm_up:
        for job in jobs:
            job()
    order = list(range(len(jobs)))
    for _ in range(rounds):
        for i in order:
            seconds[i].append(jobs[i]())
        order.reverse()
    return seconds


def timed(work: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the seconds that `work` takes, with no garbage collection inside it."""
    with no_collection():
        started = clock()
        work()
        return clock() - started


def computed(work: Callable[[], object]) -> float:
    """Return the seconds that this thread computes during `work`: the wall clock's on an idle machine.

    For work of this thread alone. What other processes take from it on a busy machine does not count.
    """
    return timed(work, _THREAD_CLOCK)


_THREAD_CLOCK = time.thread_time if time.get_clock_info("thread_time").resolution < 1e-6 else time.perf_counter


@contextmanager
def no_collection() -> Iterator[None]:
    """Collect no garbage until the end; between two measurements Python does so by itself."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
