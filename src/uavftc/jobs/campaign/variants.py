"""What each case of a campaign is flown by: every combination of controller, plant and aircraft, with its scenario."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.jobs.campaign.cases import Cases, extremes
from uavftc.scenario.campaign import Campaign, where_varied
from uavftc.scenario.changed import Changing
from uavftc.scenario.load import controller_name
from uavftc.scenario.schema import Scenario

CHECKED = 1000  # values of a choice, grid or list that are tried before anything flies


class Variant(NamedTuple):
    """One combination; those of a campaign are in the order of the table's rows."""

    controller: str
    plant: str
    aircraft: str
    scenario: Scenario
    """The base, with these three."""

    @property
    def title(self) -> str:
        """Return it in short, for messages."""
        return f"{self.controller} on {self.aircraft}, {self.plant}"


def variants_of(campaign: Campaign) -> list[Variant]:
    """Return the variants of a campaign, by controller, plant and aircraft.

    Raises
    ------
    InputError
        If one of them does not exist, two have one name, or the base is wrong or cannot be flown so.
    """
    found = []
    for controller, plant, aircraft in product(
        campaign.controllers or (None,), campaign.plants or (None,), campaign.aircraft or (None,)
    ):
        scenario = campaign.scenario(controller=controller, plant=plant, aircraft=aircraft)
        found.append(Variant(controller_name(scenario), scenario.plant, aircraft or scenario.aircraft, scenario))
    keys = [one[:3] for one in found]
    if len(set(keys)) < len(keys):
        raise InputError(
            campaign.origin.where(("controllers",)),
            found="two controllers with one name",
            expected="controllers with different names, because rows are named after them",
            remedy="rename one of the modules",
        )
    return sorted(found, key=lambda one: one[:3])


def names_of(variants: Sequence[Sequence[Any]]) -> list[str]:
    """Return a name for the files of each: the controller, then plant and aircraft where there are several.

    Each begins with controller, plant and aircraft, as a `Variant` does.
    """
    found: list[str] = []
    for variant in variants:
        name = str(variant[0])
        for part in (1, 2):
            if len({one[part] for one in variants}) > 1:
                name += f"-{Path(variant[part]).name}".replace(":", "-")
        found.append(name if name not in found else f"{name}-{len(found)}")  # two folders of aircraft with one name
    return found


def refuse(campaign: Campaign, variants: Sequence[Variant], cases: Cases) -> None:
    """Try, without flying, the first case and the ends of every range with every variant.

    Raises
    ------
    InputError
        If a key does not exist there, or a value is wrong, or a base cannot be flown.
    """
    first = cases.values(0)
    places = {key: where_varied(campaign, key) for key in campaign.vary}
    for variant in variants:
        changing = Changing(variant.scenario)
        for key, vary in campaign.vary.items():
            for value in extremes(vary)[:CHECKED]:
                try:
                    made = changing({**first, key: value}, places)
                except InputError as error:
                    raise _located(error, key, variant, len(variants)) from None
                _refuse_unreached(made, {**first, key: value}, places)
        build_flight(variant.scenario)


def _located(error: InputError, key: str, variant: Variant, among: int) -> InputError:
    where = error.where if ", key " in error.where else f"{error.where}, key {key}"
    found = error.found if among == 1 else f"{error.found} (with {variant.title})"
    return InputError(where, found=found, expected=error.expected, remedy=error.remedy)


def _refuse_unreached(scenario: Scenario, values: Mapping[str, Any], places: Mapping[str, str]) -> None:
    lost = reached(scenario, values)
    if not lost:
        return
    raise InputError(
        f"{places[lost[0]]}, key {lost[0]}",
        found="a key that another varied key changes too",
        expected="keys of which none holds another",
        remedy="vary either the section or the keys in it",
    )


def reached(scenario: Scenario, values: Mapping[str, Any]) -> list[str]:
    """Return those of the varied keys whose value is not what a scenario, with defaults filled in, holds there."""
    return [key for key, value in values.items() if value is not None and not _same(value, at(scenario, key))]


def at(scenario: Scenario, key: str) -> Any:
    """Return what a scenario holds at a dotted key, as its sections have it; None where there is nothing."""
    found: Any = scenario
    for part in key.replace("[", ".").replace("]", "").split("."):
        if isinstance(found, (tuple, list)):
            found = found[int(part)] if part.isdigit() and int(part) < len(found) else None
        elif isinstance(found, Mapping):
            found = found.get(part)
        else:
            found = getattr(found, part, None)
    return found


def _same(asked: Any, found: Any) -> bool:
    """Return whether what a file says is what a section holds; a section may hold more, a number stand for three."""
    if asked is None:
        return True
    if hasattr(found, "written"):  # a signal
        found = found.written
    if isinstance(asked, Mapping):
        take = found.get if isinstance(found, Mapping) else lambda name: getattr(found, name, None)
        return found is not None and all(_same(value, take(name)) for name, value in asked.items())
    if isinstance(found, (tuple, list)):
        given = asked if isinstance(asked, (tuple, list)) else (asked,) * len(found)
        return len(given) == len(found) and all(map(_same, given, found))
    return bool(asked == found or asked == getattr(found, "text", None))
