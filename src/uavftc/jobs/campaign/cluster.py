"""Flights on a Dask cluster: the same jobs, the same rows.

A plugin that the client registers makes every worker ready: on its main thread, since JSBSim's logger is installed on
no other, and only if code, versions, aircraft and controllers there are those of the client. A flight is a task; a few
for each thread of the cluster are given to it ahead and no more, so that memory does not grow with their number. A
worker flies one at a time, however many threads it has.

Dask flies again what was on a worker that ended, and gives up what was on four of them, together with what merely
waited there: that is flown once more, alone, at the end. Dask ends no task that runs: the loop of a flight looks at the
clock itself, and a flight that hangs elsewhere ends its worker, a while after its time.
"""

from __future__ import annotations

import faulthandler
import logging
import math
import queue
import threading
import time
import uuid
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import islice
from typing import Any

from uavftc.errors import InputError
from uavftc.jobs.campaign.evaluate import Evaluator, Job, Plan, row_of
from uavftc.jobs.campaign.identity import differences, of_variants, versions

try:
    from distributed import Client, KilledWorker, WorkerPlugin, get_worker
except ImportError:
    raise InputError(
        "--cluster",
        found="no package distributed",
        expected="Dask, the extra `campaign`",
        remedy='pip install "uavftc[campaign]"',
    ) from None

AHEAD = 6  # flights given to the cluster for each thread
LEAST_AHEAD = 8  # whatever its size
CONNECT_S = 10.0
WORKERS_S = 30.0  # until the first worker is there
TRIES = 3  # to make the workers ready
SIZE_S = 5.0  # between two looks at the cluster's size
GRACE_S = 60.0  # beyond the time limit, after which a flight that hangs ends its worker: it may compile before


class Prepared(WorkerPlugin):
    """What a worker has for one plan.

    Parameters
    ----------
    plan
        What it flies.
    limit_s
        Wall-clock limit of the loop of one flight.
    end_s
        And of a whole flight, wherever it hangs: it ends the worker.
    asked
        What code, versions, aircraft and controllers of the worker have to be.
    """

    def __init__(self, plan: Plan, limit_s: float, end_s: float, asked: Mapping[str, Any]) -> None:
        self._plan, self._limit_s, self._asked = plan, limit_s, asked
        self._end_s = min(end_s, threading.TIMEOUT_MAX)
        self._evaluator: Evaluator | None = None
        self._refused: InputError | None = None
        self.name = f"uavftc-{uuid.uuid4().hex}"

    def setup(self, worker: Any) -> None:
        """Make the worker ready.

        Raises
        ------
        InputError
            If it has something else than the client.
        """
        from uavftc.plants.jsbsim.load import prepare_process  # noqa: PLC0415

        self._one_at_a_time = threading.Lock()
        try:
            found = list(
                differences(self._asked, {"versions": versions(), "variants": of_variants(self._plan.variants)})
            )
            if found:
                raise InputError(
                    f"worker {worker.address}",
                    found="; ".join(found),
                    expected="what this machine has, so that all rows are of one campaign",
                    remedy="install the same versions there, at the same paths where the campaign names paths",
                )
        except InputError as error:
            self._refused = error
            raise
        prepare_process()
        self._evaluator = Evaluator(self._plan, self._limit_s)

    def fly(self, job: Job) -> dict[str, Any]:
        """Fly a job."""
        if self._refused is not None:
            raise self._refused
        assert self._evaluator is not None
        with self._one_at_a_time:
            faulthandler.dump_traceback_later(self._end_s, exit=True)
            try:
                return self._evaluator(job)
            finally:
                faulthandler.cancel_dump_traceback_later()


def fly_here(job: Job, name: str) -> dict[str, Any]:
    """Fly a job on the worker that this is, by the plugin of this name."""
    plugin = get_worker().plugins[name]
    assert isinstance(plugin, Prepared)
    return plugin.fly(job)


class ClusterEngine:
    """Flies jobs on a Dask cluster.

    Parameters
    ----------
    plan
        What all flights share.
    address
        Of the scheduler, such as ``tcp://host:8786``.
    timeout_s
        Wall-clock limit of one flight.
    """

    def __init__(self, plan: Plan, address: str, timeout_s: float) -> None:
        self._plan, self._address, self._timeout_s = plan, address, timeout_s
        self._client: Client | None = None
        self._name = ""
        self._flying: dict[Any, Job] = {}
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._sized_at, self._ahead = -math.inf, LEAST_AHEAD

    def __enter__(self) -> ClusterEngine:
        for name in ("distributed", "distributed.client"):  # what matters is said by our errors
            logging.getLogger(name).setLevel(logging.CRITICAL)
        try:
            self._client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            reason = " ".join(str(error).split())[:200]
            raise self._error(
                f"no scheduler there: {reason}",
                "the address of a Dask scheduler, such as tcp://host:8786",
                "start one (dask scheduler), or check the address that it shows",
            ) from None
        try:
            self._prepare(self._client)
        except BaseException:
            self._leave()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._leave()

    def _prepare(self, client: Client) -> None:
        try:
            client.wait_for_workers(1, timeout=WORKERS_S)
        except TimeoutError:
            raise self._error(
                f"a scheduler without workers for {WORKERS_S:g} s",
                "one worker or more",
                f"start some (dask worker {self._address} --nthreads 1)",
            ) from None
        asked = {"versions": versions(), "variants": of_variants(self._plan.variants)}
        plugin = Prepared(self._plan, self._timeout_s, self._timeout_s + GRACE_S, asked)
        self._name = plugin.name
        for attempt in range(1, TRIES + 1):
            try:
                client.register_plugin(plugin)
                return
            except InputError as error:
                raise self._refused(error) from None
            except Exception as error:  # whatever may be wrong there, such as no uavftc
                if isinstance(error, OSError) and attempt < TRIES:  # a worker that ended while it was made ready
                    time.sleep(1.0)
                    continue
                reason = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
                raise self._error(
                    f"a worker that cannot be made ready: {reason}",
                    "workers that have what this machine has",
                    'pip install "uavftc[campaign]" there, in the same version',
                ) from None

    def fly(self, jobs: Iterator[Job]) -> Iterator[dict[str, Any] | None]:
        """Yield the row of each job as it ends; as every engine does."""
        suspects: list[Job] = []
        try:
            yield from self._fly(jobs, suspects)
            while suspects:  # one after the other: what ends its worker then does so by itself
                last: list[Job] = []
                suspect = suspects.pop()
                yield from self._fly(iter([suspect]), last)
                if last:
                    yield self._failed(suspect, "its worker ended again and again (KilledWorker)")
        except OSError as error:  # what the client raises in the middle of whatever it does
            raise ConnectionError(f"the cluster at {self._address} is gone") from error
        finally:
            self._forget()

    def _fly(self, jobs: Iterator[Job], suspects: list[Job]) -> Iterator[dict[str, Any] | None]:
        more = True
        while True:
            free = self._window() - len(self._flying)
            if more and free > 0:
                taken = list(islice(jobs, free))
                more = len(taken) == free
                self._give(taken)
            if not self._flying:
                return
            ended = self._await()
            if not ended:
                yield None
            yield from self._taken(ended, suspects)

    def _give(self, jobs: list[Job]) -> None:
        assert self._client is not None
        for future, job in zip(self._client.map(fly_here, jobs, name=self._name, pure=False), jobs, strict=True):
            self._flying[future] = job
            future.add_done_callback(self._ended.put)

    def _await(self) -> list[Any]:
        """Return the futures that have ended, once there are any; none after a moment without."""
        ended: list[Any] = []
        with suppress(queue.Empty):
            ended.append(self._ended.get(timeout=0.5))
            while True:
                ended.append(self._ended.get_nowait())
        return [future for future in ended if future in self._flying]

    def _taken(self, ended: list[Any], suspects: list[Job]) -> Iterator[dict[str, Any]]:
        """Yield the rows of flights that ended, and note those that Dask has given up."""
        assert self._client is not None
        done = [future for future in ended if future.status == "finished"]
        for future, row in zip(done, self._client.gather(done), strict=True):
            del self._flying[future]
            yield row
        for future in ended:
            if future.status == "finished":
                continue
            job = self._flying.pop(future)
            error = future.exception() if future.status == "error" else None
            if isinstance(error, InputError):
                raise self._refused(error)
            if isinstance(error, KilledWorker):
                suspects.append(job)
            elif error is not None:
                yield self._failed(job, f"{type(error).__name__}: {' '.join(str(error).split())[:300]}")
            elif self._client.status != "running":
                raise ConnectionError(f"the cluster at {self._address} is gone")
            else:  # cancelled: the scheduler was away for a moment, and knows it no more
                self._give([job])

    def _failed(self, job: Job, reason: str) -> dict[str, Any]:
        return {**row_of(self._plan.variants[job.variant], job), "reason": reason}

    def _window(self) -> int:
        """Return how many flights may be with the cluster."""
        assert self._client is not None
        if time.monotonic() - self._sized_at > SIZE_S:
            threads = sum(self._client.nthreads().values())
            self._ahead, self._sized_at = max(LEAST_AHEAD, AHEAD * threads), time.monotonic()
        return self._ahead

    def _forget(self) -> None:
        """Cancel what was left before it ended."""
        flying = list(self._flying)
        self._flying.clear()
        if flying and self._client is not None and self._client.status == "running":
            with suppress(Exception):
                self._client.cancel(flying)

    def _leave(self) -> None:
        client, self._client = self._client, None
        if client is None:
            return
        with suppress(Exception):  # a cluster that is gone has nothing to be left
            if self._name:
                client.unregister_worker_plugin(self._name)
        with suppress(Exception):
            client.close(timeout=CONNECT_S)

    def _refused(self, error: InputError) -> InputError:
        return self._error(f"{error.where} with {error.found}", error.expected, error.remedy)

    def _error(self, found: str, expected: str, remedy: str) -> InputError:
        return InputError(f"--cluster {self._address}", found=found, expected=expected, remedy=remedy)
