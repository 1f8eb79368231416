"""Flights in worker processes, each with a time limit; a worker that dies costs its flight, not the campaign.

A pebble pool of fresh interpreters (JSBSim's logger belongs to the process that made it), one future a flight, a few
flights ahead of the workers and no more, so that memory does not grow with their number. A flight whose worker died is
flown once more, as something outside may have ended it; one that ends its worker twice is an error, and so is one that
takes too long.
"""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures import TimeoutError as FutureTimeoutError
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from pebble import ProcessExpired, ProcessPool

from uavftc.jobs.campaign.evaluate import Job, Plan, evaluate, late, prepare, row_of
from uavftc.jobs.campaign.pool import ctrl_c_is_for_this_process
from uavftc.results.hold import Hold

AHEAD = 4  # flights given to the pool for each worker
GRACE_S = 30.0  # beyond the time limit, for a worker to start: if nothing has come back by then, nothing will
POOLS = 3  # in a row from which nothing came back, until the campaign is given up
TRIES = 2  # of a flight whose worker died


class LocalEngine:
    """Flies jobs in worker processes; as a context manager it ends them all when it is left.

    Parameters
    ----------
    plan
        What all flights share.
    workers
        Processes.
    timeout_s
        Wall-clock limit of one flight.
    """

    def __init__(self, plan: Plan, workers: int, timeout_s: float) -> None:
        self._plan, self._workers, self._timeout_s = plan, workers, timeout_s
        self._pool: ProcessPool | None = None
        self._broken = False
        self._flying: dict[Future[dict[str, Any]], tuple[Job, int]] = {}

    def __enter__(self) -> LocalEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def fly(self, jobs: Iterator[Job]) -> Iterator[dict[str, Any] | None]:
        """Yield the row of each flight as it ends, in no order, and None now and then while there is none."""
        try:
            yield from self._fly(jobs)
        finally:
            for future in self._flying:  # left before all had ended: what runs may end, and nobody looks at it
                if not future.running():
                    future.cancel()
            self._flying.clear()

    def _fly(self, jobs: Iterator[Job]) -> Iterator[dict[str, Any] | None]:
        more, lost = True, 0
        heard = time.monotonic()
        while True:
            while more and len(self._flying) < AHEAD * self._workers:
                job = next(jobs, None)
                if job is None:
                    more = False
                else:
                    self._give(job, 1)
            if not self._flying:
                return
            done, _ = wait(self._flying, timeout=0.5, return_when=FIRST_COMPLETED)
            if not done:
                yield None
            for future in done:
                row = self._taken(future)
                if row is not None:
                    lost, heard = 0, time.monotonic()
                    yield row
            # pebble can lose a flight given to a worker that died at that moment, or break when an idle one dies
            if self._broken or time.monotonic() - heard > self._timeout_s + GRACE_S:
                lost += 1
                if lost == POOLS:
                    raise RuntimeError("the worker processes end before they fly anything")
                self._again()
                heard = time.monotonic()

    def _give(self, job: Job, attempt: int) -> None:
        future: Future[dict[str, Any]] = Future()
        with Hold(signal.SIGINT), ctrl_c_is_for_this_process():  # the workers start within, later ones from its threads
            if self._pool is None:
                context = multiprocessing.get_context("spawn")
                self._pool = ProcessPool(self._workers, initializer=prepare, initargs=(self._plan,), context=context)
            try:
                future = self._pool.schedule(evaluate, args=(job,), timeout=self._timeout_s)
            except RuntimeError:
                self._broken = True  # the flight waits for the next pool
        self._flying[future] = job, attempt

    def _taken(self, future: Future[dict[str, Any]]) -> dict[str, Any] | None:
        """Return the row of a flight that ended, or None where it is flown again."""
        job, attempt = self._flying.pop(future)
        try:
            return future.result()
        except BrokenProcessPool:
            self._broken = True
            self._flying[Future()] = job, attempt
            return None
        except (FutureTimeoutError, TimeoutError):
            reason = late(self._timeout_s)
        except ProcessExpired as error:
            if attempt < TRIES:
                self._give(job, attempt + 1)
                return None
            reason = f"its process ended twice, {_how(error.exitcode)}"
        except CancelledError:
            self._give(job, attempt)
            return None
        except Exception as error:  # a bug of ours or of a custom controller, as the row says
            reason = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"
        return {**row_of(self._plan.variants[job.variant], job), "reason": reason}

    def _again(self) -> None:
        """Give everything that is outstanding to a new pool."""
        outstanding = list(self._flying.values())
        self._end()
        self._broken = False
        for job, attempt in outstanding:
            self._give(job, attempt)

    def _end(self) -> None:
        pool, self._pool = self._pool, None
        self._flying.clear()
        if pool is not None:
            pool.stop()
            pool.join()


def _how(code: int | None) -> str:
    if code is not None and code < 0:
        try:
            return f"by {signal.Signals(-code).name}"
        except ValueError:
            pass
    return f"with exit code {code}"
