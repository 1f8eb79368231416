"""A campaign searched for what breaks its controllers, each by a search of its own, into a folder that can be left.

campaign.json      what is searched, and how; it is there first
search.parquet     the trace: a row a flight
found.yaml         the scenario found; with several controllers the worst of theirs, and found-NAME.yaml of each
lowest-NAME.yaml   of a controller that nothing broke, its flight of the lowest margin
figures/           how the searches went, and what they found
summary.json       what they found, and the checksum of each file; it is there last
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from uavftc.analysis.verdict import SURVIVED
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.jobs.campaign.engine import Engine, engine_of
from uavftc.jobs.campaign.engine import rows as flown_by
from uavftc.jobs.campaign.evaluate import PLACE, Job, Plan
from uavftc.jobs.campaign.identity import identity
from uavftc.jobs.campaign.kept import Kept
from uavftc.jobs.campaign.pool import judged
from uavftc.jobs.campaign.sweep import Progress, Ready, usable_cores
from uavftc.jobs.campaign.table import whole
from uavftc.jobs.campaign.variants import names_of
from uavftc.jobs.falsify.document import has_failed, search_of, worst_of
from uavftc.jobs.falsify.nearest import Nearest
from uavftc.jobs.falsify.search import Ask, Search, Told, load_cma
from uavftc.jobs.falsify.space import Space
from uavftc.jobs.falsify.trace import Row, Trace
from uavftc.results import manifest
from uavftc.results.folder import FULL
from uavftc.scenario.changed import changed
from uavftc.scenario.load import load_scenario
from uavftc.scenario.text import scenario_text

OBJECTIVES: Mapping[str, type[Search]] = {"margin": Search, "nearest": Nearest}
STRAIN = tuple(f"{axis}_iae" for axis in AXES)
"""Columns whose sum guides a search."""
FOUND, FIGURES = "found.yaml", "figures"


class Asked(NamedTuple):
    """How a campaign is searched."""

    objective: str
    """One of `OBJECTIVES`."""
    budget: int
    """Flights of each controller, on each plant and with each aircraft."""
    seed: int


class Falsify:
    """The searches of a campaign and the folder they are written into.

    Parameters
    ----------
    made
        From `sweep.ready`.
    out
        The folder; an older result in it is replaced if it is ours and complete.
    asked
        How it is searched.
    resume
        Go on with what is there.
    inputs
        Files that the campaign came from; a folder that holds one of them is not replaced.

    Raises
    ------
    InputError
        If nothing varies, no requirement can break, or the package `cma` is missing.
    """

    def __init__(
        self, made: Ready, out: Path, asked: Asked, *, resume: bool = False, inputs: Sequence[Path] = ()
    ) -> None:
        load_cma()
        self.made, self.asked, self._resume = made, asked, resume
        self.spaces = [Space(made.campaign, variant.scenario) for variant in made.variants]
        self.searches = [OBJECTIVES[asked.objective](space, asked.budget, asked.seed) for space in self.spaces]
        for variant in made.variants:
            if variant.scenario.requirements == ():
                raise InputError(
                    variant.scenario.origin.where(("requirements",)),
                    found="none",
                    expected="at least one requirement, so that a verdict can change",
                    remedy="leave requirements out for the default set",
                )
        self._kept = Kept(out, resume=resume, inputs=inputs)
        self.folder = self._kept.path
        self.done, self.failures = 0, 0
        self.unlike: list[str] = []
        """Scenarios that flew to another margin alone: their controller keeps something from flight to flight."""

    @property
    def begun(self) -> bool:
        """Whether something was written into the folder."""
        return self._kept.begun

    def fly(
        self,
        *,
        workers: int | None = None,
        cluster: str | None = None,
        figures: bool = True,
        progress: Progress | None = None,
    ) -> dict[str, Any]:
        """Search and return the document of `summary.json`; what is in the trace is not flown again.

        Parameters
        ----------
        workers
            Processes on this machine; as many as cores where it is None. What is found does not depend on it.
        cluster
            Address of a Dask scheduler that flies instead.
        figures
            Whether to draw.
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
        document = {**identity(self.made.campaign, self.made.variants), "falsify": self.asked._asdict()}
        document["versions"]["cma"] = metadata.version("cma")
        self._kept.look(document)
        with self._kept as kept:
            if (summary := kept.finished(document)) is not None:
                return summary
            kept.begin(document)
            trace = Trace(self.folder, self.made.campaign, self.made.variants)
            if self._resume:
                trace.read()
            plan = Plan(self.made.variants, None, "none")
            many, limit = workers or usable_cores(), self.made.campaign.timeout_s
            try:
                with engine_of(plan, timeout_s=limit, workers=many, cluster=cluster) as engine:
                    self._search(engine, trace, progress or _silent)
            finally:
                trace.flush(now=True)
            return self._end(trace, document, figures)

    def _search(self, engine: Engine, trace: Trace, progress: Progress) -> None:
        """Let all searches go on batch by batch, each with its own results, the batches flown together."""
        running = [search.batches() for search in self.searches]
        counts = [0] * len(running)
        waiting: dict[int, list[Ask]] = {}
        for place, search in enumerate(running):
            if (first := next(search, None)) is not None:
                waiting[place] = first
        while waiting:
            told = self._fly(engine, trace, waiting, counts, progress)
            for place, batch in list(waiting.items()):
                counts[place] += len(batch)
                try:
                    waiting[place] = running[place].send(told[place])
                except StopIteration:
                    del waiting[place]

    def _fly(
        self,
        engine: Engine,
        trace: Trace,
        waiting: Mapping[int, Sequence[Ask]],
        counts: Sequence[int],
        progress: Progress,
    ) -> dict[int, list[Told]]:
        asked = {(place, counts[place] + i): ask for place, batch in waiting.items() for i, ask in enumerate(batch)}
        known = {key: trace.known(*key, ask.values) for key, ask in asked.items()}
        jobs = [Job(flight, place, ask.values) for (place, flight), ask in asked.items() if not known[place, flight]]
        total = sum(self.asked.budget if place in waiting else count for place, count in enumerate(counts))
        for row in known.values():
            if row is not None:
                self._count(row)

        def heard(row: Mapping[str, Any] | None) -> None:
            if row is not None:
                ask = asked[row[PLACE], row["case"]]
                self._count(trace.add(row, ask.stage, ask.distance))
                trace.flush()
            progress(self.done, total, self.failures)

        flown_by(engine, jobs, heard)
        trace.flush()
        found: dict[int, list[Told]] = {place: [] for place in waiting}
        for (place, flight), ask in asked.items():
            row = trace.known(place, flight, ask.values)
            assert row is not None
            found[place].append(Told(row["margin"], has_failed(row), sum(row[name] or 0.0 for name in STRAIN)))
        return found

    def _count(self, row: Row) -> None:
        self.done += 1
        self.failures += has_failed(row)

    def _end(self, trace: Trace, document: Mapping[str, Any], figures: bool) -> dict[str, Any]:
        """Write what was found and the summary, which makes the searches complete."""
        objective, campaign = self.asked.objective, self.made.campaign
        searches = [
            search_of(variant, search, trace.rows(place), objective)
            for place, (variant, search) in enumerate(zip(self.made.variants, self.searches, strict=True))
        ]
        worst = worst_of(searches, objective)
        for place, (name, one) in enumerate(zip(names_of(self.made.variants), searches, strict=True)):
            if one["found"] is not None:
                alone = FOUND if len(searches) == 1 else f"found-{name}.yaml"
                one["file"] = self._write(alone, place, one["found"], "the failure")
                if one is worst and alone != FOUND:
                    self._write(FOUND, place, one["found"], "the failure")
            elif one["lowest"] is not None:
                one["file"] = self._write(f"lowest-{name}.yaml", place, one["lowest"], "no failure, but the flight")
        summary: dict[str, Any] = {
            "campaign": campaign.name,
            **self.asked._asdict(),
            "found": None if worst is None else {"controller": worst["controller"], "file": FOUND, **worst["found"]},
            "searches": searches,
        }
        if figures:
            missing = self._draw(trace, summary)
            if missing is not None:
                summary["figures_missing"] = missing
        summary["provenance"] = {**document["versions"], "campaign_sha256": document["campaign_sha256"]}
        return self._kept.complete(summary, manifest.checksums(self.folder))

    def _write(self, name: str, place: int, entry: Mapping[str, Any], what: str) -> str:
        """Write a flight as a scenario that flies alone, and make sure that it does so, to the same margin."""
        how = "lowest margin" if self.asked.objective == "margin" or entry["outcome"] == SURVIVED else "least distance"
        said = f"{what} of the {how} among {len(self.searches[place].flown)} flights of uavftc falsify"
        said = f"{self.made.campaign.name}: {said}; margin {entry['margin']:.4g}, {entry['distance']:.4g} from nominal."
        more = {"name": f"{self.made.campaign.name}-{Path(name).stem}", "description": said}
        scenario = changed(self.made.variants[place].scenario, {**entry["values"], **more})
        with whole(self.folder / name) as stream:
            stream.write(scenario_text(scenario).encode())
        _, alone = judged(build_flight(load_scenario(self.folder / name)))
        if alone.verdict is None or alone.verdict.margin != entry["margin"]:
            self.unlike.append(name)
        return name

    def _draw(self, trace: Trace, summary: Mapping[str, Any]) -> str | None:
        """Draw the figures; where there is no room for them, leave none and return why."""
        from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

        load_matplotlib()
        from uavftc.report.falsify_figure import write_falsify_figure  # noqa: PLC0415

        folder = self.folder / FIGURES
        try:
            folder.mkdir(exist_ok=True)
            for place, (name, one) in enumerate(zip(names_of(self.made.variants), summary["searches"], strict=True)):
                title = f"{summary['campaign']}: {self.made.variants[place].title}"
                file = folder / (f"falsify-{name}.png" if len(summary["searches"]) > 1 else "falsify.png")
                write_falsify_figure(file, title, trace.rows(place), one)
        except OSError as error:
            shutil.rmtree(folder, ignore_errors=True)
            if error.errno in FULL:
                return os.strerror(error.errno or 0)
            raise
        return None


def _silent(done: int, total: int, failures: int) -> None:
    pass
