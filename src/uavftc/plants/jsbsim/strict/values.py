"""What may stand as text in an element or as the value of an attribute: numbers, properties, tests, rows of tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

Lines = Sequence[tuple[int, str]]
"""Lines that are not blank, stripped, with their numbers."""


class Problem(NamedTuple):
    """Something wrong with a value."""

    line: int
    found: str
    expected: str


# as JSBSim reads them; it refuses hexadecimal, nan and inf
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
_NAME = r"[A-Za-z_][A-Za-z0-9_.-]*(\[[0-9]+\])?"
_PROPERTY = re.compile(rf"-?/?{_NAME}(/{_NAME})*")
_NO_NUMBER = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_COMPARISONS = frozenset("!= < <= == > >= EQ GE GT LE LT NE eq ge gt le lt ne".split())  # noqa: SIM905
_AXIS = re.compile(r"row|column|table|axis[1-9]")

_UNITS = (
    "M FT IN KM CM M2 FT2 CM2 IN2 FT3 IN3 CC M3 LTR GAL M/S M/SEC FT/S FT/SEC KTS KM/SEC RAD DEG RAD/SEC DEG/SEC "
    "KG LBS SLUG KG*M2 SLUG*FT2 N N/M LBS/FT N/M/SEC LBS/FT/SEC N/M2/SEC2 LBS/FT2/SEC2 N*M FT*LBS WATTS HP "
    "PA N/M2 LBS/FT2 PSF PSI ATM INHG KG/L LBS/GAL LBS/SEC KG/SEC KG/MIN LBS/MIN N/SEC LBS/HP*HR KG/KW*HR "
    "M4*SEC/KG FT4*SEC/SLUG FT3/SEC2 M3/SEC2 VOLTS OHMS AMPERES"
)
UNITS = frozenset(_UNITS.split())
"""Units that JSBSim converts; whether to what it needs, it checks itself."""


def _is_number(text: str) -> bool:
    return _NUMBER.fullmatch(text) is not None


def is_property(text: str) -> bool:
    """Return whether a text may be the name of a property, with its sign."""
    return _PROPERTY.fullmatch(text) is not None and _NO_NUMBER.fullmatch(text) is None


def _single(expected: str, fits: Callable[[str], bool]) -> Callable[[int, Lines], list[Problem]]:
    def check(line: int, lines: Lines) -> list[Problem]:
        if not lines:
            return [Problem(line, "nothing", expected)]
        if len(lines) > 1:
            return [Problem(lines[1][0], f"a second line, '{lines[1][1]}'", expected)]
        if not fits(lines[0][1]):
            return [Problem(lines[0][0], f"'{lines[0][1]}'", expected)]
        return []

    return check


def _conditions(line: int, lines: Lines) -> list[Problem]:
    expected = "a property, a comparison and a number or property, such as ap/at-on GE 0.5, one condition a line"
    found = []
    for number, text in lines:
        words = text.split()
        fits = len(words) == 3 and is_property(words[0]) and words[1] in _COMPARISONS
        if not fits or not (_is_number(words[2]) or is_property(words[2])):
            found.append(Problem(number, f"'{text}'", expected))
    return found


def rows(line: int, lines: Lines, dimensions: int | None) -> list[Problem]:
    """Return what is wrong with the numbers of a table of so many independent variables, 1 or 2, or None: either."""
    if not lines:
        return [Problem(line, "nothing", "rows of numbers")]
    table: list[list[str]] = [text.split() for _, text in lines]
    for (number, _), row in zip(lines, table, strict=True):
        for word in row:
            if not _is_number(word):
                return [Problem(number, f"'{word}' in a table", "numbers only, with a point for the decimals")]
    return _shape(lines, table, dimensions) or _monotone(lines, table)


def _shape(lines: Lines, table: list[list[str]], dimensions: int | None) -> list[Problem]:
    rest = Counter(len(row) for row in table[1:])
    common = rest.most_common(1)[0][0] if rest else len(table[0])
    two = dimensions == 2 or (dimensions is None and common != 2)
    if not two:
        short = [i for i, row in enumerate(table) if len(row) != 2]
        expected = "two numbers in each row: the independent variable and the value"
    else:
        columns = common - 1
        short = [i for i, row in enumerate(table) if len(row) != (columns if i == 0 else columns + 1)]
        expected = f"{columns} breakpoints in the first row and {columns + 1} numbers in each of the others"
        if len(table) < 2:
            short, expected = [0], "a first row of breakpoints, and rows below it"
    count = len(table[short[0]]) if short else 0
    plural = "" if count == 1 else "s"
    return [Problem(lines[i][0], f"{count} number{plural}, '{lines[i][1]}'", expected) for i in short[:1]]


def _monotone(lines: Lines, table: list[list[str]]) -> list[Problem]:
    two = len(table) > 1 and len(table[0]) != len(table[1])
    first = [float(row[0]) for row in (table[1:] if two else table)]
    numbers = [line for line, _ in (lines[1:] if two else lines)]
    for k in range(1, len(first)):
        if not first[k] > first[k - 1]:
            return [
                Problem(numbers[k], f"{first[k]:g} after {first[k - 1]:g}", "breakpoints that rise from row to row")
            ]
    columns = [float(word) for word in table[0]] if two else []
    if any(not b > a for a, b in pairwise(columns)):
        return [Problem(lines[0][0], f"breakpoints {lines[0][1]}", "breakpoints that rise along the row")]
    return []


_PROPERTY_TEXT = "the name of a property, such as fcs/elevator-pos-rad"

FORMS: dict[str, Callable[[int, Lines], list[Problem]]] = {
    "number": _single("one number", _is_number),
    "property": _single(_PROPERTY_TEXT, is_property),
    "argument": _single(_PROPERTY_TEXT, lambda text: text == "#" or is_property(text.replace("[#]", "[0]"))),
    "value": _single("one number, or the name of a property", lambda text: _is_number(text) or is_property(text)),
    "any": _single("a word", lambda text: True),
    "unit": _single("a unit that JSBSim knows", lambda text: text in UNITS),
    "axis": _single("row, column, table or axis1 to axis9", lambda text: _AXIS.fullmatch(text) is not None),
    "seed": _single("a whole number, or time_now", lambda text: text == "time_now" or text.isdecimal()),
    "conditions": _conditions,
    "maybe-number": lambda line, lines: FORMS["number"](line, lines) if lines else [],
    "prose": lambda _line, _lines: [],
}


def words(line: int, lines: Lines, allowed: Iterable[str]) -> list[Problem]:
    """Return what is wrong with a text that must be one of a few."""
    names = list(dict.fromkeys(allowed))
    return _single(f"one of: {', '.join(names)}", lambda text: text in names)(line, lines)
