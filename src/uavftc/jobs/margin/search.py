"""Where a verdict changes along one quantity: scanned first, then bracketed by bisection."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

POINTS = 9
"""Of a scan."""
CLOSE = 0.01
"""Width of the bracket over its outer end, or over the range where that end is nearer to 0 than `CLOSE` of it."""
MOST = 40
"""Steps of a bisection; ten halve a range to a thousandth."""


class Judged(NamedTuple):
    """What came of one flight."""

    margin: float
    survived: bool
    criterion: str
    """What was limiting."""


@dataclass
class Limit:
    """Where the verdict changes."""

    held: float | None
    """The last value at which the flight survived, before `broke`; None where it did not at the first."""
    broke: float | None
    """The first value at which it did not; None where it survived them all."""
    criterion: str | None
    """What was broken at `broke`."""
    monotone: bool = True
    """Whether no value beyond `broke` that was looked at survived."""
    flown: dict[float, Judged] = field(default_factory=dict)
    """Every flight, by the value."""


def scan(first: float, last: float, *, steps: int = POINTS) -> list[float]:
    """Return the values of a scan from `first` to `last`: by equal factors where both are above 0 and far apart."""
    if min(first, last) > 0.0 and max(first, last) / min(first, last) >= 10.0:
        ratio = (last / first) ** (1.0 / (steps - 1))
        return [first, *(first * ratio**i for i in range(1, steps - 1)), last]
    return [first, *(first + (last - first) * i / (steps - 1) for i in range(1, steps - 1)), last]


def find(judge: Callable[[float], Judged], values: Sequence[float]) -> Limit:
    """Return where the verdict first changes from survived.

    Parameters
    ----------
    judge
        Flies one value.
    values
        Of the scan, rising or falling, from where it should survive on.
    """
    flown: dict[float, Judged] = {}

    def at(value: float) -> Judged:
        if value not in flown:
            flown[value] = judge(value)
        return flown[value]

    survived = [at(value).survived for value in values]
    if all(survived):
        return Limit(values[-1], None, None, True, flown)
    k = survived.index(False)
    monotone = not any(survived[k:])
    if k == 0:
        return Limit(None, values[0], at(values[0]).criterion, monotone, flown)
    held, broke = values[k - 1], values[k]
    by_factors = min(values[k - 1], values[k]) > 0.0 and scan(values[0], values[-1], steps=3)[1] != 0.5 * (
        values[0] + values[-1]
    )
    span = abs(values[-1] - values[0])
    for _ in range(MOST):
        size = max(abs(held), abs(broke))
        if abs(broke - held) <= CLOSE * max(size, 0.1 * CLOSE * span):
            break
        middle = math.sqrt(held * broke) if by_factors else 0.5 * (held + broke)
        if at(middle).survived:
            held = middle
        else:
            broke = middle
    return Limit(held, broke, at(broke).criterion, monotone, flown)
