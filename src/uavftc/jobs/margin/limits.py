"""The limits of controllers in a scenario: for each quantity, where the verdict on the flight changes."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from uavftc.errors import InputError
from uavftc.flight.build import Flight, build_flight
from uavftc.jobs.campaign.pool import fly_one
from uavftc.jobs.compare import load_combinations
from uavftc.jobs.margin.linear import linear_margins
from uavftc.jobs.margin.quantities import Quantity, chosen
from uavftc.jobs.margin.search import Judged, Limit, find
from uavftc.results.flight import origin_of
from uavftc.results.folder import ResultFolder
from uavftc.scenario.changed import remade
from uavftc.scenario.load import load_scenario, scenario_text
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
            "title": self.quantity.title,
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

    def curve(self) -> list[list[float]]:
        """Return [value, margin] of every flight, by value."""
        return [[value, judged.margin] for value, judged in sorted(self.limit.flown.items())]


def targets_of(flight: Flight) -> list[str]:
    """Return what effectiveness and bias are asked of: the gangs of several effectors, then the effectors."""
    layout = flight.layout
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


def load(
    source: str | Path,
    *,
    controllers: str | None = None,
    plant: str | None = None,
    aircraft: str | None = None,
    overrides: Sequence[str] = (),
) -> Mapping[str, Scenario]:
    """Return the scenario of each controller by its name; arguments as `compare.load_combinations` takes them.

    Raises
    ------
    InputError
        If a controller does not exist or the scenario is wrong.
    """
    plants = plant or load_scenario(source, overrides=overrides).plant
    loaded = load_combinations(source, plants=plants, controllers=controllers, aircraft=aircraft, overrides=overrides)
    return {name: scenario for (_, name), scenario in loaded.items()}


def find_and_write(
    scenarios: Mapping[str, Scenario],
    out: Path,
    *,
    quantities: Sequence[str] | None = None,
    over: Sequence[str] = (),
    figures: bool = True,
    progress: Callable[[int, int, str], None] | None = None,
    inputs: Sequence[Path] = (),
) -> dict[str, Any]:
    """Find the limits and write them into a result folder: `margin.json`, `scenario.yaml`, a figure, `summary.json`.

    Parameters
    ----------
    scenarios
        From `load`.
    out
        The result folder; an older one is replaced if it is ours.
    quantities, over
        As `quantities.chosen` takes them.
    figures
        Whether to draw.
    progress
        As `find_limits` takes it.
    inputs
        Files that the scenario came from; a folder that holds one of them is not replaced.

    Raises
    ------
    InputError
        If the input is wrong or the folder cannot be written; nothing is written then.
    """
    first = next(iter(scenarios.values()))
    flight = build_flight(first)
    asked = chosen(quantities, over, targets_of(flight))
    with ResultFolder(out, inputs) as folder:
        found = find_limits(scenarios, asked, progress=progress)
        limits = [{**one.document(), "curve": one.curve()} for one in found]
        limits.sort(key=lambda entry: [q.title for q in asked].index(entry["title"]))
        document: dict[str, Any] = {
            "title": f"{first.name} on {first.aircraft}, {first.plant}",
            "scenario": first.name,
            "aircraft": first.aircraft,
            "plant": first.plant,
            "controllers": list(scenarios),
            "limits": [{key: value for key, value in entry.items() if key != "title"} for entry in limits],
            "provenance": origin_of(flight),
        }
        (folder.path / "scenario.yaml").write_text(scenario_text(flight.scenario), encoding="utf-8", newline="\n")
        shown = [{key: value for key, value in entry.items() if key != "curve"} for entry in document["limits"]]
        (folder.path / "margin.json").write_text(
            json.dumps(shown, indent=2, allow_nan=False) + "\n", encoding="utf-8", newline="\n"
        )
        if figures:
            missing = folder.figures(lambda path: _draw(path, document))
            if missing is not None:
                document["figures_missing"] = missing
        return folder.write_summary(document)


def _draw(folder: Path, document: Mapping[str, Any]) -> None:
    from uavftc.report.backend import load_matplotlib  # noqa: PLC0415

    load_matplotlib()
    from uavftc.report.margin_figure import write_limits_figure  # noqa: PLC0415

    folder.mkdir(exist_ok=True)
    write_limits_figure(folder / "margin.png", document["title"], document["limits"])
