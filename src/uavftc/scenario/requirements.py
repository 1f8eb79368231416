"""Requirements: what a flight must hold to, and by how much it did ([requirements.md](requirements.md)).

Left out, the default set holds; `requirements: []` is none.
"""

from __future__ import annotations

import math
import re
from typing import Annotated, Any

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from uavftc.analysis.verdict import FLOWN
from uavftc.config.formula import Formula
from uavftc.config.values import Model, NonNegative, Positive, Problem, refusal

AFTER = re.compile(r"(faults|damage|disturbances)\[([0-9]{1,6})\]\.(start|end)")

Scenario = Any  # of `schema.py`, which imports this file


class Requirement(Model):
    """One requirement: a formula over the signals of the flight, and when it must hold."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """what the verdict calls it"""
    always: Formula | None = None
    """formula that must hold at every sample from `from_s` to `to_s`"""
    eventually: Formula | None = None
    """or formula that must hold at one of these samples at least"""
    from_s: NonNegative = 0.0
    """first moment that counts"""
    to_s: NonNegative | None = None
    """last moment that counts, or at which a hold may begin; `null` is the end of the flight"""
    after: str | None = None
    """count `from_s` and `to_s` from the start or the end of an entry, such as `faults[0].start`, `damage[0].end`"""
    hold_s: NonNegative | None = None
    """with `eventually`: how long it must hold on"""
    window_s: Positive | None = None
    """how far travel and saturated share look back; 2 where it is left out"""
    scale: Positive | None = None
    """what a margin of 1 is, in the unit of the formula; `null` is the size of each limit, and must be given where a
    limit is 0 or is itself a signal"""

    @property
    def formula(self) -> Formula:
        """Return the formula."""
        formula = self.always or self.eventually
        assert formula is not None
        return formula

    @field_validator("name")
    @classmethod
    def _not_ours(cls, name: str) -> str:
        if name == FLOWN:
            raise PydanticCustomError("name", "another name: every flight is asked to be flown to its end by this one")
        return name

    @model_validator(mode="after")
    def _whole(self) -> Requirement:
        found = []
        given = [key for key in ("always", "eventually") if getattr(self, key) is not None]
        if len(given) != 1:
            said = " and ".join(given) or "neither always nor eventually"
            found.append(Problem((), said, "one of always and eventually", "write one formula for each requirement"))
        elif self.formula.unscaled is not None and self.scale is None:
            what = f"the comparison {self.formula.unscaled}, whose limit is 0 or changes"
            expected = "a scale: what difference is a margin of 1"
            found.append(Problem((given[0],), what, expected, "add scale: with a number in the unit of the formula"))
        if self.hold_s is not None and self.eventually is None:
            expected = "hold_s with eventually; always holds from from_s to to_s as it is"
            found.append(Problem(("hold_s",), "hold_s without eventually", expected, "remove it"))
        if self.to_s is not None and self.to_s < self.from_s:
            expected = f"at least from_s, {self.from_s:g} s"
            found.append(Problem(("to_s",), f"{self.to_s:g} s", expected, "move to_s, or leave it out for the rest"))
        if self.after is not None and AFTER.fullmatch(self.after) is None:
            expected = "the start or end of an entry, such as faults[0].start"
            found.append(Problem(("after",), f"'{self.after[:60]}'", expected, "name faults, damage or disturbances"))
        if found:
            raise refusal(found)
        return self


def problems(scenario: Scenario) -> list[Problem]:
    """Return what is wrong with the times and names of the requirements of a scenario."""
    found: list[Problem] = []
    seen: dict[str, int] = {}
    for i, one in enumerate(scenario.requirements or ()):
        key = ("requirements", i)
        if one.name in seen:
            expected = f"another name: requirements[{seen[one.name]}] has this one"
            found.append(Problem((*key, "name"), f"'{one.name}'", expected, "rename one of them"))
        seen.setdefault(one.name, i)
        if (wrong := _reference(scenario, one)) is not None:
            found.append(Problem((*key, "after"), *wrong))
        elif (span := steps(scenario, one))[1] is not None and span[1] < span[0]:
            expected = "at least one sample of the flight between them"
            found.append(Problem((*key, "to_s"), "no sample from from_s to to_s", expected, "move one of them"))
    return found


def steps(scenario: Scenario, one: Requirement) -> tuple[int, int | None]:
    """Return the first and the last row that count, None for the end of the flight."""
    rate, since = scenario.controller.rate_hz, 0.0
    if one.after is not None:
        entry, edge = _entry(scenario, one.after)
        since = entry.start_s if edge == "start" else entry.end_s
    first = math.ceil((since + one.from_s) * rate - 1e-6)
    return first, None if one.to_s is None else math.floor((since + one.to_s) * rate + 1e-6)


def too_late(scenario: Scenario, one: Requirement) -> bool:
    """Return whether the flight ends before it can be judged."""
    return steps(scenario, one)[0] + hold(scenario, one) > int(scenario.steps)


def hold(scenario: Scenario, one: Requirement) -> int:
    """Return how many steps it must hold on."""
    return math.ceil((one.hold_s or 0.0) * scenario.controller.rate_hz - 1e-6)


def _entry(scenario: Scenario, after: str) -> tuple[Any, str]:
    match = AFTER.fullmatch(after)
    assert match is not None
    return getattr(scenario, match[1])[int(match[2])], match[3]


def _reference(scenario: Scenario, one: Requirement) -> tuple[str, str, str] | None:
    """Return found, expected and fix where the entry is missing or has no such moment."""
    if one.after is None:
        return None
    match = AFTER.fullmatch(one.after)
    assert match is not None
    have = len(getattr(scenario, match[1]))
    if int(match[2]) >= have:
        expected = f"one of the {have} entries of {match[1]}, counted from 0" if have else f"an entry of {match[1]}"
        return f"'{one.after}'", expected, "name one that is there, or leave after out"
    entry, edge = _entry(scenario, one.after)
    if edge == "end" and entry.end_s is None:
        return f"'{one.after}', which lasts to the end of the flight", "an entry with an end_s", "give it an end_s"
    return None
