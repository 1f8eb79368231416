"""A mission: a scenario flown, with its result folder on disk."""

from __future__ import annotations

import shutil
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import Any

from uavftc.analysis.metrics import Metrics
from uavftc.flight.build import build_flight
from uavftc.flight.fly import Outcome, fly
from uavftc.flight.trusted import TrustedRange
from uavftc.results.flight import FlightResult, metadata_of, origin_of
from uavftc.results.folder import ResultFolder
from uavftc.results.history import ParquetRecorder, read_history
from uavftc.scenario.load import scenario_text
from uavftc.scenario.schema import Scenario

Progress = Callable[[int], AbstractContextManager[Callable[[int], None]]]
"""Given the number of rows, a context that yields a function to call with the rows flown so far."""


def fly_mission(
    scenario: Scenario, out: Path, *, figures: bool = True, progress: Progress | None = None
) -> tuple[dict[str, Any], Outcome]:
    """Fly a scenario and write its result folder, whole or not at all.

    Ctrl-C ends the flight between two slices, and what was flown is written; a second one acts at once, and nothing
    is written.

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
    origin = origin_of(flight)
    metadata, metrics = metadata_of(flight.scenario, origin), Metrics()
    trusted = TrustedRange(flight.aircraft.trusted)
    with folder:
        history = folder.path / "history.parquet"
        with (
            ParquetRecorder(history, metadata) as parquet,
            nullcontext(None) if progress is None else progress(flight.steps + 1) as advance,
            _ctrl_c() as stopped,
        ):
            outcome = fly(flight, [parquet, metrics, trusted], advance, stop=stopped)
        axes = metrics.axes(completed=outcome.completed)
        result = FlightResult(flight.scenario, outcome, axes, None, origin, trusted.remarks())
        (folder.path / "scenario.yaml").write_text(scenario_text(flight.scenario), encoding="utf-8", newline="\n")
        document = result.summary()
        if figures:
            try:
                draw(folder.path / "figures", history, result)
            except KeyboardInterrupt:  # the flight is kept, without its figures
                shutil.rmtree(folder.path / "figures", ignore_errors=True)
                outcome = outcome._replace(interrupted=True)
                document["warnings"].append("interrupted while drawing: the flight is kept, without its figures")
        document = folder.write_summary(document)
    return document, outcome


def draw(folder: Path, history: Path, result: FlightResult) -> None:
    """Draw the figures of a flight, whose history is in a file, into `folder`."""
    from uavftc.report.figures import write_figures  # noqa: PLC0415 - matplotlib takes most of a second

    write_figures(folder, read_history(history), result.figure_context())


@contextmanager
def _ctrl_c() -> Iterator[Callable[[], bool]]:
    """Yield a function that says whether Ctrl-C was pressed; the first one does nothing else.

    A second Ctrl-C acts at once. Off the main thread Python delivers no signals, and the answer stays no.
    """
    stopped = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stopped.is_set
        return

    def stop(_signal: int, _frame: object) -> None:
        stopped.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield stopped.is_set
    finally:
        signal.signal(signal.SIGINT, before)
