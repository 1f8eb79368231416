"""A mission: a scenario flown, with its result folder on disk."""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.analysis.metrics import Metrics
from uavftc.control.custom.module import checksum
from uavftc.core.signals import SURFACES
from uavftc.flight.build import Flight, build_flight
from uavftc.flight.fly import Outcome, fly
from uavftc.report.table import title_of
from uavftc.results.folder import ResultFolder
from uavftc.results.history import ParquetRecorder, read_history
from uavftc.results.summary import provenance, summary, write_json
from uavftc.scenario.controllers import OwnController
from uavftc.scenario.disturbances import Gust, Turbulence, Wind
from uavftc.scenario.load import controller_name, scenario_text, warnings
from uavftc.scenario.schema import Scenario

Progress = Callable[[int], AbstractContextManager[Callable[[int], None]]]
"""Given the number of rows, a context that yields a function to be told the rows flown so far."""


def fly_mission(
    scenario: Scenario, out: Path, *, figures: bool = True, progress: Progress | None = None
) -> tuple[dict[str, Any], Outcome]:
    """Fly a scenario and write its result folder, whole or not at all.

    Parameters
    ----------
    scenario
        What to fly.
    out
        The result folder; an older one is replaced if it is ours.
    figures
        Whether to draw the figures.
    progress
        Shown while flying.

    Returns
    -------
    The document of `summary.json`, and how the flight ended.

    Raises
    ------
    InputError
        If the aircraft cannot be flown or the folder cannot be written; nothing is written then.
    """
    folder = ResultFolder(out)
    folder.check()
    flight = build_flight(scenario)
    text = scenario_text(flight.scenario)
    origin = origin_of(flight, text)
    metadata = {"scenario": text, **{k: str(v) for k, v in origin.items()}}
    with folder:
        metrics = Metrics()
        history = folder.path / "history.parquet"
        with ParquetRecorder(history, metadata) as parquet:
            if progress is None:
                outcome = fly(flight, [parquet, metrics])
            else:
                with progress(flight.steps + 1) as advance:
                    outcome = fly(flight, [parquet, metrics], advance)
        document = summary_of(flight, outcome, metrics, origin)
        write_json(folder.path / "summary.json", document)
        (folder.path / "scenario.yaml").write_text(text, encoding="utf-8", newline="\n")
        if figures:
            try:
                draw(folder.path, flight, document)
            except KeyboardInterrupt:  # the flight is kept, without its figures
                shutil.rmtree(folder.path / "figures", ignore_errors=True)
                outcome = outcome._replace(interrupted=True)
                document["warnings"].append("interrupted while drawing: the flight is kept, without its figures")
    return document, outcome


def origin_of(flight: Flight, text: str) -> dict[str, Any]:
    """Return the provenance of a flight: versions, seed, checksums, and how the plant was set up."""
    origin = provenance(
        seed=flight.scenario.seed,
        scenario_sha256=hashlib.sha256(text.encode()).hexdigest(),
        aircraft_sha256=flight.aircraft.sha256(),
        plant_settings=flight.plant.settings,
    )
    if isinstance(flight.scenario.controller, OwnController):
        origin["controller_sha256"] = checksum(flight.scenario.controller.kind)
    return origin


def summary_of(flight: Flight, outcome: Outcome, metrics: Metrics, origin: dict[str, Any]) -> dict[str, Any]:
    """Return the document of `summary.json`."""
    scenario = flight.scenario
    steps = max(outcome.rows - 1, 0)
    return summary(
        scenario=scenario.name,
        aircraft=scenario.aircraft,
        plant=scenario.plant,
        controller=controller_name(scenario),
        completed=outcome.completed,
        ended_because=outcome.ended_because,
        ended_at_s=outcome.ended_at_s,
        axes=metrics.axes(completed=outcome.completed),
        timing={
            "flight_wall_s": outcome.wall_s,
            "controller_steps": steps,
            "us_per_controller_step": 1e6 * outcome.wall_s / max(steps, 1),
        },
        provenance=origin,
        warnings=warnings(scenario),
    )


def draw(folder: Path, flight: Flight, document: dict[str, Any]) -> None:
    """Draw the figures of the history in `folder` into `folder`/figures."""
    from uavftc.report.figures import FaultWindow, FigureContext, fault_label, write_figures  # noqa: PLC0415

    scenario = flight.scenario
    limits = {
        surface: tuple(pair) if np.isfinite(pair).any() else None
        for surface, pair in zip(SURFACES, scenario.limits_rad(), strict=True)
    }
    end = scenario.duration_s
    edges = [(d.start_s, d.end_s) for d in scenario.disturbances if not isinstance(d, Turbulence)]
    changes = {end if edge is None else edge for pair in edges for edge in pair}
    title = title_of(document)
    if not document["completed"]:
        title += f"\nLOST: {document['ended_because']}" if document["ended_because"] else "\nLOST"
    context = FigureContext(
        title=title,
        limits_rad=limits,
        faults=[
            FaultWindow(
                fault.surface,
                fault.start_s,
                end if fault.end_s is None else fault.end_s,
                fault_label(fault.effectiveness.written, fault.bias_deg.written),
            )
            for fault in scenario.faults
        ],
        disturbances_s=sorted(edge for edge in changes if 0.0 < edge < end),
        wind=any(isinstance(d, Gust | Wind) for d in scenario.disturbances),
    )
    write_figures(folder / "figures", read_history(folder / "history.parquet"), context)
