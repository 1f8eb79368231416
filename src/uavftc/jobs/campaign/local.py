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
from typing import Any

from pebble import ProcessExpired, ProcessPool

from uavftc.jobs.campaign.evaluate import Job, Plan, evaluate, prepare, row_of
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
        self._flying: dict[Future[dict[str, Any]], tuple[Job, int]] = {}

    def __enter__(self) -> LocalEngine:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def fly(self, jobs: Iterator[Job]) -> Iterator[dict[str, Any] | None]:
        """Yield the row of each flight as it ends, in no order, and None now and then while there is none."""
        more, silent = True, 0
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
            if done:
                heard = time.monotonic()
                silent = 0
            elif time.monotonic() - heard > self._timeout_s + GRACE_S:
                silent += 1
                if silent == POOLS:
                    raise RuntimeError("the worker processes end before they fly anything")
                self._again()  # pebble can lose a flight given to a worker that died at that moment
                heard = time.monotonic()
            else:
                yield None
            for future in done:
                row = self._taken(future)
                if row is not None:
                    yield row

    def _give(self, job: Job, attempt: int) -> None:
        with Hold(signal.SIGINT), ctrl_c_is_for_this_process():  # the workers start within, later ones from its threads
            if self._pool is None:
                context = multiprocessing.get_context("spawn")
                self._pool = ProcessPool(self._workers, initializer=prepare, initargs=(self._plan,), context=context)
            future = self._pool.schedule(evaluate, args=(job,), timeout=self._timeout_s)
        self._flying[future] = job, attempt

    def _taken(self, future: Future[dict[str, Any]]) -> dict[str, Any] | None:
        """Return the row of a flight that ended, or None where it is flown again."""
        job, attempt = self._flying.pop(future)
        try:
            return future.result()
        except (FutureTimeoutError, TimeoutError):
            reason = f"not done within {self._timeout_s:g} s"
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
