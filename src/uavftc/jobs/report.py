"""`report.html` of what a job has left on disk, and of a flight or a comparison that was just flown."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.core.layout import Layout
from uavftc.errors import InputError
from uavftc.flight.build import Flight, build_flight
from uavftc.jobs.campaign.identity import FILE
from uavftc.jobs.campaign.scenarios import FOLDER as SCENARIOS
from uavftc.jobs.campaign.scenarios import command
from uavftc.jobs.campaign.table import TABLE, VARIANT, read_table
from uavftc.jobs.campaign.variants import names_of
from uavftc.jobs.paper import printed
from uavftc.plants.jsbsim.span import span
from uavftc.report.page.campaign import campaign_page
from uavftc.report.page.comparison import Key, comparison_page
from uavftc.report.page.flight import flight_page
from uavftc.report.page.html import require_extra
from uavftc.report.page.reproduction import reproduction_page
from uavftc.report.page.tables import Printed
from uavftc.report.page.view import SPAN_M, Sketch
from uavftc.results.added import add_file, own_summary
from uavftc.results.flight import FlightResult
from uavftc.results.history import read_history
from uavftc.results.loaded import HISTORY, SCENARIO, result_of
from uavftc.scenario.load import controller_name, load_scenario, scenario_text
from uavftc.scenario.schema import Scenario

NAME = "report.html"


def report(folder: Path) -> Path:
    """Write the page of a result folder into it, and return its path.

    Raises
    ------
    InputError
        If the folder is not a complete one of uavftc's with something to show, or the extra is missing.
    """
    where = f"report {folder}"
    require_extra(where)
    document = own_summary(folder, where)
    make = next((make for key, make in _KINDS.items() if key in document), None)
    if make is None:
        raise InputError(
            where,
            found="the results of another command",
            expected="a flight, a comparison, a reproduction or a campaign",
            remedy="name the folder of one of them",
        )
    text = make(folder, document, where)
    add_file(folder, NAME, text, where)
    return folder / NAME


def page_of_flight(
    flight: Flight,
    result: FlightResult,
    document: Mapping[str, Any],
    history: Mapping[str, np.ndarray],
    twin: Mapping[str, np.ndarray] | None = None,
) -> str:
    """Return the page of a flight that was just flown; its history has the published columns."""
    return _flight_page(flight, result, document, history, twin=twin)


def _flight_page(
    flight: Flight | None,
    result: FlightResult,
    document: Mapping[str, Any],
    history: Mapping[str, np.ndarray],
    *,
    twin: Mapping[str, np.ndarray] | None = None,
    remarks: tuple[str, ...] = (),
) -> str:
    return flight_page(
        history,
        replace(result.figure_context(), twin=twin),
        document,
        scenario_text(result.scenario),
        sketch=sketch_of(flight),
        printed=printed_of(result.scenario),
        remarks=remarks,
    )


def sketch_of(flight: Flight | None) -> Sketch:
    """Return how the moving view draws the aircraft of a flight; None is one of which nothing is known."""
    if flight is None:
        return Sketch()
    return Sketch(flight.layout, span(flight.aircraft) or SPAN_M)


def printed_of(scenario: Scenario) -> Printed | None:
    """Return what the paper prints of a flight; None where it has none, or a key of the scenario was changed."""
    controller = controller_name(scenario)
    found = _printed(scenario.name, controller)
    if not found:
        return None
    shipped = build_flight(load_scenario(scenario.name, plant=scenario.plant, controller=controller)).scenario
    return found if scenario_text(shipped) == scenario_text(scenario) else None


def _printed(shipped: str, controller: str) -> Printed:
    return {
        (one.axis, one.metric): one.value
        for one in printed.tables()
        if (one.shipped, one.controller) == (shipped, controller)
    }


def _of_flight(folder: Path, document: dict[str, Any], where: str) -> str:
    history = read_history(_there(folder, HISTORY, where))
    scenario = load_scenario(_there(folder, SCENARIO, where))
    flight, remarks = rebuilt(scenario)
    result = result_of(document, flight.scenario if flight is not None else scenario, layout_of(flight))
    return _flight_page(flight, result, document, history, remarks=remarks)


def page_of_comparison(flown: Mapping[Key, FlightResult], document: dict[str, Any]) -> str:
    """Return the page of a comparison that was just flown; its flights have their histories."""
    first = next(iter(flown.values()))
    histories = {key: result.history for key, result in flown.items() if result.history is not None}
    return _comparison_page(histories, first, document)


def _comparison_page(
    histories: Mapping[Key, Mapping[str, np.ndarray]],
    first: FlightResult,
    document: dict[str, Any],
    remarks: tuple[str, ...] = (),
) -> str:
    printed_for = {}
    if printed_of(first.scenario) is not None:
        printed_for = {
            name: found for name in document["controllers"] if (found := _printed(document["scenario"], name))
        }
    return comparison_page(
        histories,
        first.figure_context(),
        document,
        scenario_text(first.scenario),
        printed=printed_for,
        remarks=remarks,
    )


def _of_comparison(folder: Path, document: dict[str, Any], where: str) -> str:
    histories = {}
    for one in document["combinations"]:
        key = one["plant"], one["controller"]
        histories[key] = read_history(_there(folder, f"histories/{key[0]}-{key[1]}.parquet", where))
    scenario = load_scenario(_there(folder, SCENARIO, where))
    flight, remarks = rebuilt(scenario)
    known = flight.scenario if flight is not None else scenario
    first = result_of(document["combinations"][0], known, layout_of(flight))
    return _comparison_page(histories, first, document, remarks)


def _of_campaign(folder: Path, document: dict[str, Any], where: str) -> str:
    table = read_table(_there(folder, TABLE, where), where)
    campaign = json.loads(_there(folder, FILE, where).read_text(encoding="utf-8"))
    listed = [*document["files"], "summary.json"]
    keys = [one["key"] for one in campaign["campaign"]["vary"]]
    places = [name for name in VARIANT if name in table]
    rows = list(dict.fromkeys(zip(*(table[name] for name in places), strict=True)))
    variants = [(*row, *[""] * (len(VARIANT) - len(row))) for row in rows]
    if len(places) == 2 and places[1] == VARIANT[2]:  # aircraft, and one plant
        variants = [(row[0], "", row[1]) for row in rows]
    named = dict(zip(rows, names_of(variants), strict=True))

    def again(row: Mapping[str, Any]) -> str:
        file = f"{SCENARIOS}/{named[tuple(row[name] for name in places)]}.yaml"
        return command(Path(file), {key: row[key] for key in keys}) if file in listed else ""

    return campaign_page(table, document, campaign, again=again, files=listed)


def _of_reproduction(folder: Path, document: dict[str, Any], where: str) -> str:
    rows = json.loads(_there(folder, "reproduce.json", where).read_text(encoding="utf-8"))
    return reproduction_page(rows, document, files=[*document["files"], "summary.json"])


def _there(folder: Path, name: str, where: str) -> Path:
    """Return a file of a result folder that a page cannot do without."""
    if not (folder / name).is_file():
        raise InputError(
            where, found=f"no {name} in it", expected="results with their histories", remedy="fly it again"
        )
    return folder / name


def rebuilt(scenario: Scenario) -> tuple[Flight | None, tuple[str, ...]]:
    """Return a flight as it would be flown again, and a remark where that cannot be had here any more."""
    try:
        return build_flight(scenario), ()
    except InputError as error:
        lacking = "limits and the surfaces of the moving view are not shown as they were"
        return None, (f"the flight cannot be built again ({error.where}: {error.found}): {lacking}",)


def layout_of(flight: Flight | None) -> Layout:
    """Return the effectors of a flight, or three surfaces where it could not be built again."""
    return Layout() if flight is None else flight.layout


Make = Callable[[Path, dict[str, Any], str], str]

_KINDS: dict[str, Make] = {
    "axes": _of_flight,
    "combinations": _of_comparison,
    "campaign": _of_campaign,
    "claims": _of_reproduction,
}
"""What makes the page of a folder, by a key of its summary that no other kind has."""
