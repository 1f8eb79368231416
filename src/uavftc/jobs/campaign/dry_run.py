"""A campaign that is not flown: its first cases, how many flights there are, and what they will take."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

from uavftc.jobs.campaign.evaluate import Job, Plan, evaluate, prepare
from uavftc.jobs.campaign.sweep import Ready, usable_cores
from uavftc.jobs.campaign.table import schema_of
from uavftc.report.rate import clock

SHOWN = 5  # cases
BYTES_A_NUMBER = 8
STARTED_S = 3.0  # until the workers fly
MEASURED = 3  # cases flown for the estimate, after one that loads everything


def lines(made: Ready, workers: int | None = None) -> Iterator[str]:
    """Yield what is to be shown, after a few flights that are measured and kept nowhere."""
    campaign, variants, cases = made
    flights = made.flights
    by = ", ".join(variant.title for variant in variants)
    yield f"{campaign.name}: {cases.count} cases, {flights} flights, each case by {by}"
    for case in range(min(SHOWN, cases.count)):
        yield f"case {case}: " + ", ".join(f"{key} = {_short(value)}" for key, value in cases.values(case).items())
    prepare(Plan(variants, campaign.success, "none"))
    spent, outcomes = 0.0, []
    for place, variant in enumerate(variants):
        for case in range(MEASURED + 1):
            job = Job(case % cases.count, place, cases.values(case % cases.count))
            started = time.perf_counter()
            row = evaluate(job)
            if case:
                spent += (time.perf_counter() - started) / MEASURED
            else:
                outcomes.append(f"{variant.title}: {row['outcome']}")
    yield "case 0 flown: " + "; ".join(outcomes)
    many = workers or usable_cores()
    each = spent / len(variants)
    size = flights * BYTES_A_NUMBER * len(schema_of(campaign))
    yield f"{1e3 * each:.3g} ms a flight: about {clock(STARTED_S + each * flights / many)} with {many} worker(s)"
    yield f"at most {_bytes(size)} for the table, without histories"


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _bytes(count: int) -> str:
    return f"{count / 1e6:.2g} MB" if count < 1e9 else f"{count / 1e9:.2g} GB"
