"""What a scenario asks of its aircraft: what it names of it, and what its faults need."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from uavftc.actuators.engine import place_of
from uavftc.actuators.saturation import SurfaceLimits
from uavftc.config.explain import MAX_SHOWN, describe
from uavftc.config.values import Problem, key_text
from uavftc.core.given import Given
from uavftc.core.layout import Layout, targets_of
from uavftc.errors import InputError, join
from uavftc.scenario.checks import entries, overlaps
from uavftc.scenario.schema import Scenario


def refuse_unknown(scenario: Scenario, layout: Layout) -> None:
    """Refuse what the aircraft does not have, two faults at a time on one effector, and two servos of one.

    Raises
    ------
    InputError
        With the place of each key, and all names that there are.
    """
    targets = targets_of(layout.names, layout.gangs)
    known = list(dict.fromkeys((*layout.gangs, *layout.names)))
    named: list[tuple[tuple[str | int, ...], str]] = [
        (("faults", i, "surface"), fault.surface)
        for i, fault in enumerate(scenario.faults)
        if hasattr(fault, "surface")
    ]
    named += [(("damage", i, "control_power", n), n) for i, d in enumerate(scenario.damage) for n in d.control_power]
    if isinstance(scenario.saturation, SurfaceLimits):
        limited = dict.fromkeys((*scenario.saturation.named(), *(scenario.saturation.model_extra or {})))
        named += [(("saturation", name), name) for name in limited]
    named += [(("actuators", name), name) for name in scenario.actuators.named()]
    problems = []
    for key, name in named:
        if name not in targets:
            near = difflib.get_close_matches(name, known, n=1)
            remedy = f"did you mean {near[0]}?" if near else "choose one of them"
            expected = f"one of {', '.join(known)}, the surfaces of {scenario.aircraft}"
            problems.append(Problem(key, describe(name), expected, remedy))
    problems += _engines(scenario, layout.engines)
    if not problems:
        problems = overlaps(scenario, lambda surface: [layout.names[j] for j in targets[surface]])
        problems += twice(scenario, layout)
        problems += overlaps(scenario, lambda engine: [_engine(engine, layout.engines)], "engine")
    refuse(scenario, problems)


def _engines(scenario: Scenario, names: Sequence[str]) -> list[Problem]:
    """Return the engines that a fault names and the aircraft does not have."""
    known = ", ".join(f"{i} ({name})" for i, name in enumerate(names, start=1))
    found = []
    for i, fault in enumerate(scenario.faults):
        if not hasattr(fault, "engine") or place_of(fault.engine, names) is not None:
            continue
        near = difflib.get_close_matches(str(fault.engine), names, n=1)
        if names:
            expected = f"{'one of ' if len(names) > 1 else ''}{known}, the engines of {scenario.aircraft}"
            remedy = f"did you mean {near[0]}?" if near else "choose one of them" if len(names) > 1 else "write 1"
        else:
            expected = f"a fault of a surface: {scenario.aircraft} has no engine whose throttle moves its thrust"
            remedy = "leave the fault out, or choose an aircraft with engines"
        found.append(Problem(("faults", i, "engine"), describe(fault.engine), expected, remedy))
    return found


def _engine(engine: int | str, names: Sequence[str]) -> str:
    """Return the name of an engine that exists."""
    return names[engine - 1] if isinstance(engine, int) else engine


def refuse_impossible(scenario: Scenario, given: Given) -> None:
    """Refuse a fault or a disturbance that this flight cannot have.

    Raises
    ------
    InputError
        With the place of each key.
    """
    found = [
        problem._replace(key=(*key, *problem.key))
        for key, effect, entry in entries(scenario)
        if hasattr(effect, "problems")
        for problem in effect.problems(entry, given)
    ]
    refuse(scenario, found)


def remarks(scenario: Scenario, given: Given) -> list[str]:
    """Return what this flight makes worth knowing about its faults and disturbances, one line each."""
    return [
        f"{key_text((*key, field))}: {line}"
        for key, effect, entry in entries(scenario)
        if hasattr(effect, "remarks")
        for field, line in effect.remarks(entry, given)
    ]


def refuse(scenario: Scenario, problems: list[Problem]) -> None:
    """Refuse a scenario, with the place of each key in its file.

    Raises
    ------
    InputError
        If there is any problem.
    """
    if problems:
        where = scenario.origin.where
        shown = [
            InputError(where(p.key), found=p.found, expected=p.expected, remedy=p.remedy) for p in problems[:MAX_SHOWN]
        ]
        raise join(shown)


def twice(scenario: Scenario, layout: Layout) -> list[Problem]:
    """Return the servos of two gangs that share an effector without keys of its own."""
    own = scenario.actuators.named()
    found, first = [], dict[str, str]()
    for gang in (name for name in own if name in layout.gangs):
        for name in layout.gangs[gang]:
            if name in first and (name not in own or name in layout.gangs):
                what = f"{name}, which is of {first[name]} too"
                remedy = f"name {name} by itself, or one of the two gangs only"
                problem = Problem(("actuators", gang), what, "one servo for each effector", remedy)
                found.append(problem)
            first.setdefault(name, gang)
    return found
