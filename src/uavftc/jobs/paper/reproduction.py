"""`uavftc reproduce`: everything is flown, set next to the print, and written into one result folder."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from uavftc.jobs.campaign.pool import fly_all
from uavftc.jobs.paper import page as pages
from uavftc.jobs.paper import plan
from uavftc.jobs.paper.findings import Finding, best_scale, conditions, findings
from uavftc.jobs.paper.plan import Flights, Key
from uavftc.jobs.paper.tables import Claim, Row, claims_of, improvements_of, rows_of
from uavftc.jobs.paper.verdicts import verdicts_of
from uavftc.report.backend import load_matplotlib
from uavftc.results.folder import ResultFolder
from uavftc.results.summary import provenance

Advance = Callable[[int, int, str], None]
"""Called with the steps done, the steps there are, and what is going on."""


class Reproduction:
    """The flights of section 4 and what follows from them."""

    def __init__(self, plants: Sequence[str], flights: Flights) -> None:
        self.plants = tuple(plants)
        self.flights = flights
        self.figures_missing: str | None = None  # why, where there was no room for them
        self.rows: list[Row] = []
        self.claims: dict[str, list[Claim]] = {}
        self.findings: list[Finding] = []
        self.scores: dict[str, dict[str, dict[str, float]]] = {}
        for plant in plants:
            paper = plan.of_variant(flights, plant, "paper")
            rows = rows_of(plant, paper)
            best = best_scale(flights, plant)
            fitted = {**paper, **plan.of_variant(flights, plant, "fault scale", best)}
            self.rows += rows
            self.claims[plant] = claims_of(improvements_of(plant, paper), conditions(flights, plant))
            self.findings += findings(flights, plant)
            self.scores[plant] = {
                "as printed (additive fault in deg)": pages.scores_of(rows),
                f"a fit: additive fault times {best:.2f}": pages.scores_of(rows_of(plant, fitted)),
            }


def fly_plan(plants: Sequence[str], advance: Callable[[int, int], None]) -> dict[Key, Any]:
    """Fly everything: the cases and variants with the coarse search, then the fine search around the best scale."""
    first: plan.Plan = {}
    for plant in plants:
        first |= plan.cases(plant) | plan.variants(plant) | plan.scaled(plant, plan.COARSE)
    total = len(first) + len(plants) * 2 * round(plan.FINE_REACH / plan.FINE_STEP)
    flights = dict(zip(first, fly_all(list(first.values()), progress=lambda n: advance(n, total)), strict=True))
    second: plan.Plan = {}
    for plant in plants:
        second |= plan.scaled(plant, plan.finer(best_scale(flights, plant), plan.COARSE))
    flown = fly_all(list(second.values()), progress=lambda n: advance(len(first) + n, total))
    flights |= dict(zip(second, flown, strict=True))
    return flights


def reproduce(plants: Sequence[str], out: Path, *, figures: bool, advance: Advance) -> Reproduction:
    """Fly, compute and write the result folder, whole or not at all.

    Parameters
    ----------
    plants
        `analytic`, `jsbsim` or both.
    out
        The result folder; an older one is replaced if it is ours.
    figures
        Whether to draw Figures 2 to 11.
    advance
        Shown the progress.

    Raises
    ------
    InputError
        If the folder cannot be written; nothing is flown then.
    """
    with ResultFolder(out) as folder:  # from the start, so that two jobs do not fly for one folder
        flights = fly_plan(plants, lambda done, total: advance(done, total, "flying"))
        result = Reproduction(plants, flights)
        drawn: list[str] = []
        captions: dict[int, str] = {}
        if figures:
            load_matplotlib()
            from uavftc.jobs.paper.figures import CAPTIONS, write_figures  # noqa: PLC0415 - imports matplotlib

            def draw(into: Path) -> None:
                for i, plant in enumerate(plants):
                    advance(i, len(plants), f"drawing the figures of {plant}")
                    paths = write_figures(into, plan.of_variant(flights, plant, "paper"), prefix=f"{plant}-")
                    drawn.extend(p.relative_to(folder.path).as_posix() for p in paths if p.suffix == ".png")

            captions = CAPTIONS
            result.figures_missing = folder.figures(draw)
            if result.figures_missing is not None:
                drawn.clear()
        write(folder, result, drawn, captions)
    return result


def write(folder: ResultFolder, result: Reproduction, figures: Sequence[str], captions: dict[int, str]) -> None:
    """Write the documents into an open result folder."""
    improvements = [c.improvement._asdict() | {"answer": c.answer} for cs in result.claims.values() for c in cs]
    text = pages.page(
        result.rows, dict(result.claims), result.findings, result.scores, figures, captions, verdicts_of(result.flights)
    )
    (folder.path / "reproduce.json").write_text(_json_list(result.rows), encoding="utf-8", newline="\n")
    (folder.path / "tables.csv").write_text(_csv(result.rows), encoding="utf-8", newline="")
    (folder.path / "improvements.csv").write_text(_csv(improvements), encoding="utf-8", newline="")
    (folder.path / "reproduction.md").write_text(text, encoding="utf-8", newline="\n")
    folder.write_summary(document_of(result))


def document_of(result: Reproduction) -> dict[str, Any]:
    """Return the document of `summary.json`."""
    some = next(iter(result.flights.values()))
    origin = provenance(seed=some.scenario.seed, scenario_sha256="", aircraft_sha256=None)
    del origin["scenario_sha256"], origin["aircraft_sha256"]  # many scenarios, each with its own
    settings = {
        plant: next(f.settings for k, f in result.flights.items() if k.plant == plant) for plant in result.plants
    }
    return {
        "plants": list(result.plants),
        "flights": len(result.flights),
        "scores": result.scores,
        "verdicts": verdicts_of(result.flights),
        "claims": [
            {**c.improvement._asdict(), "answer": c.answer, "under": c.conditions}
            for claims in result.claims.values()
            for c in claims
        ],
        "findings": [f._asdict() for f in result.findings],
        "provenance": {**origin, "plant_settings": settings},
    }


def _json_list(rows: Sequence[Row]) -> str:
    return "[\n" + ",\n".join(json.dumps(row, allow_nan=False) for row in rows) + "\n]\n"


def _csv(rows: Sequence[dict[str, Any]]) -> str:
    out = io.StringIO()
    writer = csv.DictWriter(out, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: "" if v is None else v for k, v in row.items()} for row in rows)
    return out.getvalue()
