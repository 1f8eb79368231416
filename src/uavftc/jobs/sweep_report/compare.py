"""How often each variant succeeds, how its flights are spread, and which of two is better on the same cases."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
from scipy.stats import bootstrap

from uavftc.analysis.proportion import CONFIDENCE, mcnemar, wilson
from uavftc.core.random import stream

QUANTILES = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
NAMES = ("least", "p05", "p25", "median", "p75", "p95", "greatest")
RESAMPLES = 999
BOOTSTRAPPED = 20_000  # cases at most: the first of them


def shares(success: np.ndarray) -> list[dict[str, Any]]:
    """Return of each variant how many flights counted, how many succeeded, their share and its interval.

    Parameters
    ----------
    success
        1, 0, or NaN of a flight that could not be flown, shape (cases, variants).
    """
    found = []
    for column in success.T:
        flown = int(np.isfinite(column).sum())
        succeeded = int(np.nansum(column))
        low, high = wilson(succeeded, flown)
        found.append(
            {
                "flights": flown,
                "errors": len(column) - flown,
                "successes": succeeded,
                "success": succeeded / flown if flown else None,
                "interval": [float(low), float(high)],
            }
        )
    return found


def spread(values: np.ndarray) -> dict[str, Any]:
    """Return how many of these numbers are there, and quantiles of those; None without any."""
    there = values[np.isfinite(values)]
    ends = np.quantile(there, QUANTILES).tolist() if len(there) else [None] * len(QUANTILES)
    return {"flights": len(there), **dict(zip(NAMES, ends, strict=True))}


def pairs(
    variants: Sequence[Sequence[str]], names: Sequence[str], success: np.ndarray, margin: np.ndarray, seed: int
) -> list[dict[str, Any]]:
    """Return of each two variants that differ in one thing who succeeds where, and how their margins differ.

    Parameters
    ----------
    variants, names
        Controller, plant and aircraft of each, and what it is called.
    success, margin
        Shape (cases, variants); NaN where there is none.
    seed
        Of the bootstrap.
    """
    chosen = [
        (a, b)
        for a, b in combinations(range(len(variants)), 2)
        if sum(x != y for x, y in zip(variants[a], variants[b], strict=True)) == 1
    ]
    found = []
    for a, b in chosen:
        both = np.isfinite(success[:, a]) & np.isfinite(success[:, b])
        first, second = success[both, a] > 0, success[both, b] > 0
        only = int((first & ~second).sum()), int((second & ~first).sum())
        p = mcnemar(*only)
        found.append(
            {
                "first": names[a],
                "second": names[b],
                "cases": int(both.sum()),
                "both": int((first & second).sum()),
                "only_first": only[0],
                "only_second": only[1],
                "neither": int((~first & ~second).sum()),
                "p": p,
                "p_adjusted": min(1.0, p * len(chosen)),
                "margin": _difference(margin[:, a], margin[:, b], stream(seed, f"report {names[a]} {names[b]}")),
            }
        )
    return found


def _difference(first: np.ndarray, second: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:
    """Return how the margins of two differ, first minus second, with bootstrap intervals of mean and median."""
    there = np.isfinite(first) & np.isfinite(second)
    d = (first - second)[there]
    if not len(d):
        return {**spread(d), "first_better": None, "mean": None, "mean_interval": None, "median_interval": None}
    return {
        **spread(d),
        "first_better": float((d > 0).mean()),
        "mean": math.fsum(d) / len(d),
        "mean_interval": interval(d, np.mean, rng),
        "median_interval": interval(d, np.median, rng),
    }


def interval(values: np.ndarray, statistic: Any, rng: np.random.Generator) -> list[float] | None:
    """Return the percentile bootstrap interval of a statistic of (the first of) some numbers; None of a single one."""
    values = values[:BOOTSTRAPPED]
    if len(values) < 2:
        return None
    made = bootstrap(
        (values,),
        statistic,
        n_resamples=RESAMPLES,
        batch=max(1, 2_000_000 // len(values)),
        confidence_level=CONFIDENCE,
        method="percentile",
        random_state=rng,
    )
    return [float(made.confidence_interval.low), float(made.confidence_interval.high)]
