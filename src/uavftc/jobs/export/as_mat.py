"""A flight as a MATLAB file: one struct, `flight`, with columns, units, summary and scenario.

    flight.history.phi_rad      (N + 1) x 1 double, a column of the history; NaN where there is none
    flight.units.phi_rad        'rad', after the column's suffix; '1' where it has none
    flight.names.phi_rad        the column's name in history.parquet, from which a field may have to differ
    flight.summary              summary.json: objects are structs, lists of numbers rows, other lists cells, null []
    flight.scenario             the text of the scenario as flown

A field is a name of MATLAB: a letter, then letters, digits and _, at most 63, no keyword.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.config.values import is_number
from uavftc.control.custom.own_signals import UNITS

LONGEST = 63
"""namelengthmax of MATLAB; of a field too, where `long_field_names` is asked for."""
KEYWORDS = frozenset(
    (
        "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if",
        "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while",
    )
)  # fmt: skip
_EXACT = 2**53  # whole numbers up to here are doubles


def write_mat(path: Path, columns: Mapping[str, np.ndarray], summary: Mapping[str, Any], scenario: str) -> None:
    """Write the flight of these columns, name to shape (n,), with its part of a summary and its scenario.

    Raises
    ------
    OSError
        If there is no room for it.
    """
    from scipy.io import savemat  # noqa: PLC0415 - 0.2 s

    fields = field_names(columns)
    flight = {
        "history": {fields[name]: np.asarray(values, dtype=float)[:, None] for name, values in columns.items()},
        "units": {fields[name]: unit_of_column(name) for name in columns},
        "names": {fields[name]: name for name in columns},
        "summary": _value(summary),
        "scenario": scenario,
    }
    with path.open("wb") as stream:
        savemat(stream, {"flight": flight}, long_field_names=True, do_compression=True, oned_as="row")


def field_names(names: Iterable[str]) -> dict[str, str]:
    """Return the field of each name, no two the same; a name that MATLAB takes as it is stays."""
    names = list(names)
    found = {name: name for name in names if _is_field(name)}
    taken = set(found.values())
    for name in names:
        if name in found:
            continue
        base = re.sub(r"[^A-Za-z0-9_]", "_", name)
        base = base if base[:1].isascii() and base[:1].isalpha() else f"x{base}"
        field, count = base[:LONGEST], 1
        while field in taken or not _is_field(field):
            count += 1
            field = f"{base[: LONGEST - len(str(count)) - 1]}_{count}"
        found[name] = field
        taken.add(field)
    return {name: found[name] for name in names}


def unit_of_column(name: str) -> str:
    """Return the unit after a column's suffix, `1` where it has none; that of phi_rad is rad, of q_radps rad/s."""
    ending = max((end for end in UNITS.values() if end and name.endswith(end)), key=len, default="")
    return next(unit for unit, end in UNITS.items() if end == ending)


def _is_field(name: str) -> bool:
    return re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,62}", name) is not None and name not in KEYWORDS


def _value(value: Any) -> Any:
    """Return a value of a summary as `savemat` takes it."""
    if isinstance(value, Mapping):
        fields = field_names(value)
        return {fields[name]: _value(item) for name, item in value.items()}
    if value is None:
        return np.zeros((0, 0))
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int):
        return float(value) if abs(value) <= _EXACT else np.int64(value)
    if isinstance(value, list | tuple):
        if value and all(map(is_number, value)):
            return np.array(value, dtype=float)[None, :]
        cells = np.empty((1, len(value)), dtype=object)
        cells[0, :] = [_value(item) for item in value]
        return cells
    return float(value)
