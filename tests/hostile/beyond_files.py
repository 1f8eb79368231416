"""Hostile entries of what goes beyond the paper: faults of each kind, servos, sensors, damage, air, what is known.

The keys are read from the schema, so an effect that is added is attacked too. Each value is plausible for its key, or
anything at all; each document is a shipped scenario whose sections are replaced by such entries.
"""

from __future__ import annotations

import random
import types
import typing
from collections.abc import Callable, Iterator
from typing import Any

from pydantic import BaseModel

from hostile.scenario_files import EXPRESSIONS, SCALARS, Case, Data, render
from uavftc.config.document import parse
from uavftc.config.effect import configs
from uavftc.config.shipped import GROUPS, scenario_dir, scenario_names
from uavftc.environment import KINDS
from uavftc.scenario.damage import Damage
from uavftc.scenario.schema import FAULTS, Scenario

SURFACES = (
    "aileron", "elevator", "rudder", "left_aileron", "right_aileron", "left_ailern", "Left_aileron", "flap", "throttle",
    "left_motor", "", "a" * 100, None, 3, 1.5, ["aileron"], {"a": 1}, "left aileron", "\u202e", "aileron.x",
)  # fmt: skip
ENGINES = (1, 2, 3, 0, -1, 1.0, "left_motor", "right_motor", "left_moter", "motor", 10**30, None, True, "1", [1])
TIMES = (0, 0.0, 0.005, 0.01, 0.02, 0.03, 0.02, 0.05, 5, 1e-9, 20, 1e9, 1e308, -1, None, 5e-324, "0", 0.0123)
NUMBERS = (
    0, 1, -1, 0.5, 0.02, 3, 10, 57, -0.0, 1e-9, 1e-300, 5e-324, 1e6, 1e17, 1e300, 1.7e308, -1e9, 10**25, None, True,
    "1", [1, 2, 3], [1, 1], [0, 0, 0], [1e200] * 3, {"a": 1}, 360, 1e5,
)  # fmt: skip
TRIPLES = (
    [0, 0, 0], [1, 2, 3], [0.1, -0.1, 0], [1e9, 0, 0], [1e308] * 3, [None] * 3, [1, 2], 5, None, [[1, 2, 3]],
    ["t"] * 3, [5e-324] * 3, [-1, -1, -1], {"x": 1}, 0.05, 1e-12,
)  # fmt: skip
SMALL = (0.01, 0.05, 0.5, 1, 3, 20, 57)


def models(annotation: Any) -> list[type[BaseModel]]:
    """Return the models that an annotation names, at any depth."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in typing.get_args(annotation) for model in models(part)]


def choices(annotation: Any) -> list[Any]:
    """Return the words that an annotation allows."""
    if typing.get_origin(annotation) is typing.Literal:
        return list(typing.get_args(annotation))
    return [word for part in typing.get_args(annotation) for word in choices(part)]


def is_list(annotation: Any) -> bool:
    """Whether an annotation is a list or map of anything."""
    origin = typing.get_origin(annotation)
    if origin in (typing.Union, types.UnionType, typing.Annotated):
        return any(is_list(part) for part in typing.get_args(annotation))
    return origin in (tuple, list, dict)


def value(rng: random.Random, name: str, annotation: Any) -> Any:
    """Return a value for a key, more often one that might do than not."""
    if rng.random() < 0.04:
        return rng.choice((rng.choice(SCALARS), rng.choice(EXPRESSIONS)))
    if name == "surface":
        return rng.choice(SURFACES[:5] if rng.random() < 0.9 else SURFACES)
    if name == "engine":
        return rng.choice(ENGINES[:2] if rng.random() < 0.8 else ENGINES)
    if name in ("start_s", "end_s", "known_after_s"):
        return rng.choice(TIMES[:8] if rng.random() < 0.8 else TIMES)
    if words := choices(annotation):
        return rng.choice(words) if rng.random() < 0.9 else rng.choice((None, "x", 1, words))
    if found := models(annotation):
        several = [entry(rng, rng.choice(found)) for _ in range(rng.choice((0, 1, 1, 2, 5)))]
        if is_list(annotation):
            return several if rng.random() < 0.9 else rng.choice((*several, None))
        return rng.choice((*several, None))
    if name in ("control_power", "coefficients"):
        names = SURFACES if name == "control_power" else ("Cl_0", "Cn_beta", "CD_alpha", "CL_q", "Cx_0", "CY_r", "")
        return {str(rng.choice(names)): rng.choice(NUMBERS) for _ in range(rng.choice((0, 1, 2, 6)))}
    if annotation is bool:
        return rng.choice((True, True, False, None, 1, "yes"))
    if is_list(annotation):
        return rng.choice(TRIPLES[:3] if rng.random() < 0.6 else TRIPLES)
    return rng.choice(SMALL) if rng.random() < 0.75 else rng.choice(NUMBERS)


def entry(rng: random.Random, model: type[BaseModel]) -> Data:
    """Return an entry of a model: what it requires, mostly, and some of the rest."""
    made = {}
    for name, field in model.model_fields.items():
        if rng.random() < (0.97 if field.is_required() else 0.3):
            made[name] = value(rng, name, field.annotation)
    if "kind" in model.model_fields:
        made["kind"] = model.model_fields["kind"].default if rng.random() < 0.97 else rng.choice(SCALARS)
    if rng.random() < 0.05:
        made[rng.choice(("at_deg", "engine", "surface", "kind", "width_deg", "End_s", "seed", ""))] = rng.choice(
            NUMBERS
        )
    return made


def several(rng: random.Random, kinds: list[type[BaseModel]], most: int) -> list[Data]:
    """Return some entries, of which two may follow or overlap each other."""
    return [entry(rng, rng.choice(kinds)) for _ in range(rng.randrange(1, most + 1))]


def faults(rng: random.Random, data: Data) -> None:
    """Faults of every kind, on surfaces and engines."""
    data["faults"] = several(rng, list(FAULTS), 4)


def one_fault(rng: random.Random, data: Data) -> None:
    """One fault that is nearly right."""
    data["faults"] = several(rng, list(FAULTS), 1)


def servos(rng: random.Random, data: Data) -> None:
    """Servos, common and by name."""
    (model,) = models(Scenario.model_fields["actuators"].annotation)
    data["actuators"] = entry(rng, model)
    for _ in range(rng.choice((0, 0, 1, 2))):
        data["actuators"][str(rng.choice(SURFACES))] = entry(rng, model) if rng.random() < 0.8 else rng.choice(SCALARS)


def errors(rng: random.Random, data: Data) -> None:
    """Errors of the sensors."""
    (model,) = models(Scenario.model_fields["sensors"].annotation)
    made = entry(rng, model)
    data["sensors"] = {key: made[key] for key in rng.sample(list(made), min(len(made), rng.randrange(1, 7)))}


def damage(rng: random.Random, data: Data) -> None:
    """Damage that leaves a body, or none."""
    data["damage"] = several(rng, [Damage], 3)


def air(rng: random.Random, data: Data) -> None:
    """Air of every kind."""
    data["disturbances"] = several(rng, list(configs(KINDS, "ENTRY_OF", "disturbances")), 3)


FAMILIES: tuple[tuple[Callable[[random.Random, Data], None], int], ...] = (
    (faults, 320), (one_fault, 480), (servos, 300), (errors, 300), (damage, 360), (air, 300),
)  # fmt: skip
AIRCRAFT = ("hale",) * 12 + ("jsbsim:c172p", "jsbsim:SGS")


def beyond_cases(seed: int) -> Iterator[Case]:
    """Yield the hostile files, always the same for a seed."""
    names = ["scenario3", *(name for group in GROUPS for name in scenario_names(group))]
    texts = {name: (scenario_dir() / f"{name}.yaml").read_text(encoding="utf-8") for name in names}
    for spoil, count in FAMILIES:
        for i in range(count):
            rng = random.Random(f"{seed} beyond {spoil.__name__} {i}")
            name = rng.choice(names)
            data, _ = parse(texts[name], name)
            if "c172p" not in name:
                data["aircraft"] = rng.choice(AIRCRAFT)
            data["plant"] = rng.choice(("jsbsim",) * 5 + ("analytic",))
            spoil(rng, data)
            if rng.random() < 0.1:
                rng.choice(FAMILIES)[0](rng, data)
            yield Case(f"{spoil.__name__} {i} of {name}", render(data).encode("utf-8", "surrogatepass"))
