"""A mission: a scenario flown, with its result folder on disk."""

from __future__ import annotations

import signal
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.analysis.metrics import Metrics
from uavftc.flight.build import Flight, build_flight
from uavftc.flight.fly import Outcome, fly
from uavftc.flight.trusted import TrustedRange
from uavftc.jobs.live.pace import Pace
from uavftc.jobs.live.target import Target
from uavftc.jobs.twin import document_of, fly_twin
from uavftc.results.flight import FlightResult, metadata_of, notes_of, origin_of
from uavftc.results.folder import ResultFolder
from uavftc.results.history import ParquetRecorder, read_history
from uavftc.results.hold import Hold
from uavftc.scenario.load import scenario_text
from uavftc.scenario.schema import Scenario

Progress = Callable[[int], AbstractContextManager[Callable[[int], None]]]
"""Given the number of rows, a context that yields a function to call with the rows flown so far."""

Live = tuple[float, Target | None]
"""Seconds of flight in a second, and where each row goes."""

Page = Callable[
    [Flight, FlightResult, Mapping[str, Any], Mapping[str, np.ndarray], Mapping[str, np.ndarray] | None], str
]
"""Given a flight, what came of it, its `summary.json`, its history and that of its twin, the text of its page."""


def fly_mission(
    scenario: Scenario,
    out: Path,
    *,
    figures: bool = True,
    progress: Progress | None = None,
    inputs: Sequence[Path] = (),
    twin: bool = False,
    page: Page | None = None,
    live: Live | None = None,
) -> tuple[dict[str, Any], Outcome]:
    """Fly a scenario and write its result folder, whole or not at all.

    Ctrl-C ends the flight between two slices, and what was flown is written; a second one while it flies acts at once,
    and nothing is written. Once it is flown, Ctrl-C loses nothing but the figures.

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
    inputs
        Files that the scenario came from; a folder that holds one of them is not replaced.
    twin
        Whether to fly the same without faults, too, and say what each of them did.
    page
        What makes `report.html`; None: there is none.
    live
        At which pace it flies, and where to it is sent; None: as fast as it can.

    Returns
    -------
    The document of `summary.json`, and how the flight ended. The document has `figures_missing` or `report_missing`,
    the reason, where there was no room for the figures or the page.

    Raises
    ------
    InputError
        If the aircraft cannot be flown or the folder cannot be written; nothing is written then.
    """
    folder = ResultFolder(out, inputs)
    folder.check()
    other = fly_twin(scenario) if twin else None
    flight = build_flight(scenario)
    origin = origin_of(flight)
    metadata, metrics = metadata_of(flight.scenario, origin), Metrics(flight.given.axes)
    monitor = flight.monitor()
    trusted = TrustedRange(flight.aircraft.trusted)
    paced = None if live is None else Pace(flight, *live)
    with Hold(signal.SIGINT) as hold:
        with folder:
            history = folder.path / "history.parquet"
            with (
                ParquetRecorder(history, metadata, flight.columns) as parquet,
                nullcontext(None) if progress is None else progress(flight.steps + 1) as advance,
                hold.second_acts() as stopped,
            ):
                outcome = fly(flight, [parquet, metrics, monitor, trusted], advance, stop=stopped, watch=paced)
            if outcome.interrupted:
                hold.take()
            axes = metrics.axes(completed=outcome.completed)
            remarks = (*notes_of(flight), *trusted.remarks())
            met = tuple(monitor.found())
            result = FlightResult(flight.scenario, outcome, axes, None, origin, remarks, flight.layout, met)
            (folder.path / "scenario.yaml").write_text(scenario_text(flight.scenario), encoding="utf-8", newline="\n")
            document = result.summary()
            if paced is not None:
                paced.close()
                document["timing"] |= paced.timing()
            if other is not None:
                document["twin"] = document_of(flight.scenario, read_history(history), other)
            unfaulted = None if other is None else other.history
            if figures:
                _extra(folder, "figures", lambda into: draw(into, history, result, unfaulted), document, hold)
            if page is not None:
                columns = read_history(history)

                def write(into: Path) -> None:
                    into.write_text(page(flight, result, document, columns, unfaulted), encoding="utf-8", newline="\n")

                _extra(folder, "report", write, document, hold)
            document = folder.write_summary(document)
        if hold.take():  # after the flight, or in the drawing
            outcome = outcome._replace(interrupted=True)
    return document, outcome


def write_flight(result: FlightResult, out: Path, *, figures: bool = True) -> dict[str, Any]:
    """Write the result folder of a flight that is over, whose history was kept, and return its `summary.json`.

    Parameters
    ----------
    result
        The flight.
    out, figures
        As those of `fly_mission`.

    Raises
    ------
    InputError
        If the folder cannot be written; nothing is written then.
    """
    with Hold(signal.SIGINT) as hold, ResultFolder(out) as folder:
        history = folder.path / "history.parquet"
        result.write_history(history)
        (folder.path / "scenario.yaml").write_text(scenario_text(result.scenario), encoding="utf-8", newline="\n")
        document = result.summary()
        if figures:
            _extra(folder, "figures", lambda into: draw(into, history, result), document, hold)
        return folder.write_summary(document)


_EXTRAS = {"figures": ("figures", "figures", "drawing"), "report": ("report.html", "page", "writing the page")}
"""What a flight can do without: its name in the folder, what it is called, and what is going on while it is made."""


def _extra(
    folder: ResultFolder, kind: str, write: Callable[[Path], object], document: dict[str, Any], hold: Hold
) -> None:
    """Write figures or the page; on Ctrl-C, or where there is no room for them, keep the flight without and say so."""
    name, called, doing = _EXTRAS[kind]
    kept = f"the flight is kept, without its {called}"

    def write_now(into: Path) -> None:
        with hold.first_acts():
            write(into)

    try:
        missing = folder.extra(name, write_now)
    except KeyboardInterrupt:
        hold.note_again()
        document["warnings"].append(f"interrupted while {doing}: {kept}")
        return
    if missing is not None:
        document[f"{kind}_missing"] = missing
        document["warnings"].append(f"no room for the {called} ({missing}): {kept}")


def draw(folder: Path, history: Path, result: FlightResult, twin: Mapping[str, np.ndarray] | None = None) -> None:
    """Draw the figures of a flight, whose history is in a file, into `folder`; beneath it a twin, if any."""
    from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

    load_matplotlib()
    from uavftc.report.figures import write_figures  # noqa: PLC0415

    write_figures(folder, read_history(history), replace(result.figure_context(), twin=twin))
