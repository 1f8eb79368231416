"""A campaign flown: into a folder that can be left at any moment and gone on with, and sorted when it is complete.

campaign.json      what the campaign is; it is there first
parts/             rows of the flights that ended, until all have
scenarios/         what the cases change, one file a variant
histories/         of the flights that keep theirs
flights.parquet    the sorted table, when all flights have ended
summary.json       how they ended, and the checksum of each file; it is there last
"""

from __future__ import annotations

import heapq
import os
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavftc.jobs.campaign.cases import Cases
from uavftc.jobs.campaign.engine import Engine, Row, engine_of
from uavftc.jobs.campaign.evaluate import HISTORY, PLACE, Job, Plan, history_name
from uavftc.jobs.campaign.identity import identity
from uavftc.jobs.campaign.kept import Kept
from uavftc.jobs.campaign.narrow import Narrow, refuse_counted, remove_later
from uavftc.jobs.campaign.scenarios import write_scenarios
from uavftc.jobs.campaign.table import HISTORIES, PARTS, Table, clear_parts, schema_of, whole
from uavftc.jobs.campaign.variants import Variant, refuse, variants_of
from uavftc.results import manifest
from uavftc.results.hold import Hold
from uavftc.scenario.campaign import Campaign, Worst

PART_ROWS = 2000  # rows in a part at most
PART_S = 5.0  # time after which a part is written: what a killed campaign loses

Progress = Callable[[int, int, int], None]
"""Called with flights done, how many there are, and failures so far."""


class Ready(NamedTuple):
    """A campaign that is checked."""

    campaign: Campaign
    variants: list[Variant]
    cases: Cases

    @property
    def flights(self) -> int:
        """How many flights it has."""
        return self.cases.count * len(self.variants)


def ready(campaign: Campaign) -> Ready:
    """Return a campaign with its variants and cases, after its first case and the ends of its ranges were tried.

    Raises
    ------
    InputError
        If anything is wrong with it.
    """
    made = Ready(campaign, variants_of(campaign), Cases(campaign))
    refuse(campaign, made.variants, made.cases)
    return made


class Sweep:
    """A campaign and the folder it is flown into.

    Parameters
    ----------
    made
        From `ready`.
    out
        The folder; an older result in it is replaced if it is ours and complete.
    resume
        Go on with what is there.
    inputs
        Files that the campaign came from; a folder that holds one of them is not replaced.
    until_width
        Width of the interval of success, of each variant, with which the campaign ends; None for all cases.

    Attributes
    ----------
    done, kept
        Flights that ended, and those of them that are on disk, once `fly` was left.
    torn
        Parts that were thrown away, and flown again.
    """

    def __init__(
        self,
        made: Ready,
        out: Path,
        *,
        resume: bool = False,
        inputs: tuple[Path, ...] = (),
        until_width: float | None = None,
    ) -> None:
        self.made, self._kept = made, Kept(out, resume=resume, inputs=inputs)
        self.folder = self._kept.path
        self.done, self.kept, self.torn = 0, 0, 0
        self._tally: Counter[tuple[str, str]] = Counter()
        self._succeeded: Counter[str] = Counter()
        histories = made.campaign.histories
        self._keep = histories.worst if isinstance(histories, Worst) else 0
        self._worst: list[tuple[float, int, int]] = []
        self._narrow: Narrow | None = None
        if until_width is not None:
            refuse_counted(made.campaign)
            self._narrow = Narrow(until_width, made.cases.count, len(made.variants))

    def fly(
        self, *, workers: int | None = None, cluster: str | None = None, progress: Progress | None = None
    ) -> dict[str, Any]:
        """Fly what is missing and return the document of `summary.json`.

        Parameters
        ----------
        workers
            Processes on this machine; as many as cores where it is None.
        cluster
            Address of a Dask scheduler that flies instead.
        progress
            Called as flights end, and now and then.

        Raises
        ------
        InputError
            If the folder cannot be written, or holds another campaign; nothing is changed then.
        KeyboardInterrupt
            On Ctrl-C; what was finished is on disk.
        OSError
            If there is no room; what was finished before is on disk.
        """
        document = identity(self.made.campaign, self.made.variants)
        if self._narrow is not None:
            document["until_width"] = self._narrow.asked
        self._kept.look(document)
        with self._kept as kept:
            if (summary := kept.finished(document)) is not None:
                clear_parts(self.folder)
                return summary
            campaign, variants, _ = self.made
            plan = Plan(variants, campaign.success, "none" if self._keep else str(campaign.histories))
            many = workers or usable_cores()
            with engine_of(plan, timeout_s=campaign.timeout_s, workers=many, cluster=cluster) as engine:
                kept.begin(document)
                (self.folder / PARTS).mkdir(exist_ok=True)
                write_scenarios(self.folder, variants)
                table = self._fly(engine, progress or _silent)
            table.merge(self._after or self.made.cases.count)
            return self._end(table, document)

    @property
    def begun(self) -> bool:
        """Whether something was written into the folder."""
        return self._kept.begun

    def _fly(self, engine: Engine, progress: Progress) -> Table:
        campaign, variants, cases = self.made
        table = Table(self.folder, schema_of(campaign), variants)
        flown = np.zeros((cases.count, len(variants)), dtype=bool)
        self.torn = table.read_parts(flown)
        self.done = self.kept = int(flown.sum())
        for controller, outcome, success, margin, case, place in table.outcomes():
            self._count(controller, outcome, success, margin, case, place)
        progress(self.done, self.made.flights, self.failures)
        jobs = (
            Job(case, place, cases.values(case))
            for case in range(cases.count)
            if not flown[case].all()
            for place in range(len(variants))
            if not flown[case, place]
        )
        try:
            if self._after is None:
                self._take(engine.fly(jobs), table, progress)
        except BaseException:
            try:
                with Hold():
                    table.flush()
            finally:
                self.kept = self.done - table.waiting
            raise
        if self._after is not None:
            self._leave_out_later(table, self._after)
        elif self.done != self.made.flights:
            raise RuntimeError(f"{self.made.flights - self.done} flights came back from no worker")
        self._fly_worst(engine)
        return table

    @property
    def _after(self) -> int | None:
        """The number of cases with which the campaign is over before its last."""
        return self._narrow.after if self._narrow is not None else None

    def _leave_out_later(self, table: Table, cases: int) -> None:
        """Count anew what is kept."""
        self.done = 0
        self._tally.clear()
        self._succeeded.clear()
        self._worst.clear()
        for row in table.outcomes():
            if row[4] < cases:
                self.done += 1
                self._count(*row)
        remove_later(self.folder / HISTORIES, cases)

    def _take(self, rows: Iterator[Row | None], table: Table, progress: Progress) -> None:
        written = time.monotonic()
        for row in rows:
            if row is not None:
                with Hold():
                    self._keep_history(row)
                    table.add(row)
                    self.done += 1
                    counted = (row["controller"], row["outcome"], row.get("success"), row.get("margin"), row["case"])
                    self._count(*counted, row[PLACE])
                if self._after is not None:
                    break
            progress(self.done, self.made.flights, self.failures)
            if table.waiting >= PART_ROWS or (table.waiting and time.monotonic() - written > PART_S):
                with Hold():
                    table.flush()
                written = time.monotonic()
        with Hold():
            table.flush()
        self.kept = self.done

    def _keep_history(self, row: Row) -> None:
        content = row.pop(HISTORY, None)
        if content is not None:
            name = history_name(self.made.variants, row["case"], row[PLACE])
            with whole(self.folder / HISTORIES / name) as stream:
                stream.write(content)

    def _count(
        self, controller: str, outcome: str, success: bool | None, margin: float | None, case: int, place: int
    ) -> None:
        self._tally[controller, outcome] += 1
        self._succeeded[controller] += bool(success)
        if self._narrow is not None:
            self._narrow.take(case, place, success)
        if self._keep and margin is not None:  # a heap of the smallest margins, the greatest of them on top
            push = heapq.heappushpop if len(self._worst) >= self._keep else heapq.heappush
            push(self._worst, (-margin, -case, -place))

    @property
    def failures(self) -> int:
        """Flights so far that are no success."""
        return self.done - sum(self._succeeded.values())

    def _fly_worst(self, engine: Engine) -> None:
        """Fly those with the smallest margins once more, for their histories."""
        worst = sorted(self._worst, reverse=True)
        jobs = (Job(-c, -p, self.made.cases.values(-c), history=True) for _, c, p in worst)
        for row in engine.fly(jobs):
            if row is not None:
                self._keep_history(row)

    def _end(self, table: Table, document: dict[str, Any]) -> dict[str, Any]:
        """Write the summary, which makes the campaign complete, and remove the parts."""
        names = sorted({variant.controller for variant in self.made.variants})
        outcomes = sorted({outcome for _, outcome in self._tally})
        flights = {name: sum(n for (of, _), n in self._tally.items() if of == name) for name in names}
        listed = manifest.checksums(self.folder)
        summary: dict[str, Any] = {
            "campaign": self.made.campaign.name,
            "cases": self._after or self.made.cases.count,
            **({} if self._narrow is None else {"until_width": self._narrow.asked, "narrow": self._after is not None}),
            "flights": self.done,
            "controllers": {
                name: {
                    "flights": flights[name],
                    "success": self._succeeded[name],
                    **{outcome: self._tally[name, outcome] for outcome in outcomes},
                }
                for name in names
            },
            "provenance": {**document["versions"], "campaign_sha256": document["campaign_sha256"]},
        }
        files = {name: sha for name, sha in listed.items() if not name.startswith(f"{PARTS}/")}
        summary = self._kept.complete(summary, files)
        clear_parts(self.folder)
        return summary


def usable_cores() -> int:
    """Return how many cores this process may use."""
    count = getattr(os, "sched_getaffinity", None)
    return len(count(0)) if count is not None else os.cpu_count() or 1


def _silent(done: int, total: int, failures: int) -> None:
    pass
