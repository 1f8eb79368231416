"""A controller's own signals: what `create` declares next to its step, with units, is recorded and drawn.

    return step, {"omega_hat": "1", "x2_tilde": ("rad/s", 3), "e": ("rad", ("phi", "theta", "psi"))}

A number, so many of them, or one for each label. The name of a column ends in the unit: omega_hat, x2_tilde_1_radps,
e_phi_rad.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from typing import Any

from uavftc.control.custom.text import shown
from uavftc.core.layout import OwnSignal
from uavftc.errors import InputError

UNITS = {
    "1": "", "rad": "_rad", "rad/s": "_radps", "rad/s^2": "_radps2", "deg": "_deg", "deg/s": "_degps",
    "deg/s^2": "_degps2", "m": "_m", "m/s": "_mps", "m/s^2": "_mps2", "s": "_s", "1/s": "_per_s", "1/s^2": "_per_s2",
    "Hz": "_hz", "N": "_n", "N m": "_nm", "Pa": "_pa", "kg": "_kg", "kg m^2": "_kgm2", "W": "_w", "K": "_k",
}  # fmt: skip
"""Units that a signal may have, and how its columns end."""

MAX_NUMBERS = 256
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}")
_LABEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9_]{0,59}")
_EXAMPLE = '{"omega_hat": "1", "x2_tilde": ("rad/s", 3), "e": ("rad", ("phi", "theta", "psi"))}'
_RESERVED = ("v2", "v1", "d1_hat", "f_hat")


def declared(value: Any, file: str, taken: frozenset[str]) -> tuple[OwnSignal, ...]:
    """Return the signals that a map declares, in its order.

    Parameters
    ----------
    value
        As the user's code gave it.
    file
        Of the controller, for messages.
    taken
        Columns that every history of this aircraft has.

    Raises
    ------
    InputError
        If a name, a unit or a number of numbers is none, or a column has a name that is taken.
    """
    if not isinstance(value, dict):
        raise _refused(file, shown(value), f"a map of names to units, such as {_EXAMPLE}", "return step, {...}")
    signals: list[OwnSignal] = []
    columns = dict.fromkeys(taken, "a column of every flight")
    for name, given in dict.items(value):
        if type(name) is not str or _NAME.fullmatch(name) is None:
            expected = "a name of letters, digits and _, at most 60, beginning with a letter"
            raise _refused(file, f"the name {shown(name)}", expected, "rename the signal")
        if name in _RESERVED:
            raise _refused(file, f"the name {name}", "another name: this one is recorded already", "leave it out")
        signal = _signal(name, given, file)
        for column in signal.columns:
            if column in columns:
                found = f"{name}, whose column {column} is {columns[column]}"
                raise _refused(file, found, "a name that is not taken", f"rename it, for example own_{name}")
            columns[column] = f"one of {name}"
        signals.append(signal)
    if (n := sum(len(signal.columns) for signal in signals)) > MAX_NUMBERS:
        raise _refused(file, f"{n} numbers", f"at most {MAX_NUMBERS} numbers a sample", "declare fewer signals")
    return tuple(signals)


def sizes(signals: tuple[OwnSignal, ...]) -> Mapping[str, int]:
    """Return how many numbers a step returns of each signal; 0 of one that is a number and no list."""
    return {signal.name: len(signal.labels) for signal in signals}


def _signal(name: str, given: Any, file: str) -> OwnSignal:
    """Return one signal of its unit, or of its unit and how many numbers it has."""
    unit, count = given if type(given) in (tuple, list) and len(given) == 2 else (given, None)
    if type(unit) is not str or unit not in UNITS:
        near = difflib.get_close_matches(unit, UNITS, n=1) if type(unit) is str else []
        remedy = f"did you mean {near[0]}?" if near else '"1" is for what has none'
        raise _refused(file, f"{name}: {shown(given)}", f"a unit, one of {', '.join(UNITS)}", remedy)
    labels = tuple(str(i + 1) for i in range(min(count, MAX_NUMBERS + 1))) if type(count) is int else count
    if labels is None:
        return OwnSignal(name, unit, (_ending(name, unit),))
    good = type(labels) in (tuple, list) and 0 < len(labels) <= MAX_NUMBERS
    good = good and all(type(label) is str and _LABEL.fullmatch(label) for label in labels)
    if not good:
        expected = f"{name}: (unit, n), n from 1 to {MAX_NUMBERS}, or (unit, labels), texts of letters, digits and _"
        raise _refused(file, f"{name}: {shown(given)}", expected, f'for example {name}: ("{unit}", 3)')
    return OwnSignal(name, unit, tuple(_ending(f"{name}_{label}", unit) for label in labels), tuple(labels))


def _ending(name: str, unit: str) -> str:
    """Return the name of a column with its unit at the end, once."""
    return name if UNITS[unit] and name.endswith(UNITS[unit]) else name + UNITS[unit]


def _refused(file: str, found: str, expected: str, remedy: str) -> InputError:
    return InputError(f"{file}, what create returned as signals", found=found, expected=expected, remedy=remedy)
