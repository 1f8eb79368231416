"""A flight as its `summary.json` has it, once more as it was when it had been flown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uavftc.analysis.requirements import Met
from uavftc.analysis.verdict import FLOWN
from uavftc.core.layout import Layout
from uavftc.flight.fly import Outcome
from uavftc.results.flight import FlightResult
from uavftc.scenario.schema import Scenario


def result_of(document: Mapping[str, Any], scenario: Scenario, layout: Layout) -> FlightResult:
    """Return what is kept of a flight, without its history and with the remarks in its summary alone.

    Parameters
    ----------
    document
        Of `summary.json`.
    scenario
        As flown.
    layout
        The effectors of the aircraft.
    """
    verdict = document["verdict"]
    met = [] if verdict is None else [Met(**one) for one in verdict["requirements"] if one["name"] != FLOWN]
    outcome = Outcome(
        completed=document["completed"],
        ended_because=document["ended_because"],
        ended_at_s=document["ended_at_s"],
        interrupted=verdict is None,
        rows=document["timing"]["controller_steps"] + 1,
        wall_s=document["timing"]["flight_wall_s"],
        numerical=document.get("numerical", False),
    )
    return FlightResult(scenario, outcome, document["axes"], None, document["provenance"], (), layout, tuple(met))
