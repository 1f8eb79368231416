"""What a step in plain Python may ask for beside t, x1_c, x1, x2: named in its signature, given by keyword.

What it does not name is neither read nor given. All of it is as it is at t_k, without sensor errors: only attitude and
rates have those.
"""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from uavftc.control.custom.guard import Guard
from uavftc.control.custom.known import Known
from uavftc.core.given import Given
from uavftc.core.signals import EFFECTOR, ROW, ROW_WIDTH, Shape
from uavftc.errors import InputError

STANDARD_GRAVITY = 9.80665  # m/s^2, ISO 80000-3

_CLOSE = 0.86  # likeness of an argument with a default to a name of the table, from which on it is a typing error


class Quantity(NamedTuple):
    """One thing that a step may ask for."""

    shape: str
    unit: str
    meaning: str
    field: str = ""
    """Of the row, for what the plant measures in the air; empty for what every plant has."""


MEASURED: dict[str, Quantity] = {
    "positions": Quantity(
        "(n,)", "rad", "position of each effector of `design.effectors`, trim included, as it counts: where the "
        "command of the sample before has brought it",
    ),
    "u2": Quantity(
        "(3,)", "rad", "what aileron, elevator and rudder get from the effectors at these positions, about trim",
    ),
    "faults": Quantity("", "", "what is known of faults now: a tuple of records, see below"),
    "airspeed": Quantity("", "m/s", "true airspeed", "airspeed"),
    "alpha": Quantity("", "rad", "angle of attack", "alpha"),
    "beta": Quantity("", "rad", "sideslip, positive with the wind from the right", "beta"),
    "dynamic_pressure": Quantity("", "Pa", "dynamic pressure", "qbar"),
    "throttle": Quantity("", "", "throttle, 0 to 1; nan without an engine", "throttle"),
    "accelerations": Quantity(
        "(3,)", "m/s^2", "specific force in body axes, as accelerometers at the centre of gravity show it: 9.80665 "
        "times the load factor; z is -9.8 in level flight", "load_factor",
    ),
    "altitude": Quantity("", "m", "altitude above mean sea level", "altitude"),
}  # fmt: skip
"""By the name of the argument. What has a field is there on JSBSim only: a rotational model flies in no air."""

_OTHER_WORDS = {
    "qbar": "dynamic_pressure", "q_bar": "dynamic_pressure", "specific_force": "accelerations",
    "load_factor": "accelerations", "a_b": "accelerations", "tas": "airspeed", "surfaces": "positions",
    "deflections": "positions", "height": "altitude",
}  # fmt: skip


class Aboard(NamedTuple):
    """What a flight can show to its controller."""

    given: Given
    position_sign: np.ndarray
    """Of the position that is shown, per that of the row, shape (n,): 1 or -1."""
    air: Mapping[str, Any] | None
    """What has a field in MEASURED, at the trim; None where the plant has no air."""
    columns: frozenset[str]
    """Of the history, without a controller's own."""
    engines: int = 0

    @classmethod
    def of(cls, given: Given) -> Aboard:
        """Return it for a flight without air."""
        return cls(given, np.ones(len(given.effectors)), None, frozenset())

    @property
    def own(self) -> int:
        """Place in a row of the first number of a controller's own."""
        return Shape(len(self.given.effectors), self.engines).width


def asked(step: Callable[..., Any], file: str, aboard: Aboard) -> tuple[str, ...]:
    """Return what of the table a step asks for, in the order of its arguments.

    An argument with a default is left to it where the plant lacks what it asks for, or where it asks for nothing of the
    table. ``*args`` and ``**kwargs`` ask for nothing.

    Raises
    ------
    InputError
        If it asks for what is not in the table, or for what the plant does not have.
    """
    found: list[str] = []
    for parameter in _more(step):
        name, has_default = parameter.name, parameter.default is not inspect.Parameter.empty
        if name not in MEASURED:
            near = difflib.get_close_matches(name, MEASURED, n=1, cutoff=_CLOSE if has_default else 0.6)
            if has_default and not near:
                continue
            meant = _OTHER_WORDS.get(name.lower(), near[0] if near else None)
            raise InputError(
                f"{file}, step",
                found=f"the argument {name}",
                expected=f"t, x1_c, x1, x2, and of these what it needs, by name: {', '.join(MEASURED)}",
                remedy=f"did you mean {meant}?" if meant else "remove it, or give it a default (name=value)",
            )
        if MEASURED[name].field and aboard.air is None:
            if has_default:
                continue
            there = ", ".join(other for other, quantity in MEASURED.items() if not quantity.field)
            raise InputError(
                f"{file}, step",
                found=f"the argument {name} on plant: analytic, a rotational model without air",
                expected=f"of {there} what it needs",
                remedy=f"fly it on plant: jsbsim; or give the argument a default, {name}=None, which it has here",
            )
        found.append(name)
    return tuple(found)


def _more(step: Callable[..., Any]) -> list[inspect.Parameter]:
    """Return the parameters of a step behind the first four that can be given by keyword."""
    guard = Guard()
    try:
        with guard.armed():
            parameters = list(inspect.signature(step).parameters.values())
            kinds = inspect.Parameter
            placed = [p for p in parameters if p.kind in (kinds.POSITIONAL_ONLY, kinds.POSITIONAL_OR_KEYWORD)]
            first = {p.name for p in placed[:4]}
            named = (kinds.POSITIONAL_OR_KEYWORD, kinds.KEYWORD_ONLY)
            return [p for p in parameters if p.kind in named and p.name not in first]
    except BaseException as error:  # it does not say; then it asks for nothing
        if guard.is_users(error):
            raise
        return []


def recalled(names: tuple[str, ...]) -> bool:
    """Return whether what is asked for belongs to the row before, and has to be kept for it."""
    return "positions" in names or "u2" in names


Reader = Callable[[np.ndarray], Any]


def readers(names: tuple[str, ...], aboard: Aboard) -> list[tuple[str, Reader]]:
    """Return how each of these is taken from a copy of the row, shape (width,)."""
    return [(name, _reader(name, aboard)) for name in names]


def _reader(name: str, aboard: Aboard) -> Reader:
    if name == "faults":
        known = Known(aboard.given)
        return lambda row: known.at(row.item(0))
    if name == "positions":
        first = ROW_WIDTH + EFFECTOR.fields["position"][1] // 8  # type: ignore[index]
        stride = EFFECTOR.itemsize // 8
        each = slice(first, first + stride * (len(aboard.given.effectors) - 1) + 1, stride)
        sign = aboard.position_sign
        return lambda row: sign * row[each]
    dtype, offset = ROW.fields[MEASURED[name].field or name][:2]  # type: ignore[index]
    at = offset // 8
    if not dtype.shape:
        return lambda row: row.item(at)
    if name == "accelerations":
        return lambda row: STANDARD_GRAVITY * row[at : at + 3]
    return lambda row: row[at : at + 3]


def at_trim(names: tuple[str, ...], aboard: Aboard) -> dict[str, Any]:
    """Return what each of these is at the trim, for the trial; of faults nothing is known there."""
    design = aboard.given.design
    values = {"positions": design.positions_trim_rad, "u2": np.zeros(3), "faults": (), **(aboard.air or {})}
    return {name: np.array(values[name]) if isinstance(values[name], np.ndarray) else values[name] for name in names}
