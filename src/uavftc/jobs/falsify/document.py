"""What the searches of a campaign found, in the shape of `summary.json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from uavftc.analysis.verdict import SURVIVED
from uavftc.jobs.campaign.evaluate import ERROR
from uavftc.jobs.campaign.variants import Variant
from uavftc.jobs.falsify.search import Search
from uavftc.jobs.falsify.trace import DISTANCE, FLIGHT, STAGE, Row

SURE = 0.95
"""Confidence with which the share of failures is bounded where there was none."""


def has_failed(row: Row) -> bool:
    """Return whether a flight was flown and did not survive."""
    return row["outcome"] not in (SURVIVED, ERROR)


def best_of(rows: Sequence[Row], objective: str) -> Row | None:
    """Return the failure that was looked for, the first of equal ones; None where there is none."""
    failed = [row for row in rows if has_failed(row)]
    by = ("margin", DISTANCE) if objective == "margin" else (DISTANCE, "margin")
    return min(failed, key=lambda row: (row[by[0]], row[by[1]], row[FLIGHT]), default=None)


def lowest_of(rows: Sequence[Row]) -> Row | None:
    """Return the flight of the lowest margin, whatever came of it; None where none could be flown."""
    flown = [row for row in rows if row["margin"] is not None]
    return min(flown, key=lambda row: (row["margin"], row[FLIGHT]), default=None)


def entry_of(row: Row | None, search: Search) -> dict[str, Any] | None:
    """Return a flight of a trace as the summary shows it: values, how far each is from nominal, where on its range."""
    if row is None:
        return None
    values = search.flown[row[FLIGHT]]
    return {
        "flight": row[FLIGHT],
        "outcome": row["outcome"],
        "margin": row["margin"],
        "limiting": row["limiting"],
        "distance": row[DISTANCE],
        "values": dict(values),
        "parts": search.space.parts(values),
        "at": search.space.coordinates(values),
    }


def search_of(variant: Variant, search: Search, rows: Sequence[Row], objective: str) -> dict[str, Any]:
    """Return what one search found, and how much was searched.

    The share of the ranges that fails, as the campaign draws them, is below `uniform_share_below` with a confidence of
    95 %, by the start points alone, as if they were independent; None where one of them failed.
    """
    base = search.space.nominal_values()
    failures = [row for row in rows if has_failed(row)]
    spread = [row for row in rows if row[STAGE] in ("nominal", "start")]
    nominal = next((row for row in rows if row[STAGE] == "nominal"), None)
    broke_spread = any(map(has_failed, spread))
    return {
        "controller": variant.controller,
        "plant": variant.plant,
        "aircraft": variant.aircraft,
        "base": {"values": base, "at": search.space.coordinates(base)},
        "flights": len(rows),
        "failures": len(failures),
        "errors": sum(row["outcome"] == ERROR for row in rows),
        "start_points": len(spread),
        "runs": search.runs,
        "whole_space": search.space.finite is not None and len(rows) >= search.space.finite,
        "uniform_share_below": None if broke_spread or not spread else 1.0 - (1.0 - SURE) ** (1.0 / len(spread)),
        "first_failure": failures[0][FLIGHT] + 1 if failures else None,
        "nominal": entry_of(nominal, search),
        "lowest": entry_of(lowest_of(rows), search),
        "nearest": entry_of(best_of(rows, "nearest"), search),
        "found": entry_of(best_of(rows, objective), search),
        "file": None,
    }


def worst_of(searches: Sequence[Mapping[str, Any]], objective: str) -> Mapping[str, Any] | None:
    """Return the search whose failure is the lowest or the nearest; None where no search has one."""
    found = [one for one in searches if one["found"] is not None]
    by = "margin" if objective == "margin" else "distance"
    return min(found, key=lambda one: float(one["found"][by]), default=None)
