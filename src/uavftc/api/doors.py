"""The functions of `import uavftc`: a flight, a comparison, a design, and what was saved."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from uavftc.api.campaign import CampaignResult
from uavftc.api.comparison import Comparison
from uavftc.api.design import Design
from uavftc.api.flight import Flight
from uavftc.control.custom import in_memory
from uavftc.errors import InputError
from uavftc.jobs.campaign.pool import fly_one
from uavftc.jobs.compare import Key, fly_combinations, load_combinations
from uavftc.results.flight import FlightResult
from uavftc.results.loaded import CAMPAIGN, COMPARISON, FLIGHT, kind_of, read_document, read_result, result_of_history
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

Source = str | os.PathLike[str] | Mapping[str, Any] | Scenario
"""A scenario: its file, the name of a shipped one, its data as a dict, or the scenario itself."""

ControllerLike = str | os.PathLike[str] | Callable[..., Any] | ModuleType
"""A controller: its name, its file, a function ``step`` or ``create``, or a module (docs/custom-controller.md)."""


def fly(
    scenario: Source,
    *,
    controller: ControllerLike | None = None,
    plant: str | None = None,
    aircraft: str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
) -> Flight:
    """Fly a scenario and return the flight; nothing is written. Flown twice, it is flown anew.

    Parameters
    ----------
    scenario
        A file, the name of a shipped scenario, a dict, or a `Scenario`.
    controller
        A name such as ``"pid"`` or ``"ndi-l1"``; the path of a .py file; a function ``step(t, x1_c, x1, x2)``, or one
        that makes it, ``create(design, h, options)``; or a module. None is that of the scenario.
    plant
        ``"jsbsim"`` or ``"analytic"``; None is that of the scenario.
    aircraft
        A shipped one, ``"jsbsim:c172p"`` for one of JSBSim's own, or a folder; None is that of the scenario.
    set
        Values by dotted key, in the units of a scenario file: ``{"faults[1].effectiveness": 0.2}``.

    Raises
    ------
    InputError
        If anything is wrong with the scenario, or it cannot be flown.
    KeyboardInterrupt
        On Ctrl-C.
    """
    return Flight(fly_one(load_scenario(scenario, controller=controller, plant=plant, aircraft=aircraft, set=set)))


def compare(
    scenario: Source,
    *,
    controllers: Sequence[ControllerLike] | None = None,
    plants: Sequence[str] | None = None,
    aircraft: str | os.PathLike[str] | None = None,
    set: Mapping[str, Any] | None = None,
    variants: Mapping[str, Mapping[str, Any]] | None = None,
) -> Comparison:
    """Fly a scenario by several controllers, on one plant or both, and return the flights side by side.

    Parameters
    ----------
    scenario, aircraft, set
        As `fly` takes them.
    controllers
        Each as `fly` takes it; None is that of the scenario.
    plants
        ``["jsbsim", "analytic"]`` for both; None is that of the scenario.
    variants
        Named changes of the first controller, flown next to it, each a dict of values by key:
        ``{"fast": {"controller.inner.filter_bandwidth": 120}}``.

    Raises
    ------
    InputError
        If anything is wrong, or one combination cannot be flown.
    KeyboardInterrupt
        On Ctrl-C.
    """
    names = None if controllers is None else ",".join(map(_name, controllers))
    if plants is None:
        plants = [load_scenario(scenario, aircraft=aircraft, set=set).plant]
    texts = [f"{name}:{key}={value}" for name, changes in (variants or {}).items() for key, value in changes.items()]
    scenarios = load_combinations(
        scenario, plants=",".join(plants), controllers=names, aircraft=aircraft, set=set, variants=texts
    )
    return Comparison(fly_combinations(scenarios), scenarios.variants)


def _name(controller: ControllerLike) -> str:
    return os.fspath(controller) if isinstance(controller, str | os.PathLike) else in_memory.register(controller)


def design(
    aircraft: str | os.PathLike[str] | None = None,
    *,
    scenario: Source | None = None,
    set: Mapping[str, Any] | None = None,
) -> Design:
    """Return trim, linear model, gains, L1 norms and bounds of an aircraft: ``uavftc.design("jsbsim:c172p").B``.

    Parameters
    ----------
    aircraft
        As `fly` takes it; None is that of the scenario.
    scenario
        Where controller, condition and reference come from; None is the paper's controller at the aircraft's own
        condition, with 5 deg on each axis.
    set
        Values by dotted key, such as ``{"initial.airspeed_mps": 40}``.

    Raises
    ------
    InputError
        If the aircraft cannot be loaded or trimmed, or its inner loop is not L1.
    """
    from uavftc.jobs.design.document import DEFAULT_SCENARIO, design_document  # noqa: PLC0415 - a quarter of a second

    source = load_scenario(DEFAULT_SCENARIO if scenario is None else scenario, aircraft=aircraft, set=set)
    return Design(design_document(source.aircraft, scenario=source))


def load(folder: str | os.PathLike[str]) -> Flight | Comparison | CampaignResult:
    """Return the flight, comparison or campaign that was saved to a folder, by Python or by a command.

    Raises
    ------
    InputError
        If it is not the result folder of one of them, or a file in it is damaged.
    """
    path = Path(folder)
    document = read_document(path)
    kind = kind_of(document)
    if kind == FLIGHT:
        return Flight(read_result(path))
    if kind == COMPARISON:
        return Comparison(*_combinations(path, document))
    if kind == CAMPAIGN:
        return CampaignResult(path)
    raise InputError(
        str(path),
        found="the result of another job",
        expected="the result folder of a flight, a comparison or a campaign",
        remedy="name a folder that uavftc-fly, uavftc compare or uavftc sweep wrote",
    )


def _combinations(folder: Path, document: Mapping[str, Any]) -> tuple[dict[Key, FlightResult], dict[str, Any]]:
    flown: dict[Key, FlightResult] = {}
    for flight in document["combinations"]:
        key = flight["plant"], flight["controller"]
        flown[key] = result_of_history(folder / "histories" / f"{'-'.join(key)}.parquet", flight)
    return flown, {f["controller"]: f["variant"] for f in document["combinations"] if "variant" in f}
