"""The job of `uavftc survivable`: a flight that is built and not flown, studied, and its result folder."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from uavftc.flight.build import build_flight
from uavftc.jobs.survivable.document import document_of, limiting
from uavftc.jobs.survivable.study import SHARES, Study
from uavftc.results.folder import ResultFolder
from uavftc.scenario.load import scenario_text
from uavftc.scenario.schema import Scenario

Advance = Callable[[int, int, str], None]
"""advance(done, total, label)."""


def survivable(
    scenario: Scenario,
    *,
    within_deg: float = 1.0,
    sweep: bool = True,
    advance: Advance | None = None,
) -> dict[str, Any]:
    """Return whether there is a steady state at the reference of a scenario, phase by phase, as a document.

    Parameters
    ----------
    within_deg
        How near to the reference it must be, deg, of bank and pitch.
    sweep
        Whether the worst phase is looked at, at shares of its faults and, on JSBSim, at other airspeeds too.
    advance
        Told how far it has come.

    Raises
    ------
    InputError
        If the flight cannot be built.
    """
    flight = build_flight(scenario)
    study = Study(flight, math.radians(within_deg))
    total = len(study.phases) + (len(SHARES) + 3 if sweep else 0)
    seen = []
    for i, phase in enumerate(study.phases):
        if advance is not None:
            advance(i, total, "phases")
        seen.append(study.look(phase))
    worst = seen[limiting(seen)]
    speeds = swept = None
    if sweep:
        done = len(seen)
        if worst.question.vehicle.has_flow:
            if advance is not None:
                advance(done, total, "airspeeds")
            speeds = study.speeds(worst)
        done += 3
        if worst.phase.active:

            def told(part: int) -> None:
                nonlocal done
                done += part
                if advance is not None:
                    advance(done, total, "severity")

            points = study.severities(worst, told)
            swept = points, study.ends_at(worst, points)
    return document_of(study, seen, speeds=speeds, swept=swept)


def write_survivable(
    scenario: Scenario,
    out: Path,
    *,
    within_deg: float = 1.0,
    sweep: bool = True,
    figures: bool = True,
    advance: Advance | None = None,
    inputs: Sequence[Path] = (),
) -> dict[str, Any]:
    """Write the result folder of `survivable`, whole or not at all: summary.json, scenario.yaml, figures.

    Returns
    -------
    The document of `summary.json`; with `figures_missing`, the reason, where there was no room for the figure.

    Raises
    ------
    InputError
        If the flight cannot be built or the folder cannot be written; nothing is written then.
    """
    with ResultFolder(out, inputs) as folder:
        document = survivable(scenario, within_deg=within_deg, sweep=sweep, advance=advance)
        (folder.path / "scenario.yaml").write_text(scenario_text(scenario), encoding="utf-8", newline="\n")
        if figures and (document["severity"] or document["airspeeds"]):
            missing = folder.figures(lambda path: draw(path, document))
            if missing is not None:
                document["figures_missing"] = missing
        return folder.write_summary(document)


def draw(folder: Path, document: dict[str, Any]) -> None:
    """Draw the figure of a document into `folder`."""
    from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

    load_matplotlib()
    from uavftc.report.survivable_figure import write_survivable_figure  # noqa: PLC0415

    folder.mkdir()
    write_survivable_figure(folder / "survivable.png", document)
