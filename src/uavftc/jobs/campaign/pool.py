"""Many flights in parallel processes, each a function of its scenario alone."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager

import numpy as np

from uavftc.analysis.metrics import metrics_of
from uavftc.flight.build import Flight, build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.flight.trusted import TrustedRange
from uavftc.results.flight import FlightResult, notes_of, origin_of
from uavftc.results.hold import Hold
from uavftc.scenario.schema import Scenario

WORTH_A_POOL = 8  # flights; a worker starts in about two seconds, a flight takes a fraction of one


Flown = FlightResult
"""What is kept of each flight."""


def fly_one(scenario: Scenario, keep_history: bool = True) -> FlightResult:
    """Fly a scenario in this process and return what is kept of it.

    Raises
    ------
    InputError
        If it cannot be flown.
    KeyboardInterrupt
        On Ctrl-C: each flight of many is kept whole or not at all.
    """
    flight = build_flight(scenario)
    origin = origin_of(flight)
    records, result = judged(flight)
    trusted = TrustedRange(flight.aircraft.trusted)
    trusted.take(records)
    history = published(records, flight.columns) if keep_history else None
    return result._replace(history=history, origin=origin, remarks=(*notes_of(flight), *trusted.remarks()))


def judged(flight: Flight, stop: Callable[[], bool] | None = None) -> tuple[np.ndarray, FlightResult]:
    """Fly a flight and return its rows and what came of it, without history, origin and remarks.

    It ends where `stop` returns true, as an interrupted one.

    Raises
    ------
    KeyboardInterrupt
        On Ctrl-C.
    """
    records, outcome = fly_to_memory(flight, stop)
    axes = metrics_of(records, completed=outcome.completed, controlled=flight.given.axes)
    monitor = flight.monitor()
    monitor.take(records)
    return records, FlightResult(
        flight.scenario, outcome, axes, None, {}, layout=flight.layout, met=tuple(monitor.found())
    )


def _fly_some(scenarios: Sequence[Scenario], keep_history: bool) -> list[FlightResult]:
    return [fly_one(scenario, keep_history) for scenario in scenarios]


def fly_all(
    scenarios: Sequence[Scenario],
    *,
    keep_history: bool = True,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> list[FlightResult]:
    """Fly all scenarios and return what is kept of each, in their order; the result does not depend on `workers`.

    Parameters
    ----------
    scenarios
        What to fly.
    keep_history
        Whether to return the histories.
    workers
        Processes; by default as many as cores, and no other than this one for a handful of flights.
    progress
        Called with the number of flights done.

    Raises
    ------
    InputError
        Of the first scenario, in their order, that cannot be flown.
    """
    workers = min(workers or os.cpu_count() or 1, len(scenarios))
    done: list[FlightResult] = []
    if workers < 2 or len(scenarios) < WORTH_A_POOL:
        for scenario in scenarios:
            done.append(fly_one(scenario, keep_history))
            if progress is not None:
                progress(len(done))
        return done
    # The first flight here compiles what the workers then find in the cache.
    done.append(fly_one(scenarios[0], keep_history))
    rest = scenarios[1:]
    # A fresh interpreter for each worker: JSBSim's logger belongs to the process that made it.
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        chunk = max(1, len(rest) // (8 * workers))
        try:
            with Hold(signal.SIGINT), ctrl_c_is_for_this_process():  # the workers start within, all of them
                flying = [pool.submit(_fly_some, rest[i : i + chunk], keep_history) for i in range(0, len(rest), chunk)]
            for some in flying:
                done += some.result()
                if progress is not None:
                    progress(len(done))
        except BaseException:
            # Ended, not cancelled: the pool's thread would stumble over a future that was cancelled, with a traceback.
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
    return done


@contextmanager
def ctrl_c_is_for_this_process() -> Iterator[None]:
    """Let what is started within never see a Ctrl-C, which a terminal sends to all: this process ends them itself.

    A process begins with the signals blocked that were blocked where it was started, even before its imports.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
