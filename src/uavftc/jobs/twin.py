"""The twin of a flight: the same without faults and damage, flown to show what they alone did."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from uavftc.analysis.isolated import BAND_DEG, Window, isolated
from uavftc.jobs.campaign.pool import fly_one
from uavftc.results.flight import FlightResult
from uavftc.scenario.changed import remade
from uavftc.scenario.schema import Scenario


def unfaulted(scenario: Scenario) -> Scenario:
    """Return the scenario without its faults and its damage; requirements that count from one are left out."""

    def edit(document: Any) -> None:
        document.data.update(faults=[], damage=[])
        asked = document.data["requirements"]
        if asked is not None:
            kept = [one for one in asked if one["after"] is None or one["after"].startswith("disturbances")]
            document.data["requirements"] = kept

    return remade(scenario, edit, "the twin without faults")


def fly_twin(scenario: Scenario) -> FlightResult:
    """Fly the twin of a scenario.

    Raises
    ------
    InputError
        If it cannot be flown.
    """
    return fly_one(unfaulted(scenario))


def document_of(scenario: Scenario, history: Mapping[str, np.ndarray], twin: FlightResult) -> dict[str, Any]:
    """Return what `summary.json` has under `twin`: how it fared, and what each fault and damage did by itself."""
    assert twin.history is not None
    windows = [
        Window(f"{section}[{i}]", entry.start_s, entry.end_s)
        for section in ("faults", "damage")
        for i, entry in enumerate(getattr(scenario, section))
    ]
    return {
        "verdict": None if twin.verdict is None else twin.verdict.document(),
        "recovery_band_deg": BAND_DEG,
        "isolated": isolated(history, twin.history, windows),
    }
