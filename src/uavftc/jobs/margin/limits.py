"""The limits of controllers in a scenario: for each quantity, where the verdict on the flight changes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.jobs.campaign.pool import fly_one
from uavftc.jobs.margin.linear import linear_margins
from uavftc.jobs.margin.quantities import Quantity
from uavftc.jobs.margin.search import Judged, Limit, find
from uavftc.scenario.changed import remade
from uavftc.scenario.load import controller_name
from uavftc.scenario.schema import Scenario


class Found(NamedTuple):
    """The limit of one controller in one quantity."""

    controller: str
    quantity: Quantity
    limit: Limit
    linear: float | None
    """The limit of the linear loop, where the law is linear."""

    def document(self) -> dict[str, Any]:
        """Return it as `--json` prints it; numbers that do not apply are None."""
        limit = self.limit
        return {
            "controller": self.controller,
            "quantity": self.quantity.name,
            "of": self.quantity.of,
            "value": None if limit.broke is None else limit.held,
            "unit": self.quantity.unit,
            "criterion": limit.criterion,
            "bracket": [limit.held, limit.broke],
            "monotone": limit.monotone,
            "linear": self.linear,
            "flights": len(limit.flown),
        }


def targets_of(scenario: Scenario) -> list[str]:
    """Return what effectiveness and bias are asked of: the gangs of several effectors, then the effectors."""
    layout = build_flight(scenario).layout
    several = [name for name, members in layout.gangs.items() if len(members) > 1]
    return list(dict.fromkeys([*several, *layout.names]))


def find_limits(
    scenarios: Mapping[str, Scenario],
    quantities: Sequence[Quantity],
    *,
    progress: Callable[[int, int, str], None] | None = None,
) -> list[Found]:
    """Return the limit of each controller in each quantity.

    Parameters
    ----------
    scenarios
        By the name of the controller.
    quantities
        What is varied.
    progress
        Called with limits found so far, how many there will be, and what is looked for.

    Raises
    ------
    InputError
        If a scenario cannot be flown, or has no such key.
    """
    found: list[Found] = []
    total = len(scenarios) * len(quantities)
    for name, scenario in scenarios.items():
        _refuse_unjudged(scenario)
        linear = linear_margins(scenario)
        for quantity in quantities:
            if progress is not None:
                progress(len(found), total, f"{name}: {quantity.title}")
            limit = find(lambda value, s=scenario, q=quantity: judged(s, q, value), quantity.values)  # type: ignore[misc]
            found.append(Found(name, quantity, limit, linear.get(quantity.name)))
    return found


def judged(scenario: Scenario, quantity: Quantity, value: float) -> Judged:
    """Fly one value."""
    made = remade(scenario, lambda document: quantity.put(document, value), f"{quantity.title} = {value:g}")
    verdict = fly_one(made, keep_history=False).verdict
    assert verdict is not None  # nothing here is ended by the user alone
    return Judged(verdict.margin, verdict.outcome == "survived", _criterion(verdict.outcome, verdict.limiting))


def _criterion(outcome: str, limiting: str | None) -> str:
    return outcome if outcome in ("lost", "numerical") or limiting is None else limiting


def _refuse_unjudged(scenario: Scenario) -> None:
    if scenario.requirements == ():
        raise InputError(
            scenario.origin.where(("requirements",)),
            found="none",
            expected="at least one requirement, so that a verdict can change",
            remedy="leave requirements out for the default set",
        )


def names_of(scenarios: Sequence[Scenario]) -> dict[str, Scenario]:
    """Return scenarios by the name of their controller."""
    return {controller_name(scenario): scenario for scenario in scenarios}
