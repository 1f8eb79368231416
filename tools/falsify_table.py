"""Falsification next to random search and Sobol points: flights to the first failure, and the nearest one.

    python tools/falsify_table.py [--seeds 10] [--budget 500] [--campaigns falsify-paper,...] [--file FILE.csv]

Flies in this process, on the analytic plant, one after the other (15,000 flights a campaign with the defaults), and
prints the table of docs/falsify.md. What FILE.csv holds is not flown again. The first failure of the objective `margin`
is that of `nearest`: until then they ask for the same flights.
"""

from __future__ import annotations

import argparse
import csv
import math
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import Any

from uavftc.jobs.campaign.cases import Cases
from uavftc.jobs.campaign.evaluate import Job, Plan, evaluate, prepare
from uavftc.jobs.campaign.sweep import Ready, ready
from uavftc.jobs.falsify.document import has_failed
from uavftc.jobs.falsify.job import STRAIN
from uavftc.jobs.falsify.nearest import Nearest
from uavftc.jobs.falsify.search import Told
from uavftc.jobs.falsify.space import Space
from uavftc.scenario.campaign import load_campaign

CONTROLLER = "nndondi-l1"
METHODS = ("falsify", "random", "sobol")
COLUMNS = ("campaign", "method", "seed", "budget", "first", "nearest", "lowest", "failures")

Found = tuple[bool, float, float | None]
"""Whether a flight failed, its distance, and its margin."""


def by_search(made: Ready, budget: int, seed: int) -> Iterator[Found]:
    """Yield the flights of `uavftc falsify --objective nearest`."""
    batches = Nearest(Space(made.campaign, made.variants[0].scenario), budget, seed).batches()
    asked, number = next(batches), 0
    while True:
        told = []
        for ask in asked:
            row = evaluate(Job(number, 0, ask.values))
            failed, number = has_failed(row), number + 1
            told.append(Told(row.get("margin"), failed, sum(row.get(name) or 0.0 for name in STRAIN)))
            yield failed, ask.distance, row.get("margin")
        try:
            asked = batches.send(told)
        except StopIteration:
            return


def by_cases(made: Ready, budget: int) -> Iterator[Found]:
    """Yield the flights of the first cases of a sweep."""
    space, cases = Space(made.campaign, made.variants[0].scenario), Cases(made.campaign)
    for case in range(budget):
        values = cases.values(case)
        row = evaluate(Job(case, 0, values))
        yield has_failed(row), space.distance(values), row.get("margin")


def one(campaign: str, method: str, seed: int, budget: int) -> dict[str, Any]:
    """Fly one search and return its line."""
    design = "random" if method == "random" else "sobol"
    settings = [
        f"seed={seed}",
        f"cases={budget}",
        f"design={design}",
        "plants=[analytic]",
        f"controllers=[{CONTROLLER}]",
    ]
    made = ready(load_campaign(campaign, settings))
    prepare(Plan(made.variants, None, "none"))
    flights = list(by_search(made, budget, seed) if method == "falsify" else by_cases(made, budget))
    failed = [(i + 1, far) for i, (failed, far, _) in enumerate(flights) if failed]
    return {
        "campaign": campaign,
        "method": method,
        "seed": seed,
        "budget": budget,
        "first": failed[0][0] if failed else "",
        "nearest": min(far for _, far in failed) if failed else "",
        "lowest": min(margin for _, _, margin in flights if margin is not None),
        "failures": len(failed),
    }


def table(lines: list[dict[str, Any]]) -> Iterator[str]:
    """Yield the table in Markdown: medians, least and greatest; no failure counts as later and farther than any."""
    yield "| campaign | search | found by | flights to the first failure | distance of the nearest |"
    yield "|---|---|---|---|---|"
    for campaign in dict.fromkeys(line["campaign"] for line in lines):
        for method in METHODS:
            here = [line for line in lines if (line["campaign"], line["method"]) == (campaign, method)]
            if not here:
                continue
            first = [float(line["first"] or math.inf) for line in here]
            near = [float(line["nearest"] or math.inf) for line in here]
            found = sum(math.isfinite(value) for value in first)
            yield f"| {campaign} | {method} | {found} of {len(here)} | {_span(first, 0)} | {_span(near, 2)} |"


def _span(values: list[float], digits: int) -> str:
    all_three = (median(values), min(values), max(values))
    shown = [f"{value:.{digits}f}" if math.isfinite(value) else "none" for value in all_three]
    return f"{shown[0]} ({shown[1]}, {shown[2]})"


def main() -> None:
    """Fly what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--budget", type=int, default=500)
    parser.add_argument("--campaigns", default="falsify-paper,falsify-severe")
    parser.add_argument("--file", type=Path, default=Path("falsify_table.csv"))
    given = parser.parse_args()
    lines: list[dict[str, Any]] = []
    if given.file.exists():
        with given.file.open(encoding="utf-8", newline="") as stream:
            lines = list(csv.DictReader(stream))
    else:
        given.file.write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
    done = {(line["campaign"], line["method"], int(line["seed"]), int(line["budget"])) for line in lines}
    for seed in range(1, given.seeds + 1):
        for campaign in given.campaigns.split(","):
            for method in METHODS:
                if (campaign, method, seed, given.budget) in done:
                    continue
                lines.append(one(campaign, method, seed, given.budget))
                with given.file.open("a", encoding="utf-8", newline="") as stream:
                    csv.DictWriter(stream, COLUMNS).writerow(lines[-1])
    for text in table([line for line in lines if int(line["budget"]) == given.budget]):
        print(text)


if __name__ == "__main__":
    main()
