"""What a controller knows of the faults: for each fault that is `known`, a record from `known_after_s` after it begins.

The record says what was true `known_after_s` ago: it comes and goes that much later than the fault, and a parameter
that is a signal of t has its value of then. Angles are in rad.
"""

from __future__ import annotations

import math
import re
from collections import namedtuple
from collections.abc import Callable
from typing import Any, NamedTuple

from uavftc.config.values import Model, Signal
from uavftc.core.given import Given

_HEAD = ("kind", "surface", "engine", "effectors", "since_s")
_NOT_SHOWN = ("kind", "surface", "engine", "start_s", "end_s", "known", "known_after_s")
_IN_DEGREES = re.compile(r"_deg(?=ps2?$|$)")


class _Entry(NamedTuple):
    """One fault that is known for a time."""

    from_s: float
    until_s: float
    record: Callable[[float], Any]


def fields_of(config: type[Model]) -> tuple[str, ...]:
    """Return the fields of the record of a kind of fault, in their order."""
    own = config.model_fields
    return (*(n for n in _HEAD if n not in ("surface", "engine") or n in own), *parameters_of(config).values())


def parameters_of(config: type[Model]) -> dict[str, str]:
    """Return the keys of a kind of fault that are its parameters, with their names in a record."""
    return {key: _IN_DEGREES.sub("_rad", key) for key in config.model_fields if key not in _NOT_SHOWN}


class Known:
    """The faults of a flight as far as they are known."""

    def __init__(self, given: Given) -> None:
        self._entries = [
            _Entry(fault.known_from_s, _end(fault), _maker(fault, given))
            for fault in given.faults
            if fault.known
        ]  # fmt: skip

    def at(self, t: float) -> tuple[Any, ...]:
        """Return the records of what is known at t, s, in the order of the scenario."""
        return tuple([e.record(t) for e in self._entries if e.from_s <= t < e.until_s])

    def first_of_each_kind(self) -> list[tuple[float, Any]]:
        """Return one record of each kind that will be known, with when it is first."""
        found: dict[tuple[str, ...], tuple[float, Any]] = {}
        for e in self._entries:
            record = e.record(e.from_s)
            found.setdefault((record.kind, *record._fields), (e.from_s, record))
        return list(found.values())


def _end(fault: Any) -> float:
    return math.inf if fault.known_until_s is None else float(fault.known_until_s)


def _maker(fault: Any, given: Given) -> Callable[[float], Any]:
    """Return what makes the record of a fault at t; one without signals of t is made once."""
    config = type(fault)
    fields = fields_of(config)
    kind = namedtuple(f"{fault.kind.title().replace('-', '')}Fault", fields)  # type: ignore[misc]
    surface, engine = getattr(fault, "surface", None), getattr(fault, "engine", None)
    members = given.targets.get(surface, {}) if surface is not None else {}
    effectors = tuple(given.effectors[j] for j in members)
    head = {"kind": fault.kind, "surface": surface, "engine": engine, "effectors": effectors, "since_s": fault.start_s}
    named = parameters_of(config)
    given_values = {key: getattr(fault, key) for key in named}

    def record(t: float) -> Any:
        at = max(t - fault.known_after_s, fault.start_s)
        parameters = {named[key]: _shown(key, value, at) for key, value in given_values.items()}
        values: dict[str, Any] = head | parameters
        return kind(**{field: values[field] for field in fields})

    if any(isinstance(value, Signal) and value.constant is None for value in given_values.values()):
        return record
    same = record(fault.start_s)
    return lambda t: same


def _shown(key: str, value: Any, t: float) -> Any:
    """Return a parameter at t, s: a signal as its value, an angle in rad, a list as a tuple."""
    if isinstance(value, Signal):
        value = float(value.sample([t])[0])  # type: ignore[arg-type]
    if isinstance(value, list | tuple):
        return tuple(_shown(key, item, t) for item in value)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return math.radians(value) if is_number and _IN_DEGREES.search(key) else value
