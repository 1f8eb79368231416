"""Faults of engines: what all of them share, and what one asks of the plant.

A fault of an engine is no step of the chain on an effector. While it lasts, the throttle of its engine in JSBSim is

    position = gain x (position that the aircraft's own controls give) + held

after all flight controls, so an autothrottle and the airspeed hold go on acting and may reach an end. The plant is
told at the first sample of the window and at the first one after it (`plants.jsbsim.engine_faults`), and at no other.
Memory: what JSBSim's engine has, its revolutions above all, goes on from where the window left it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, NamedTuple

from pydantic import PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from uavftc.actuators.fault import Fault

ON_JSBSIM = {"analytic": ("plant: jsbsim; the rotational model has no engines", "fly it on jsbsim, or leave it out")}
"""Where faults of engines are refused."""

_EXPECTED = "the number of an engine, 1 is the first in the XML, or its name"


def _engine(value: Any) -> int | str:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 1:
        return value
    if isinstance(value, str) and len(value) <= 60 and re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", value):
        return value
    raise PydanticCustomError("name", "{expected}", {"expected": _EXPECTED})


_NAME = {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "maxLength": 60}
_SCHEMA = {"anyOf": [{"type": "integer", "minimum": 1}, _NAME]}

EngineName = Annotated[int | str, PlainValidator(_engine), WithJsonSchema(_SCHEMA)]
"""An engine by its number or its name; which there are is known when the flight is built."""


class Change(NamedTuple):
    """What a fault does to its engine while it lasts."""

    gain: float
    """Of the throttle position, 0..1."""
    held: float | None = 0.0
    """Added to it; None is the position at the beginning of the window."""
    stopped: bool = False
    """Whether fuel and ignition are shut as well: an engine at throttle 0 idles."""


class EngineFault(Fault):
    """A fault of an engine."""

    remedies: ClassVar[dict[str, str]] = {
        "surface": "leave one of the two out: an entry is a fault of a surface or one of an engine; write two for both",
        "at_deg": "write kind: stuck and at, a throttle position from 0 to 1",
    }

    engine: EngineName
    """number, 1 is the first in the XML, or name, such as `left_motor`"""


def place_of(engine: int | str, names: Sequence[str]) -> int | None:
    """Return the place of an engine in the order of the XML, from 0, or None if there is no such engine."""
    if isinstance(engine, int):
        return engine - 1 if engine <= len(names) else None
    return names.index(engine) if engine in names else None
