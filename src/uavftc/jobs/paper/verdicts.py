"""The verdicts on the flights behind the paper's tables, with the default requirements."""

from __future__ import annotations

from typing import Any

from uavftc.jobs.paper.plan import Flights


def verdicts_of(flights: Flights) -> list[dict[str, Any]]:
    """Return plant, scenario, controller, outcome, margin, and what limits it, of each flight of the paper."""
    found = []
    for key, flown in flights.items():
        verdict = flown.verdict
        if key.variant == "paper" and verdict is not None:
            found.append(
                {
                    "plant": key.plant,
                    "scenario": key.scenario,
                    "controller": key.controller,
                    "outcome": verdict.outcome,
                    "margin": verdict.margin,
                    "limiting": verdict.limiting,
                    "at_s": verdict.at_s,
                }
            )
    return found
