"""A result folder read back: what kind of result it is, and of a flight what was kept of it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uavftc.analysis.requirements import Met
from uavftc.analysis.verdict import FLOWN
from uavftc.config.document import Document, parse
from uavftc.core.layout import Layout
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import Outcome
from uavftc.results.flight import FlightResult
from uavftc.results.history import read_history, read_metadata
from uavftc.results.manifest import SUMMARY, read_summary
from uavftc.scenario.load import load_scenario, scenario_of, warnings
from uavftc.scenario.schema import Scenario

HISTORY, SCENARIO = "history.parquet", "scenario.yaml"

FLIGHT, COMPARISON, CAMPAIGN = "flight", "comparison", "campaign"
_MARKS = {FLIGHT: "axes", COMPARISON: "combinations", CAMPAIGN: "flights"}
"""The key by which a summary shows what it is of."""


def read_document(folder: Path, where: str = "") -> dict[str, Any]:
    """Return the `summary.json` of a result folder.

    Parameters
    ----------
    folder
        What `--out` named.
    where
        What the user named it by; the folder itself where it is empty.

    Raises
    ------
    InputError
        If it is no folder of ours.
    """
    document = read_summary(folder)
    if document is not None:
        return document
    if not folder.exists():
        found = "no such folder"
    elif not folder.is_dir():
        found = "a file"
    else:
        found = f"a folder without a {SUMMARY} of uavftc"
    raise InputError(
        where or str(folder),
        found=found,
        expected="a result folder, as a flight, a comparison or a campaign writes it",
        remedy="name the folder that --out named, such as results/scenario3-nndondi-l1-jsbsim",
    )


def kind_of(document: Mapping[str, Any]) -> str | None:
    """Return whether a summary is of a flight, a comparison or a campaign; None of anything else."""
    return next((kind for kind, key in _MARKS.items() if key in document), None)


def read_scenario(folder: Path) -> Scenario:
    """Return the scenario of a result folder, as flown.

    Raises
    ------
    InputError
        If it is missing or can no longer be flown.
    """
    return load_scenario(folder / SCENARIO)


def read_result(folder: Path, *, keep_history: bool = True) -> FlightResult:
    """Return what was kept of a flight in a result folder; its flight is built anew to know its effectors.

    Raises
    ------
    InputError
        If the folder holds no flight, one of its files is damaged, or its aircraft or controller is no longer there.
    """
    document = read_document(folder)
    if (kind := kind_of(document)) != FLIGHT:
        raise InputError(
            str(folder),
            found=f"the result of {'another job' if kind is None else f'a {kind}'}",
            expected="the result folder of one flight",
            remedy="name a folder that uavftc-fly wrote",
        )
    result = result_of_history(folder / HISTORY, document, read_scenario(folder))
    return result if keep_history else result._replace(history=None)


def result_of_history(file: Path, document: Mapping[str, Any], scenario: Scenario | None = None) -> FlightResult:
    """Return what was kept of a flight, from its history, its part of a summary, and its scenario as flown.

    A scenario that is not given is the one in the metadata of the history.

    Raises
    ------
    InputError
        As `read_result`.
    """
    history = read_history(file)
    if scenario is None:
        scenario = scenario_of(Document(*_parsed(file)))
    flight = build_flight(scenario)
    return result_of(document, flight.scenario, flight.layout)._replace(history=history)


def result_of(document: Mapping[str, Any], scenario: Scenario, layout: Layout) -> FlightResult:
    """Return what was kept of a flight, without its history, from its part of a summary.

    Parameters
    ----------
    document
        Of `summary.json`, or one of its `combinations`.
    scenario
        As flown.
    layout
        The effectors of the aircraft.
    """
    timing, known = document["timing"], len(warnings(scenario))
    outcome = Outcome(
        completed=document["completed"],
        ended_because=document["ended_because"],
        ended_at_s=document["ended_at_s"],
        interrupted=document.get("verdict") is None,
        rows=timing["controller_steps"] + 1,
        wall_s=timing["flight_wall_s"],
        numerical=document.get("numerical", False),
    )
    remarks = tuple(document["warnings"][known:])
    origin, met = document["provenance"], met_of(document)
    return FlightResult(scenario, outcome, document["axes"], None, origin, remarks, layout, met)


def _parsed(file: Path) -> tuple[dict[str, Any], str, dict[Any, str]]:
    text = read_metadata(file)["scenario"]
    data, places = parse(text, f"{file}, scenario in its metadata")
    return data, str(file), places


def met_of(document: Mapping[str, Any]) -> tuple[Met, ...]:
    """Return how each requirement fared, from the summary of a flight."""
    verdict = document.get("verdict") or {"requirements": ()}
    return tuple(Met(**one) for one in verdict["requirements"] if one["name"] != FLOWN)
