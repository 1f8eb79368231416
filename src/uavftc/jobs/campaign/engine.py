"""Where the flights of a campaign are flown: an engine takes jobs and gives their rows, on this machine or a cluster.

    with engine_of(plan, timeout_s=300.0, workers=2) as engine:     # or cluster="tcp://host:8786"
        for row in engine.fly(jobs): ...                            # as they end; None while nothing has

`fly` may be called again and again; the workers stay. A sweep calls it once. A search calls it for each generation, a
job being `Job(number of the evaluation, place of the variant, {key: value})`, and takes `rows(engine, jobs)`, which are
in the order of the jobs: the same on any engine and any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol

from uavftc.jobs.campaign.evaluate import PLACE, Job, Plan

Row = dict[str, Any]
"""Of the table, by column, with `plant` and `aircraft`; under `HISTORY` the bytes of a history that is kept."""


class Engine(Protocol):
    """What flies; a context manager that ends its workers, or leaves the cluster, when it is left.

    Raises
    ------
    InputError
        When it is entered, if there is no such cluster, or its workers cannot fly the plan.
    """

    def __enter__(self) -> Engine: ...

    def __exit__(self, *_: object) -> None: ...

    def fly(self, jobs: Iterator[Job]) -> Iterator[Row | None]:
        """Yield the row of each job as it ends, in no order, and None now and then while there is none.

        Jobs are taken from the iterator a few ahead of the workers and no more. A flight that cannot be flown, takes
        too long or ends its worker is a row with the outcome `error`.

        Raises
        ------
        RuntimeError
            If the workers end before they fly anything.
        ConnectionError
            If the cluster is gone.
        InputError
            If a worker that joined the cluster is of another version.
        """
        ...


def engine_of(plan: Plan, *, timeout_s: float, workers: int, cluster: str | None = None) -> Engine:
    """Return an engine, to be entered.

    Parameters
    ----------
    plan
        What all flights share.
    timeout_s
        Wall-clock limit of one flight.
    workers
        Processes on this machine; no matter with a cluster.
    cluster
        Address of a Dask scheduler, such as ``tcp://host:8786``; None for this machine.
    """
    if cluster is not None:
        from uavftc.jobs.campaign.cluster import ClusterEngine  # noqa: PLC0415

        return ClusterEngine(plan, cluster, timeout_s)
    from uavftc.jobs.campaign.local import LocalEngine  # noqa: PLC0415

    return LocalEngine(plan, workers, timeout_s)


def rows(engine: Engine, jobs: Iterable[Job], heard: Callable[[Row | None], None] | None = None) -> list[Row]:
    """Fly jobs and return their rows in the order of the jobs; no two may have the same case and variant.

    `heard` is called with each row as it ends, and with None now and then while there is none.
    """
    asked = list(jobs)
    found: dict[tuple[int, int], Row] = {}
    for row in engine.fly(iter(asked)):
        if heard is not None:
            heard(row)
        if row is not None:
            found[row["case"], row[PLACE]] = row
    return [found[job.case, job.variant] for job in asked]
