"""What an effect is, and where its keys are in a scenario.

An effect (of the actuators, the sensors, the air, a control law) is one module with

    Config        its keys: a `values.Model`; None if it has none
    its place     one of SECTION, KEYS_IN and ENTRY_OF, see below
    blocks        blocks(config, given) -> list of blocks; empty where it does nothing, so that it costs nothing
    prescribe     prescribe(entry, t, records, targets): signals of time that a scenario gives; optional
    drawn         drawn(entry, seed, place) -> what is prescribed in place of the `place`-th entry of this kind, once
                  what is random in it is drawn: with the same `start_s` and `end_s`; optional
    FIELDS        fields of the row that an entry adds to, by `prescribe` or by its law; of a kind of disturbance
    wind_at_start wind_at_start(entry, height) -> velocity of the air that its law adds at t = 0, north-east-down, m/s,
                  shape (3,), at a height above ground, m: the flight starts in this air; optional
    at_rest       at_rest(config, given, rest, reach) -> list of reaches: where constant commands take an
                  effector at rest, see actuators/at_rest.py; of an effect that changes it
    change        change(entry): of a fault of an engine, in place of `blocks`; see actuators/engine.py
    REFUSED_ON    {plant: (what is expected instead, how to fix it)}; optional
    warnings      warnings(entry, t, window) -> (key, line) of what is allowed and worth knowing about it; optional
    problems      problems(entry, given) -> list of `values.Problem`, what the flight cannot have; optional
    remarks       remarks(entry, given) -> (key, line) of what this flight makes worth knowing about it; optional

and it takes part because its module is listed in the tuple of its chain. Its place is one of

    SECTION = "saturation"       `Config` is a section, which may be null
    KEYS_IN = "sensors"          the keys of `Config` are in this section, next to those of other effects
    ENTRY_OF = "faults"          `Config` is one kind of entry in this list; its `label` says what it is, in short

    FAULT         next to any of these: a kind of entry in `faults` that changes a parameter of the effect for a time;
                  its law finds such entries by `given.faults_of(FAULT)`; and FIRST, where its law keeps in its memory
                  what the fault changed (actuators/servo.py)
"""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any

from pydantic import BaseModel, create_model

from uavftc.config.values import Model

Effect = ModuleType

ENGINE = "engine "
"""What the tag of a fault of an engine begins with."""


def configs(effects: Sequence[Effect], place: str, name: str) -> list[type[BaseModel]]:
    """Return the `Config` of each effect whose `place` (SECTION, KEYS_IN, ENTRY_OF) is `name`, in their order."""
    return [effect.Config for effect in effects if getattr(effect, place, None) == name]


def faults(effects: Sequence[Effect]) -> list[tuple[Effect, type[BaseModel]]]:
    """Return the kinds of entry in `faults`, each with its effect, in the order of the chain."""
    found = []
    for effect in effects:
        if getattr(effect, "ENTRY_OF", None) == "faults":
            found.append((effect, effect.Config))
        if hasattr(effect, "FAULT"):
            found.append((effect, effect.FAULT))
    return found


def section(name: str, effects: Sequence[Effect], doc: str, module: str, *, named: str | None = None) -> Any:
    """Return the section in which the effects with KEYS_IN `name` have their keys, in their order.

    `module` holds it as `named`, or under its name, capitalised, so that a scenario can be sent to another process.
    """
    bases = tuple(reversed(configs(effects, "KEYS_IN", name))) or (Model,)
    return create_model(named or name.capitalize(), __base__=bases, __doc__=doc, __module__=module)


def default_kind(config: type[BaseModel]) -> str:
    """Return the kind of a section, as a scenario names it."""
    return str(config.model_fields["kind"].default)


def tag_of(config: type[BaseModel]) -> str:
    """Return what tells an entry from all others: a fault of an engine may have the kind of one of a surface."""
    kind = default_kind(config)
    return f"{ENGINE}{kind}" if "engine" in config.model_fields else kind


def config_of(effect: Effect, scenario: Any) -> Any:
    """Return what a scenario says of an effect: its section or None, the section with its keys, or its entries."""
    if hasattr(effect, "SECTION"):
        return getattr(scenario, effect.SECTION)
    if hasattr(effect, "KEYS_IN"):
        return getattr(scenario, effect.KEYS_IN)
    if hasattr(effect, "ENTRY_OF"):
        return tuple(entry for entry in getattr(scenario, effect.ENTRY_OF) if isinstance(entry, effect.Config))
    return None
