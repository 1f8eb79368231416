"""A comparison: one scenario flown by every combination of plant and controller, side by side in a result folder."""

from __future__ import annotations

import difflib
import hashlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.aircraft.definition import load_aircraft
from uavftc.control.custom.module import checksum, is_path, is_there, registered
from uavftc.core.signals import COLUMNS, SURFACES, as_records, empty_rows
from uavftc.errors import InputError
from uavftc.flight.fly import CHUNK_ROWS
from uavftc.jobs.campaign.pool import Flown, fly_one
from uavftc.report.distance import distance
from uavftc.report.side_by_side import markdown, tidy_csv, title_of
from uavftc.results.folder import ResultFolder
from uavftc.results.history import ParquetRecorder
from uavftc.results.kinds import COMPARISON, PLANTS
from uavftc.results.summary import provenance, summary, write_json
from uavftc.scenario.controllers import OwnController
from uavftc.scenario.load import controller_name, load_scenario, scenario_text, warnings
from uavftc.scenario.overrides import CONTROLLERS, own_name
from uavftc.scenario.schema import Scenario

Key = tuple[str, str]
"""(plant, controller)."""

Progress = Callable[[int], AbstractContextManager[Callable[[int], None]]]
"""Given the number of flights, a context that yields a function to be told the flights flown so far."""


def load_combinations(
    source: str | Path,
    *,
    plants: str = ",".join(PLANTS),
    controllers: str | None = None,
    aircraft: str | None = None,
    overrides: Sequence[str] = (),
) -> dict[Key, Scenario]:
    """Return the scenario for every combination of plant and controller, checked, in the order of the lists.

    Parameters
    ----------
    source, aircraft, overrides
        As `scenario.load.load_scenario` takes them.
    plants, controllers
        Names with commas between them, as `--controller` takes them; controllers None is the scenario's own.

    Raises
    ------
    InputError
        If a list has an unknown name or one twice, or if the scenario is wrong or cannot be flown on one of the plants.
    """
    chosen = _names("--plants", plants, PLANTS)
    wanted = [None] if controllers is None else _controllers(controllers)
    loaded: dict[Key, Scenario] = {}
    for plant in chosen:
        for controller in wanted:
            scenario = load_scenario(source, overrides=overrides, plant=plant, aircraft=aircraft, controller=controller)
            own = controller_name(scenario)
            _refuse_overridden("--set plant", scenario.plant, plant, "--plants")
            named = own if controller is None else controller if controller in CONTROLLERS else own_name(controller)
            _refuse_overridden("--set controller", own, named, "--controllers")
            if (plant, own) in loaded:
                raise InputError(
                    f"--controllers {controllers}",
                    found=f"two controllers that are called {own}",
                    expected="controllers of different names: results are told apart by them",
                    remedy="rename one of the modules",
                )
            loaded[plant, own] = scenario
    return loaded


def compare(
    scenarios: Mapping[Key, Scenario], out: Path, *, figures: bool = True, progress: Progress | None = None
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

    Returns
    -------
    The document of `summary.json`.

    Raises
    ------
    InputError
        If a combination cannot be flown or the folder cannot be written; nothing is written then.
    KeyboardInterrupt
        On Ctrl-C; nothing is written then.
    """
    folder = ResultFolder(out, COMPARISON)
    folder.check()
    flown: dict[Key, Flown] = {}
    with nullcontext(None) if progress is None else progress(len(scenarios)) as advance:
        for key, scenario in scenarios.items():
            flown[key] = fly_one(scenario)  # one by one, and not by fly_all, so that Ctrl-C is seen after each
            if flown[key].outcome.interrupted:  # a flight ends cleanly on Ctrl-C; half a comparison is none
                raise KeyboardInterrupt
            if advance is not None:
                advance(len(flown))
    document = document_of(flown)
    with folder:
        write_json(folder.path / "summary.json", document)
        for name, text in (
            ("comparison.md", markdown(document)),
            ("comparison.csv", tidy_csv(document)),
            ("scenario.yaml", scenario_text(next(iter(flown.values())).scenario)),
        ):
            (folder.path / name).write_text(text, encoding="utf-8", newline="\n")
        (folder.path / "histories").mkdir()
        for (plant, controller), flight in flown.items():
            write_history(folder.path / "histories" / f"{plant}-{controller}.parquet", flight)
        if figures:
            draw(folder.path / "figures", flown, title_of(document))
    return document


def document_of(flown: Mapping[Key, Flown]) -> dict[str, Any]:
    """Return the document of `summary.json`: the flights, each as in its own `summary.json`, and their distances."""
    flights = [flight_summary(flight) for flight in flown.values()]
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
        "warnings": list(dict.fromkeys(warning for flight in flights for warning in flight["warnings"])),
        "provenance": {key: value for key, value in origin.items() if key not in ("scenario_sha256", "plant_settings")},
    }


def flight_summary(flown: Flown) -> dict[str, Any]:
    """Return what `uavftc-fly` would write into `summary.json` of this flight."""
    scenario, outcome = flown.scenario, flown.outcome
    steps = max(outcome.rows - 1, 0)
    return summary(
        scenario=scenario.name,
        aircraft=scenario.aircraft,
        plant=scenario.plant,
        controller=controller_name(scenario),
        completed=outcome.completed,
        ended_because=outcome.ended_because,
        ended_at_s=outcome.ended_at_s,
        axes=flown.axes,
        timing={
            "flight_wall_s": outcome.wall_s,
            "controller_steps": steps,
            "us_per_controller_step": 1e6 * outcome.wall_s / max(steps, 1),
        },
        provenance=origin_of(flown),
        warnings=warnings(scenario),
    )


def origin_of(flown: Flown) -> dict[str, Any]:
    """Return the provenance of a flight."""
    origin = provenance(
        seed=flown.scenario.seed,
        scenario_sha256=hashlib.sha256(scenario_text(flown.scenario).encode()).hexdigest(),
        aircraft_sha256=load_aircraft(flown.scenario.aircraft).sha256(),
        plant_settings=flown.settings,
    )
    if isinstance(flown.scenario.controller, OwnController):
        origin["controller_sha256"] = checksum(flown.scenario.controller.kind)
    return origin


def distances(flown: Mapping[Key, Flown]) -> list[dict[str, Any]]:
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


def write_history(path: Path, flown: Flown) -> None:
    """Write a flight's history as `uavftc-fly` does: the same columns, row groups and metadata."""
    assert flown.history is not None
    records = as_records(empty_rows(len(flown.history["time_s"])))
    for name, field, component in COLUMNS:
        target = records[field] if component is None else records[field][:, component]
        target[:] = flown.history[name]
    origin = {key: str(value) for key, value in origin_of(flown).items()}
    with ParquetRecorder(path, {"scenario": scenario_text(flown.scenario), **origin}) as parquet:
        for start in range(0, len(records), CHUNK_ROWS):
            parquet.take(records[start : start + CHUNK_ROWS])


def draw(folder: Path, flown: Mapping[Key, Flown], title: str) -> None:
    """Draw the figures of all flights into `folder`."""
    from uavftc.report.figures import FaultWindow  # noqa: PLC0415 - matplotlib takes most of a second
    from uavftc.report.overlays import OverlayContext, write_overlays  # noqa: PLC0415

    scenario = next(iter(flown.values())).scenario
    limits = dict(zip(SURFACES, scenario.limits_rad(), strict=True))
    context = OverlayContext(
        title,
        {surface: pair[np.isfinite(pair)].tolist() for surface, pair in limits.items()},
        [
            FaultWindow(f.surface, f.start_s, scenario.duration_s if f.end_s is None else f.end_s, "")
            for f in scenario.faults
        ],
    )
    write_overlays(folder, {key: flight.history for key, flight in flown.items() if flight.history}, context)


def _controllers(text: str) -> list[str | None]:
    """Return the names in a list of controllers: pairs of laws, and one's own by name or path."""
    own = [name for name in map(str.strip, text.split(",")) if name and (is_path(name) or is_there(name))]
    return [*_names("--controllers", text, [*CONTROLLERS, *registered()], own)]


def _names(option: str, text: str, known: Sequence[str], others: Sequence[str] = ()) -> list[str]:
    """Return the names in a list with commas, each there once, and each known or among the others."""
    names = [name.strip() for name in text.split(",")]
    expected = f"a list of {', '.join(known)}, with commas, each at most once"
    for i, name in enumerate(names):
        if name not in known and name not in others:
            near = difflib.get_close_matches(name, known, n=1)
            remedy = f"did you mean {near[0]}?" if near else f"for example {option} {','.join(known[:2])}"
            raise InputError(f"{option} {text}", found=f"'{name}'", expected=expected, remedy=remedy)
        if name in names[:i]:
            raise InputError(f"{option} {text}", found=f"{name} twice", expected=expected, remedy=f"name {name} once")
    return names


def _refuse_overridden(where: str, found: str, expected: str, option: str) -> None:
    if found != expected:
        raise InputError(
            where,
            found=f"{found} in place of {expected}",
            expected=f"what is compared to be told by {option} alone",
            remedy=f"leave it out, or name it in {option}",
        )
