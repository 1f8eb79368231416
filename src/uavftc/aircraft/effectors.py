"""Effectors in a companion file: named surfaces and engines, and the gangs in which surfaces serve an axis.

`effectors:` names as many as the aircraft has; `surfaces:` is the short form of three, one an axis. A gang says how
the deflection that an axis is commanded is shared: `aileron: {left_aileron: 1, right_aileron: -1}`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import AfterValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from uavftc.config.values import Model, Number, Positive, Problem
from uavftc.core.signals import COLUMNS, SURFACES

# JSBSim aborts the process when asked for a name that is no XML name, so no other ever reaches it.
_PROPERTY = r"[A-Za-z_][A-Za-z0-9_.-]*(\[[0-9]+\])?(/[A-Za-z_][A-Za-z0-9_.-]*(\[[0-9]+\])?)*"
NAME = r"[A-Za-z][A-Za-z0-9_]*"


def is_property(name: str) -> bool:
    """Return whether JSBSim may be asked for a property of this name; one with a slash first is another program's."""
    return len(name) <= 200 and re.fullmatch(f"/?{_PROPERTY}", name) is not None


def _property(name: str) -> str:
    if not is_property(name):
        raise PydanticCustomError("property", "the path of a JSBSim property, such as fcs/aileron-cmd-norm or a/b[1]")
    return name


def _weight(value: float) -> float:
    if value == 0.0:
        raise PydanticCustomError("weight", "a number other than 0: 1 or -1 where all move by the same angle")
    return value


_TAKEN = {c.name for c in COLUMNS} | {f"{name}_{kind}_rad" for name in SURFACES for kind in ("position", "servo")}

Property = Annotated[
    str, AfterValidator(_property), WithJsonSchema({"type": "string", "pattern": f"^/?{_PROPERTY}$", "maxLength": 200})
]
Weight = Annotated[Number, AfterValidator(_weight), WithJsonSchema({"type": "number", "not": {"const": 0}})]


class Surface(Model):
    """A control surface: its command and position properties, and how the command counts.

    `rad_per_command` is the deflection, rad, per unit of the command; null is measured. `stop_rad` is the mechanical
    stop either side of neutral; null is measured at full command.
    """

    command: Property
    """JSBSim property that commands it"""
    position: Property | None = None
    """JSBSim property of its deflection; `null` is none"""
    stop_rad: Positive | None = None
    """mechanical stop either side of neutral; `null` is measured at full command"""
    rad_per_command: Number | None = None
    """deflection per unit of the command; `null` is measured"""


def standard(command: str, position: str) -> Surface:
    """Return a surface of JSBSim's standard property names."""
    return Surface(command=f"fcs/{command}-cmd-norm", position=f"fcs/{position}-pos-rad")


class Surfaces(Model):
    """The three surfaces; deflections count so that positive gives a positive moment about the surface's axis."""

    aileron: Surface = standard("aileron", "left-aileron")
    """about roll"""
    elevator: Surface = standard("elevator", "elevator")
    """about pitch"""
    rudder: Surface = standard("rudder", "rudder")
    """about yaw"""


class Throttle(Model):
    """Commands that the trim sets, 0..1, and the positions that result; without these, the command is recorded."""

    command: Annotated[tuple[Property, ...], Field(min_length=1)]
    """JSBSim properties that command the engines"""
    position: Annotated[tuple[Property, ...], Field(min_length=1)] | None = None
    """JSBSim properties of what results; `null` records the commands"""


class Effector(Model):
    """A surface (`command`) or an engine (`throttle`); deflections count as the position property does.

    Without a position, a positive deflection is that of a positive command.
    """

    command: Property | None = None
    """of a surface: JSBSim property that commands it"""
    position: Property | None = None
    """JSBSim property of its deflection; `null` is none"""
    stop_rad: Positive | None = None
    """mechanical stop either side of neutral; `null` is measured at full command"""
    rad_per_command: Number | None = None
    """deflection per unit of the command; `null` is measured"""
    throttle: Property | None = None
    """of an engine: JSBSim property of its throttle command"""

    def surface(self) -> Surface:
        """Return the surface that this is."""
        assert self.command is not None  # checked when the file is read
        return Surface(**self.model_dump(exclude={"throttle"}))


class Measured(NamedTuple):
    """An effector of an aircraft at one trim, as measured on JSBSim; its deflection counts as its position does."""

    name: str
    command: str
    """Property."""
    position: str | None
    """Property; None where the aircraft reports none, or none in rad or deg."""
    position_rad: float
    """rad per unit of the position property."""
    rad_per_command: float
    """Deflection, rad, per unit of command, in the small."""
    measured: bool
    """Whether that is read from the position or the companion file; else a nominal angle stands for full command."""
    trim_command: float
    trim_rad: float
    """Deflection at trim, rad: the position, or what stands for it."""
    commands: list[float]
    """Least and greatest command."""
    limits_rad: list[float]
    """Least and greatest deflection about trim, rad: the position at the two ends of the command."""
    ideal: bool
    """Whether the position is trim + rad_per_command x command, one frame later, to 1e-12 rad between the stops."""
    B: list[float]
    """(6,) change of u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2, per rad of deflection."""
    full_response: list[float]
    """Response at either end of the command over that which the slope gives; about its main axis."""
    nonlinearity: float
    """Relative difference of the response between two small steps."""
    servo: dict[str, float]
    """What the XML's actuator does: some of `lag_radps`, `delay_s`, `backlash_rad`, `rate_radps`."""


SERVO = {
    "lag_radps": ("lag", 1.0, "rad/s"),
    "delay_s": ("delay", 1e3, "ms"),
    "backlash_rad": ("backlash", 180.0 / math.pi, "deg"),
    "rate_radps": ("rate", 180.0 / math.pi, "deg/s"),
}


def servo_text(servo: Mapping[str, float]) -> str:
    """Return what a servo does, in words: `lag 57.1 rad/s, delay 20 ms, backlash 1 deg`; empty where it does nothing.

    Backlash is the width of the XML's hysteresis.
    """
    return ", ".join(f"{word} {servo[key] * factor:.3g} {unit}" for key, (word, factor, unit) in SERVO.items()
                     if key in servo)  # fmt: skip


def mixing_of(names: tuple[str, ...], gangs: Mapping[str, Mapping[str, float]]) -> np.ndarray:
    """Return the deflection of each effector per axis command, shape (n, 3), of gangs by surface name."""
    M = np.zeros((len(names), 3))
    for i, axis in enumerate(SURFACES):
        for name, weight in gangs.get(axis, {}).items():
            M[names.index(name), i] = weight
    return M


def problems(
    effectors: Mapping[str, Effector], gangs: Mapping[str, Mapping[str, float]], given: set[str]
) -> list[Problem]:
    """Return what is wrong with effectors and gangs together."""
    found = []
    if effectors and "surfaces" in given:
        found.append(
            Problem(("surfaces",), "next to effectors", "one of the two", "name the surfaces in effectors and gangs")
        )
    if any(e.throttle is not None for e in effectors.values()) and "throttle" in given:
        found.append(Problem(("throttle",), "next to engines in effectors", "one of the two", "leave throttle out"))
    for name, effector in effectors.items():
        if not re.fullmatch(NAME, name) or len(name) > 60:
            rule = "letters, digits and _, beginning with a letter, at most 60"
            found.append(Problem(("effectors", name), f"the name {name!r}", rule, "rename it"))
        if name not in SURFACES and (shown := {f"{name}{kind}_rad" for kind in ("", "_cmd")} & _TAKEN):
            what = f"the name {name!r}: the history has a column {min(shown)} already"
            found.append(Problem(("effectors", name), what, "a name without a column", "rename it"))
        if (effector.command is None) == (effector.throttle is None):
            what = "neither command nor throttle" if effector.command is None else "both command and throttle"
            expected = "command for a surface, throttle for an engine"
            found.append(Problem(("effectors", name), what, expected, "give one of the two"))
    surfaces = [name for name, e in effectors.items() if e.command is not None]
    for gang, members in gangs.items():
        if gang not in SURFACES:
            fix = "name the gang after the axis that it serves"
            found.append(Problem(("gangs", gang), f"the gang {gang!r}", ", ".join(SURFACES), fix))
        for name in members:
            if name not in surfaces:
                what = ", ".join(surfaces) or "a surface of effectors:"
                found.append(Problem(("gangs", gang, name), f"'{name}'", what, "name a surface of effectors"))
    for name in set(surfaces) & set(SURFACES):
        if any((name in members) != (gang == name and list(members) == [name]) for gang, members in gangs.items()):
            rule = f"a surface called {name} alone in the gang {name}: the history has both under one name"
            found.append(Problem(("effectors", name), f"a member of another gang, or one of several in {name}", rule,
                                 f"rename the effector, left_{name} say"))  # fmt: skip
    return found
