"""Time in proportion to duration: a row of a flight of an hour against a row of a flight of 20 s."""

from __future__ import annotations

import tempfile
from pathlib import Path

from uavftc.analysis.metrics import Metrics
from uavftc.flight.build import build_flight
from uavftc.jobs.bench.flights import fly_all_of, level
from uavftc.jobs.bench.measure import Figure, Job, alternately, of, ratios, timed
from uavftc.results.history import ParquetRecorder

LONG_S, SHORT_S = 3600.0, 20.0
REPEATED = 5  # short flights a round


def time_growth(rounds: int) -> dict[str, Figure]:
    """Time a row of a level flight of 1 h over that of one of 20 s: loop, Parquet and metrics."""
    figures = {}
    for plant in ("analytic", "jsbsim"):
        long, short = alternately(rounds, _per_row(plant, LONG_S, 1), _per_row(plant, SHORT_S, REPEATED))
        details = {"row_1h_us": of([1e6 * s for s in long]), "row_20s_us": of([1e6 * s for s in short])}
        figures[plant] = Figure(ratios(long, short), details)
    return figures


def _per_row(plant: str, duration_s: float, repeated: int) -> Job:
    """Return a job that flies so many times to a file; its seconds are those of one row."""
    flown = level(duration_s, plant)

    def one(path: Path) -> float:
        flight = build_flight(flown)

        def fly() -> None:
            with ParquetRecorder(path, {}) as parquet:
                fly_all_of(flight, parquet, Metrics())

        return timed(fly)

    def job() -> float:
        with tempfile.TemporaryDirectory() as folder:
            seconds = [one(Path(folder) / "history.parquet") for _ in range(repeated)]
        return sum(seconds) / (repeated * (flown.steps + 1))

    return job
