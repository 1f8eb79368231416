"""The page of a campaign: how often each controller succeeds, its margins, two inputs by margin, and the worst flights.

What it shows is made of the table of flights alone, so that an analysis of a campaign can hand it more (`sections`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.analysis.proportion import wilson
from uavftc.report import palette
from uavftc.report.page.html import listed, render
from uavftc.report.page.looks import on_page
from uavftc.report.page.packed import packed
from uavftc.report.page.tables import Table, facts, typeset
from uavftc.report.verdict import margin_text

Again = Callable[[Mapping[str, Any]], str]
"""Given a row of the table, the command that flies it again; empty where there is none."""
Columns = Mapping[str, Sequence[Any]]
"""Of `flights.parquet`, by name, None where there is no value."""
MOST_POINTS = 4_000
"""Flights drawn one by one; of more, those of the smallest margins and some of the others by chance."""
_WORST_SHARE = 0.25
_STEPS = 400  # of a distribution
_SHOWN = 12  # flights in the table of the worst
_OUTCOMES = ("survived", "degraded", "lost", "numerical", "error")


class Section(NamedTuple):
    """A table of another analysis of the same flights, under a heading of its own."""

    title: str
    table: Table
    note: str = ""


def campaign_page(
    flights: Columns,
    document: Mapping[str, Any],
    campaign: Mapping[str, Any],
    *,
    again: Again | None = None,
    sections: Sequence[Section] = (),
    files: Sequence[str] = (),
) -> str:
    """Return the page of a campaign as HTML.

    Parameters
    ----------
    flights
        The table of flights.
    document
        Of `summary.json`.
    campaign
        Of `campaign.json`.
    again
        What returns the command that flies a row of the table again.
    sections
        More tables, behind those of the page.
    files
        Of the result folder, to link to.
    """
    said = campaign["campaign"]
    inputs = [one["key"] for one in said["vary"] if one["key"] in flights]
    names = _variants(flights)
    order = list(dict.fromkeys(names))
    looked = palette.controllers(order) if len(order) > 1 else palette.in_order(order)
    margins = np.array([np.nan if m is None else float(m) for m in flights["margin"]])
    place = np.array([order.index(name) for name in names])
    kept = _drawn(margins)
    data = {
        "kind": "campaign",
        "looks": {f"variant{i}": on_page(looked[name] | {"linewidth": 2.2}) for i, name in enumerate(order)},
        "charts": [_distribution(margins, place, order)],
        "scatter": {
            "variants": order,
            "variant": packed(place[kept].astype("<u2")),
            "case": packed(np.array(flights["case"])[kept].astype("<u4")),
            "margin": packed(margins[kept].astype("<f4")),
            "outcomes": list(_OUTCOMES),
            "outcome": packed(np.array([_OUTCOMES.index(flights["outcome"][i]) for i in kept.tolist()]).astype("<u2")),
            "inputs": [_input(key, [flights[key][i] for i in kept.tolist()]) for key in inputs],
        },
    }
    return render(
        "campaign.html",
        data,
        title=f"{document['campaign']}: {document['cases']} cases, {document['flights']} flights",
        description=said.get("description", ""),
        success=success_table(flights, place, order, margins),
        asked=_asked(said.get("success")),
        limits=_limits(flights, place, order),
        worst=worst_table(flights, names, margins, inputs, again),
        sections=sections,
        drawn=len(kept),
        flights=len(margins),
        has_inputs=bool(inputs),
        facts=facts({**document["provenance"], "base": said.get("base", ""), "seed": said.get("seed", "")}),
        files=listed(files),
    )


def _variants(flights: Columns) -> list[str]:
    """Return the controller of each flight, with its plant and aircraft where the campaign has several."""
    parts = [flights[name] for name in ("controller", "plant", "aircraft") if name in flights]
    return [", ".join(str(part) for part in one) for one in zip(*parts, strict=True)]


def _drawn(margins: np.ndarray) -> np.ndarray:
    """Return the places of the flights that are drawn one by one, in their order."""
    n = len(margins)
    if n <= MOST_POINTS:
        return np.arange(n)
    order = np.argsort(np.where(np.isnan(margins), -np.inf, margins), kind="stable")
    worst, rest = np.split(order, [int(_WORST_SHARE * MOST_POINTS)])
    some = np.random.default_rng(0).choice(rest, MOST_POINTS - len(worst), replace=False)
    return np.sort(np.concatenate([worst, some]))


def _input(key: str, values: Sequence[Any]) -> dict[str, Any]:
    """Return an input as the page has it: numbers, or places in a list of texts."""
    if all(value is None or (isinstance(value, (int, float)) and not isinstance(value, bool)) for value in values):
        numbers = np.array([np.nan if value is None else float(value) for value in values])
        return {"key": key, "y": packed(numbers.astype("<f4")), "texts": None}
    texts = list(dict.fromkeys(map(str, values)))
    return {"key": key, "y": packed(np.array([texts.index(str(v)) for v in values]).astype("<f4")), "texts": texts}


def _distribution(margins: np.ndarray, place: np.ndarray, order: Sequence[str]) -> dict[str, Any]:
    """Return, of each variant, which share of its flights has at most a margin."""
    series = []
    for i, name in enumerate(order):
        found = np.sort(margins[(place == i) & np.isfinite(margins)])
        if not len(found):
            continue
        rank = np.unique(np.round(np.linspace(0, len(found) - 1, min(len(found), _STEPS))).astype(int))
        series.append(
            {
                "name": name,
                "look": f"variant{i}",
                "x": found[rank].tolist(),
                "y": ((rank + 1) / int(np.sum(place == i))).tolist(),
                "steps": True,
            }
        )
    return {
        "key": "margins",
        "series": series,
        "x": {"title": "margin", "range": [min(-1.05, *(s["x"][0] - 0.05 for s in series)), 1.05] if series else None},
        "y": {"title": "share of flights at or below", "range": [0.0, 1.02]},
        "upright": 0.0,
        "height": 380,
    }


def success_table(flights: Columns, place: np.ndarray, order: Sequence[str], margins: np.ndarray) -> Table:
    """Return how often each variant succeeds, with Wilson's interval, its outcomes and its margins."""
    present = [name for name in _OUTCOMES if name in flights["outcome"]]
    header = ["controller", "flights", "success", "share", "95 % interval", *present, "least margin", "median"]
    rows = []
    for i, name in enumerate(order):
        mine = np.flatnonzero(place == i).tolist()
        succeeded = sum(bool(flights["success"][k]) for k in mine)
        low, high = wilson(succeeded, len(mine))
        found = margins[mine][np.isfinite(margins[mine])]
        ended = Counter(flights["outcome"][k] for k in mine)
        ends = [_margin(float(found.min())), _margin(float(np.median(found)))] if len(found) else ["–", "–"]
        share = [f"{succeeded / len(mine):.3f}", f"{float(low):.3f} to {float(high):.3f}"]
        rows.append([name, str(len(mine)), str(succeeded), *share, *(str(ended[one]) for one in present), *ends])
    return Table(header, rows, "Success of each controller, with Wilson's interval")


def _margin(value: float) -> str:
    return typeset(margin_text(value))


def _asked(success: Mapping[str, float] | None) -> str:
    if not success:
        return "A flight succeeds where it survives."
    named = ", ".join(f"{name} at most {limit:g}" for name, limit in success.items())
    return f"A flight succeeds where it reaches its end with {named}, on every axis that it controls."


def _limits(flights: Columns, place: np.ndarray, order: Sequence[str]) -> Table:
    """Return how often each requirement was the one that limits, of each variant."""
    kinds = [name for name, _ in Counter(one for one in flights["limiting"] if one).most_common()]
    rows = []
    for i, name in enumerate(order):
        mine = Counter(flights["limiting"][k] for k in np.flatnonzero(place == i).tolist())
        rows.append([name, *(str(mine[kind]) for kind in kinds)])
    return Table(["controller", *kinds], rows, "Flights that each requirement limits")


def worst_table(
    flights: Columns, names: Sequence[str], margins: np.ndarray, inputs: Sequence[str], again: Again | None
) -> list[dict[str, str]]:
    """Return the flights of the smallest margins, first those that could not be flown: texts by name.

    `command` flies one again; empty where nothing is known of that.
    """
    order = np.argsort(np.where(np.isnan(margins), -np.inf, margins), kind="stable")[:_SHOWN]
    found = []
    for i in order.tolist():
        found.append(
            {
                "case": str(flights["case"][i]),
                "variant": names[i],
                "outcome": str(flights["outcome"][i]),
                "margin": "–" if np.isnan(margins[i]) else _margin(float(margins[i])),
                "limiting": str(flights["limiting"][i] or "–"),
                "reason": str(flights["reason"][i] or ""),
                "inputs": ", ".join(_short(key, flights[key][i]) for key in inputs),
                "command": again({name: flights[name][i] for name in flights}) if again else "",
            }
        )
    return found


def _short(key: str, value: Any) -> str:
    return f"{key} = {value:.4g}" if isinstance(value, float) else f"{key} = {value}"
