"""Printed and ours side by side: the rows of `reproduce.json`, the improvements, the score and the orderings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from uavftc.analysis.metrics import INTEGRALS
from uavftc.jobs.campaign.pool import Flown
from uavftc.jobs.paper import printed
from uavftc.jobs.paper.plan import L1

BEST = L1  # the controller that the paper proposes
TIE = 0.005  # under 0.5 % apart counts as tied

Row = dict[str, Any]
Flights = Mapping[tuple[str, str], Flown]
"""Flights of one plant, by (shipped scenario, controller)."""


def rows_of(plant: str, flights: Flights) -> list[Row]:
    """Return one row for each printed figure of Tables 2, 3 and 5: the entries of `reproduce.json`.

    Keys: table, scenario, controller, saturation, plant, axis, metric, printed, ours; numbers or None.
    """
    return [
        {
            "table": p.table,
            "scenario": p.scenario,
            "controller": p.controller,
            "saturation": p.saturation,
            "plant": plant,
            "axis": p.axis,
            "metric": p.metric,
            "printed": p.value,
            "ours": flights[p.shipped, p.controller].axes[p.axis][p.metric],
        }
        for p in printed.tables()
    ]


def ratio(row: Row) -> float | None:
    """Return ours / printed, or None where there is no such number."""
    if row["printed"] is None or row["ours"] is None or row["printed"] == 0.0:
        return None
    return float(row["ours"] / row["printed"])


def score(rows: Iterable[Row], table: int | None = None) -> float:
    """Return the root mean square of ln(ours / printed) over the NNDONDI-L1 integral metrics.

    `scored` of them over all tables; `table` takes one of 2, 3 or 5 alone.

    Raises
    ------
    ValueError
        If there is none: a flight was lost, or no row is left.
    """
    ratios = [
        ratio(row)
        for row in rows
        if row["controller"] == BEST and row["metric"] in INTEGRALS and (table is None or row["table"] == table)
    ]
    if not ratios or any(r is None or r <= 0.0 for r in ratios):
        raise ValueError("a figure is missing")
    return math.sqrt(sum(math.log(r) ** 2 for r in ratios if r is not None) / len(ratios))


def scored() -> int:
    """Return how many figures the score over all tables has: the printed integral metrics of NNDONDI-L1."""
    return sum(p.controller == BEST and p.metric in INTEGRALS for p in printed.tables())


class Improvement(NamedTuple):
    """One percentage of Table 4 or 6: printed, recomputed from the printed tables, and ours."""

    table: int
    scenario: str
    plant: str
    axis: str
    metric: str
    over: str
    printed: float
    """Percent, as printed."""
    recomputed: float
    """Percent, from the figures that Table 3 or 5 prints."""
    ours: float | None
    """Percent, from our flights."""


def improvements_of(plant: str, flights: Flights) -> list[Improvement]:
    """Return Tables 4 and 6 next to ours: 100 (1 - NNDONDI-L1 / other) for each integral metric."""
    values = {(p.shipped, p.controller, p.axis, p.metric): p.value for p in printed.tables()}
    result = []
    for p in printed.improvements():
        best, other = (values[p.scenario, controller, p.axis, p.metric] for controller in (BEST, p.over))
        assert best is not None  # the paper prints every integral metric
        assert other is not None
        ours = lower_by(flights, p.scenario, p.axis, p.metric, p.over)
        result.append(
            Improvement(
                p.table, p.scenario, plant, p.axis, p.metric, p.over, p.percent, 100.0 * (1.0 - best / other), ours
            )
        )
    return result


def lower_by(flights: Flights, scenario: str, axis: str, metric: str, over: str) -> float | None:
    """Return by how many percent NNDONDI-L1 is lower than another controller, or None if one has no figure."""
    best, other = (flights[scenario, controller].axes[axis][metric] for controller in (BEST, over))
    if best is None or not other:
        return None
    return 100.0 * (1.0 - best / other)


CONFIRMED, TIED, NOT_CONFIRMED = "confirmed", "tied", "not confirmed"


def verdict(percent: float | None) -> str:
    """Return what a percentage says of the claim that NNDONDI-L1 is lower."""
    if percent is None:
        return NOT_CONFIRMED
    if abs(percent) < 100.0 * TIE:
        return TIED
    return CONFIRMED if percent > 0.0 else NOT_CONFIRMED


class Claim(NamedTuple):
    """The answer to one ordering claim of Table 4 or 6."""

    improvement: Improvement
    answer: str
    """confirmed, tied, not confirmed, or `only with <condition>`."""
    conditions: dict[str, float | None]
    """Percent under each named condition that was flown."""


def claims_of(improvements: Iterable[Improvement], conditions: Mapping[str, tuple[str, Flights]]) -> list[Claim]:
    """Answer each ordering claim, in the paper's conditions first and then under named ones.

    Parameters
    ----------
    improvements
        From `improvements_of`.
    conditions
        For each named condition, the controller it concerns (the one NNDONDI-L1 is set against) and its flights.
    """
    claims = []
    for item in improvements:
        under = {
            name: lower_by(flights, item.scenario, item.axis, item.metric, item.over)
            for name, (over, flights) in conditions.items()
            if over == item.over
        }
        answer = verdict(item.ours)
        if answer != CONFIRMED:
            helped = [name for name, percent in under.items() if verdict(percent) == CONFIRMED]
            if helped:
                answer = f"{answer}; confirmed only with {' or '.join(helped)}"
        claims.append(Claim(item, answer, under))
    return claims
