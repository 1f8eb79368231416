"""The document of `uavftc sweep-report`: `summary.json` of the report, and what text, page and figures are made of."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import uavftc
from uavftc.analysis.metrics import METRICS
from uavftc.analysis.proportion import CONFIDENCE
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.jobs.campaign.evaluate import ERROR
from uavftc.jobs.campaign.scenarios import command
from uavftc.jobs.sweep_report import influence
from uavftc.jobs.sweep_report.compare import BOOTSTRAPPED, RESAMPLES, pairs, shares, spread
from uavftc.jobs.sweep_report.read import Flown

WORST = 10


def document_of(flown: Flown, on_axes: str | None = None) -> dict[str, Any]:
    """Return everything that the report says.

    Parameters
    ----------
    flown
        The flights.
    on_axes
        Two keys with a comma between them, for the map; None for the two most influential.

    Raises
    ------
    InputError
        If the two keys are none that vary.
    """
    campaign, names = flown.campaign, flown.names
    success, margin = flown.numbers("success"), flown.numbers("margin")
    constant, inputs, limit = _inputs(flown)
    chosen = _axes(on_axes, inputs, constant)
    seen = [influence.influence(inputs, margin[: len(limit), i], campaign.seed) for i in range(len(names))]
    keys = influence.order(seen, list(inputs))
    shown = sorted(keys, key="seed".__eq__)  # a seed has no more and less: it is on the map when all else is used up
    if chosen is None and len(shown) > 1:
        chosen = shown[0], shown[1]
    outcomes, limiting = _counted(flown, "outcome"), _broken(flown, margin)
    said = shares(success)
    variants = [
        {
            "name": name,
            **dict(zip(("controller", "plant", "aircraft"), flown.variants[i], strict=True)),
            **said[i],
            "outcomes": outcomes[i],
            "broken": limiting[i],
            "margin": spread(margin[:, i]),
        }
        for i, name in enumerate(names)
    ]
    worst = _worst(flown, margin)
    return {
        "campaign": campaign.name,
        "description": campaign.description,
        "base": campaign.base,
        "design": campaign.design,
        "seed": campaign.seed,
        "finished": flown.finished,
        "cases": len(flown.cases),
        "cases_of_campaign": campaign.count,
        "flights": int(np.prod(flown.shape)),
        "success_is": campaign.success or "survived",
        "confidence": CONFIDENCE,
        "variants": variants,
        "pairs": pairs(flown.variants, names, success, margin, campaign.seed),
        "metrics": _metrics(flown),
        "vary": _vary(flown),
        "constant": constant,
        "sensitivity": {
            "method": influence.METHOD if influence.has_salib() else None,
            "cases": len(limit),
            "order": keys,
            "variants": dict(zip(names, seen, strict=True)),
        },
        "map": list(chosen) if chosen else None,
        "worst": [dict(one) for one in _worst_cases(worst)],
        "worst_of": dict(zip(names, worst, strict=True)),
        "notes": _notes(flown, variants, inputs, constant, seen),
        "provenance": {"uavftc": uavftc.__version__, **_origin(flown.document)},
    }


def _origin(document: Mapping[str, Any]) -> dict[str, Any]:
    versions = {name: version for name, version in document.get("versions", {}).items() if name != "uavftc"}
    return {**versions, "campaign_sha256": document.get("campaign_sha256")}


def _inputs(flown: Flown) -> tuple[list[str], dict[str, tuple[np.ndarray, list[str] | None]], range]:
    """Return the keys that do not vary, those that do with what they took in the first cases, and these cases."""
    constant, found = [], {}
    count = min(len(flown.cases), influence.CASES)
    for key in flown.campaign.vary:
        values, words = flown.input(key)
        if np.ptp(values) == 0.0:
            constant.append(key)
        else:
            found[key] = values[:count].copy(), words
    return constant, found, range(count)


def _axes(asked: str | None, inputs: Mapping[str, Any], constant: Sequence[str]) -> tuple[str, str] | None:
    if asked is None:
        return None
    keys = [key.strip() for key in asked.split(",")]
    where = f"--map {asked}"
    expected = f"two of {', '.join(inputs) or 'the varied keys, of which there are none'}, with a comma between them"
    if len(keys) != 2 or keys[0] == keys[1]:
        raise InputError(where, found=f"{len(set(keys))} key(s)", expected=expected, remedy="name two")
    for key in keys:
        if key not in inputs:
            near = difflib.get_close_matches(key, list(inputs), n=1)
            found = f"{key}, which has one value in all cases" if key in constant else f"{key}, which does not vary"
            remedy = f"did you mean {near[0]}?" if near else "choose from these"
            raise InputError(where, found=found, expected=expected, remedy=remedy)
    return keys[0], keys[1]


def _counted(flown: Flown, column: str) -> list[dict[str, int]]:
    """Return of each variant how often each text stands in a column, the most frequent first."""
    places, words = flown.texts(column)
    counted = [Counter(places[:, i].tolist()) for i in range(places.shape[1])]
    return [{words[k]: n for k, n in counts.most_common() if k >= 0} for counts in counted]


def _broken(flown: Flown, margin: np.ndarray) -> list[dict[str, int]]:
    """Return of each variant which requirement was the limiting one of flights with a margin below 0, and how often."""
    places, words = flown.texts("limiting")
    found = []
    for i in range(margin.shape[1]):
        counts = Counter(places[margin[:, i] < 0.0, i].tolist())
        found.append({words[k]: n for k, n in counts.most_common() if k >= 0})
    return found


def _metrics(flown: Flown) -> list[dict[str, Any]]:
    """Return of each metric and axis how it is spread over the flights of each variant."""
    found = []
    for metric in METRICS:
        for axis in AXES:
            values = flown.numbers(f"{axis}_{metric.name}")
            spreads = {name: spread(values[:, i]) for i, name in enumerate(flown.names)}
            if any(one["flights"] for one in spreads.values()):
                one = {"axis": axis, "name": metric.name, "label": metric.label, "unit": metric.unit}
                found.append({**one, "variants": spreads})
    return found


def _vary(flown: Flown) -> list[dict[str, Any]]:
    return [{"key": key, "kind": vary.kind, "given": list(vary.given)} for key, vary in flown.campaign.vary.items()]


def _worst(flown: Flown, margin: np.ndarray) -> list[list[dict[str, Any]]]:
    """Return the flights of each variant with the smallest margins, each with the command that flies it again."""
    rows = [_smallest(column) for column in margin.T]
    values: list[list[dict[str, Any]]] = [[{} for _ in of] for of in rows]
    for key in flown.campaign.vary:
        taken, words = flown.input(key)
        for of, some in zip(rows, values, strict=True):
            for row, one in zip(of, some, strict=True):
                one[key] = flown.value(key, taken[row], words)
    said = {name: flown.texts(name) for name in ("outcome", "limiting", "reason")}
    found = []
    for place, (of, some) in enumerate(zip(rows, values, strict=True)):
        scenario = flown.scenario(place)
        worst = []
        for row, taken_there in zip(of, some, strict=True):
            again = command(scenario, taken_there) if scenario is not None else None
            one = {"case": int(flown.cases[row]), "variant": flown.names[place], "margin": float(margin[row, place])}
            for name, (places, words) in said.items():
                one[name] = words[places[row, place]] if places[row, place] >= 0 else None
            worst.append({**one, "values": taken_there, "command": again, "command_with_values": again})
        found.append(worst)
    return found


def _smallest(margin: np.ndarray) -> np.ndarray:
    """Return where the smallest margins are, the smallest first, of equal ones the first case first."""
    known = np.where(np.isfinite(margin), margin, np.inf)
    count = min(WORST, int(np.isfinite(margin).sum()))
    if not count:
        return np.zeros(0, dtype=int)
    rows = np.flatnonzero(known <= np.partition(known, count - 1)[count - 1])
    return rows[np.argsort(known[rows], kind="stable")][:count]


def _worst_cases(worst: Sequence[Sequence[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the cases with the smallest margins of all, each once, by the variant that it is worst for."""
    of: dict[int, dict[str, Any]] = {}
    for one in sorted((one for some in worst for one in some), key=lambda one: (one["margin"], one["case"])):
        of.setdefault(one["case"], one)
    return list(of.values())[:WORST]


def _notes(
    flown: Flown,
    variants: Sequence[Mapping[str, Any]],
    inputs: Mapping[str, Any],
    constant: Sequence[str],
    seen: Sequence[Any],
) -> list[str]:
    """Return what a reader must know of these figures, a line each."""
    found = []
    many, of = len(flown.cases), flown.campaign.count
    if not flown.finished:
        found.append(f"the campaign is not finished: {many} of {of} cases have ended whole, and only these count")
    elif many < of:
        found.append(f"the campaign ended after {many} of {of} cases (--until-width)")
    if flown.torn:
        found.append(f"{flown.torn} torn part(s) of the table are left out")
    for one in variants:
        if one["errors"]:
            some = "all" if one["errors"] == many else str(one["errors"])
            found.append(f"{one['name']}: {some} of {many} flights could not be flown ({ERROR}), and count neither way")
    if any(one["flights"] and one["successes"] == one["flights"] for one in variants):
        found.append("where every flight succeeds, the interval says how rare a failure may still be")
    if len(variants) == 1:
        found.append("one controller: there is nothing to compare")
    if constant:
        found.append(f"the same in all cases, and so without influence: {', '.join(constant)}")
    if len(inputs) == 1:
        found.append("one key varies: there is no map, which takes two")
    if not inputs:
        found.append("no key varies: there is neither sensitivity nor map")
    elif not any(seen):
        few = "the margins are all the same" if many >= influence.FEWEST else f"fewer than {influence.FEWEST} flights"
        found.append(f"no sensitivity: {few}")
    if inputs and not influence.has_salib():
        found.append(influence.NO_SALIB)
    if sum(vary.kind == "list" for vary in flown.campaign.vary.values()) > 1:
        found.append("lists go in step: what one of them does cannot be told from what the others do")
    if many > influence.CASES and inputs:
        found.append(f"sensitivity is that of the first {influence.CASES} cases")
    if many > BOOTSTRAPPED and len(variants) > 1:
        found.append(f"bootstrap intervals ({RESAMPLES} resamples) are those of the first {BOOTSTRAPPED} cases")
    return found
