"""A comparison: one scenario flown by every combination of plant and controller, side by side in a result folder."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any, get_args

from uavftc.analysis.response import response_s, unequal
from uavftc.control.custom.module import is_path, is_there, registered
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.jobs.campaign.pool import fly_one
from uavftc.jobs.variants import variants_of
from uavftc.report.distance import distance
from uavftc.report.side_by_side import markdown, tidy_csv, title_of
from uavftc.results.context import FigureContext
from uavftc.results.flight import FlightResult
from uavftc.results.folder import ResultFolder
from uavftc.scenario.controllers import CONTROLLERS
from uavftc.scenario.load import controller_name, load_scenario, scenario_text
from uavftc.scenario.overrides import custom_name
from uavftc.scenario.schema import Scenario

PLANTS: tuple[str, ...] = get_args(Scenario.model_fields["plant"].annotation)

Key = tuple[str, str]
"""(plant, controller); of a variant, its name in place of the controller's."""


class Combinations(dict[Key, Scenario]):
    """Scenarios by plant and controller, and what the variants among them change."""

    def __init__(self) -> None:
        super().__init__()
        self.variants: dict[str, dict[str, Any]] = {}
        """By the name of the variant: `of`, the controller, and `changes`, KEY=VALUE each."""


Progress = Callable[[int], AbstractContextManager[Callable[[int], None]]]
"""Given the number of flights, a context that yields a function to call with the flights flown so far."""


def load_combinations(
    source: str | os.PathLike[str] | Mapping[str, Any] | Scenario,
    *,
    plants: str = ",".join(PLANTS),
    controllers: str | None = None,
    aircraft: str | os.PathLike[str] | None = None,
    overrides: Sequence[str] = (),
    variants: Sequence[str] = (),
    set: Mapping[str, Any] | None = None,
) -> Combinations:
    """Return the scenario for every combination of plant and controller, checked, in the order of the lists.

    Parameters
    ----------
    source, aircraft, overrides, set
        As `scenario.load.load_scenario` takes them.
    plants, controllers
        Names with commas between them, as `--controller` takes them; controllers None is that of the scenario.
    variants
        As `variants.variants_of` takes them; each is flown on every plant too.

    Raises
    ------
    InputError
        If a list has an unknown name or one twice, or if the scenario is wrong or cannot be flown on one of the plants.
    """
    chosen = _names("--plants", plants, PLANTS)
    named = [None] if controllers is None else _controllers(controllers)
    loaded = Combinations()
    given: dict[str, Any] = {"overrides": overrides, "aircraft": aircraft, "set": set}
    for plant in chosen:
        for controller in named:
            scenario = load_scenario(source, plant=plant, controller=controller, **given)
            name = controller_name(scenario)
            _refuse_overridden("--set plant", scenario.plant, plant, "--plants")
            meant = name if controller is None else controller if controller in CONTROLLERS else custom_name(controller)
            _refuse_overridden("--set controller", name, meant, "--controllers")
            if (plant, name) in loaded:
                raise InputError(
                    f"--controllers {controllers}",
                    found=f"two controllers with the name {name}",
                    expected="controllers with different names, because results are named after them",
                    remedy="rename one of the modules",
                )
            loaded[plant, name] = scenario
    names = list(dict.fromkeys(name for _, name in loaded))
    found = variants_of(variants, names)
    for variant in found:
        loaded.variants[variant.name] = {"of": names[0], "changes": list(variant.changes)}
        for plant in chosen:
            scenario = load_scenario(source, plant=plant, controller=named[0], changes=variant.options, **given)
            loaded[plant, variant.name] = scenario
    if found:  # those of one plant together
        for key in sorted(loaded, key=lambda key: chosen.index(key[0])):
            loaded[key] = loaded.pop(key)
    return loaded


def compare(
    scenarios: Mapping[Key, Scenario],
    out: Path,
    *,
    figures: bool = True,
    progress: Progress | None = None,
    inputs: Sequence[Path] = (),
    page: Callable[[Mapping[Key, FlightResult], dict[str, Any]], str] | None = None,
) -> dict[str, Any]:
    """Fly all combinations and write the result folder of the comparison, whole or not at all.

    A vehicle lost in one combination does not stop the others.

    Parameters
    ----------
    scenarios
        From `load_combinations`.
    out
        The result folder; an older one is replaced if it is ours.
    figures
        Whether to draw the figures.
    progress
        Shown while flying.
    inputs
        Files that the scenario came from; a folder that holds one of them is not replaced.
    page
        What makes `report.html` of the flights and the document of `summary.json`; None: there is none.

    Returns
    -------
    The document of `summary.json`; with `figures_missing` or `report_missing`, the reason, where there was no room.

    Raises
    ------
    InputError
        If a combination cannot be flown or the folder cannot be written; nothing is written then.
    KeyboardInterrupt
        On Ctrl-C; nothing is written then.
    """
    with ResultFolder(out, inputs) as folder:  # from the start, so that two jobs do not fly for one folder
        flown = fly_combinations(scenarios, progress)
        variants = scenarios.variants if isinstance(scenarios, Combinations) else {}
        return _write(folder, flown, variants, figures=figures, page=page)


def fly_combinations(scenarios: Mapping[Key, Scenario], progress: Progress | None = None) -> dict[Key, FlightResult]:
    """Fly all combinations, in their order; arguments and errors as those of `compare`."""
    flown: dict[Key, FlightResult] = {}
    with nullcontext(None) if progress is None else progress(len(scenarios)) as advance:
        for key, scenario in scenarios.items():
            flown[key] = fly_one(scenario)
            if advance is not None:
                advance(len(flown))
    return flown


def write_comparison(
    flown: Mapping[Key, FlightResult], variants: Mapping[str, Mapping[str, Any]], out: Path, *, figures: bool = True
) -> dict[str, Any]:
    """Write the result folder of flights that are over, whole or not at all; return the document of `summary.json`.

    Parameters
    ----------
    flown
        With their histories.
    variants
        `Combinations.variants`.
    out, figures
        As those of `compare`.

    Raises
    ------
    InputError
        If the folder cannot be written; nothing is written then.
    """
    with ResultFolder(out) as folder:
        return _write(folder, flown, variants, figures=figures)


def _write(
    folder: ResultFolder,
    flown: Mapping[Key, FlightResult],
    variants: Mapping[str, Mapping[str, Any]],
    *,
    figures: bool,
    page: Callable[[Mapping[Key, FlightResult], dict[str, Any]], str] | None = None,
) -> dict[str, Any]:
    document = document_of(flown, variants)
    for name, text in (
        ("comparison.md", markdown(document)),
        ("comparison.csv", tidy_csv(document)),
        ("scenario.yaml", scenario_text(next(iter(flown.values())).scenario)),
    ):
        (folder.path / name).write_text(text, encoding="utf-8", newline="\n")
    (folder.path / "histories").mkdir()
    for (plant, controller), result in flown.items():
        result.write_history(folder.path / "histories" / f"{plant}-{controller}.parquet")
    if figures:
        missing = folder.extra("figures", lambda path: draw(path, flown, title_of(document)))
        if missing is not None:
            document["figures_missing"] = missing
    if page is not None:

        def write(into: Path) -> None:
            into.write_text(page(flown, document), encoding="utf-8", newline="\n")

        missing = folder.extra("report.html", write)
        if missing is not None:
            document["report_missing"] = missing
    return folder.write_summary(document)


def document_of(
    flown: Mapping[Key, FlightResult], variants: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, Any]:
    """Return the document of `summary.json`: the flights, each as in its own `summary.json`, and their distances.

    A flight of a variant has its name as its `controller`, and `variant`: of which controller, and what it changes.
    """
    flights = [result.summary() for result in flown.values()]
    for (_, name), flight in zip(flown, flights, strict=True):
        if variants and name in variants:
            flight |= {"controller": name, "variant": dict(variants[name])}
    first = flights[0]
    origin = first["provenance"]
    return {
        "scenario": first["scenario"],
        "aircraft": first["aircraft"],
        "plants": list(dict.fromkeys(plant for plant, _ in flown)),
        "controllers": list(dict.fromkeys(controller for _, controller in flown)),
        "completed": all(flight["completed"] for flight in flights),
        "combinations": flights,
        "distances": distances(flown),
        "warnings": [*dict.fromkeys(warning for flight in flights for warning in flight["warnings"]), *speeds(flown)],
        "provenance": {key: value for key, value in origin.items() if key not in ("scenario_sha256", "plant_settings")},
    }


def speeds(flown: Mapping[Key, FlightResult]) -> list[str]:
    """Return a line for each plant on which the controllers answer a step at different speeds."""
    found = []
    for plant in dict.fromkeys(plant for plant, _ in flown):
        some = {name: result.history for (on, name), result in flown.items() if on == plant and result.history}
        times = {name: {axis: response_s(history, axis) for axis in AXES} for name, history in some.items()}
        if (line := unequal(times)) is not None:
            found.append(f"{plant}: {line}")
    return found


def distances(flown: Mapping[Key, FlightResult]) -> list[dict[str, Any]]:
    """Return, for each controller and each two plants it was flown on, how far the flights are apart."""
    entries = []
    for (a, controller), (b, other) in combinations(flown, 2):
        one, two = flown[a, controller].history, flown[b, other].history
        if controller != other or one is None or two is None:
            continue
        apart = distance(one, two)
        until = one["time_s"][apart["rows"] - 1] if apart["rows"] else 0.0
        entries.append({"controller": controller, "plants": [a, b], "until_s": float(until), **apart})
    return entries


def draw(folder: Path, flown: Mapping[Key, FlightResult], title: str) -> None:
    """Draw the figures of all flights into `folder`."""
    from uavftc.report.backend import load_matplotlib  # noqa: PLC0415 - matplotlib takes most of a second

    load_matplotlib()
    from uavftc.report.overlays import write_overlays  # noqa: PLC0415

    write_overlays(folder, *drawn(flown, title))


def drawn(flown: Mapping[Key, FlightResult], title: str) -> tuple[dict[Key, Mapping[str, Any]], FigureContext]:
    """Return what the figures of all flights are drawn from: their histories, and the context."""
    context = replace(next(iter(flown.values())).figure_context(), title=title)
    return {key: result.history for key, result in flown.items() if result.history}, context


def _controllers(text: str) -> list[str | None]:
    """Return the names in a list of controllers: pairs of laws, and custom ones by name or path."""
    custom = [name for name in map(str.strip, text.split(",")) if name and (is_path(name) or is_there(name))]
    return [*_names("--controllers", text, [*CONTROLLERS, *registered()], custom)]


def _names(option: str, text: str, known: Sequence[str], others: Sequence[str] = ()) -> list[str]:
    """Return the names in a list with commas; each may appear once, and must be known or among the others."""
    names = [name.strip() for name in text.split(",")]
    expected = f"a list of {', '.join(known)}, with commas, each at most once"
    for i, name in enumerate(names):
        if name not in known and name not in others:
            near = difflib.get_close_matches(name, known, n=1)
            remedy = f"did you mean {near[0]}?" if near else f"for example {option} {','.join(known[:2])}"
            raise InputError(f"{option} {text}", found=f"'{name}'", expected=expected, remedy=remedy)
        if name in names[:i]:
            again = " (--variant NAME:KEY=VALUE flies it with other options)" if option == "--controllers" else ""
            remedy = f"name {name} once{again}"
            raise InputError(f"{option} {text}", found=f"{name} twice", expected=expected, remedy=remedy)
    return names


def _refuse_overridden(where: str, found: str, expected: str, option: str) -> None:
    if found != expected:
        raise InputError(
            where,
            found=f"{found} in place of {expected}",
            expected=f"what is compared, set by {option} only",
            remedy=f"leave it out, or name it in {option}",
        )
