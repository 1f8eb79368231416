"""Which varied key matters: PAWN by SALib on the table as it is, what chance would give, and which way it goes.

The PAWN index of a key is the median, over slices of what it took, of the Kolmogorov-Smirnov distance between the
margins in the slice and all margins (F. Pianosi and T. Wagener, "Distribution-based sensitivity analysis from a generic
input-output sample", Environmental Modelling & Software 108, 2018). It asks nothing of the shape of the distribution,
which the margins of lost vehicles have at their own end. Continuous keys are sliced in ten by SALib; where a key takes
at most ten values, or texts, each of them is a slice, by scipy. With few flights a slice differs from the whole by
chance: `chance` is the mean index of the same numbers shuffled and three standard deviations more, and a key that is
not above it has shown no influence. The rank correlation (Spearman) says which way the margin goes with the key.

Of SALib only PAWN is used: its moment-independent delta has other keys in 1.6 than in 1.5, sets the process's filter of
warnings, and estimates a density, which the margins of lost vehicles do not have.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import ks_2samp, spearmanr

from uavftc.core.random import stream

CASES = 5_000  # the first of them: enough to rank, and PAWN takes 10 ms a key and 1,000 cases
SLICES = 10
SHUFFLES = 20
DEVIATIONS = 3.0
FEWEST = 40  # flights of which an index can be had
METHOD = "PAWN"
NO_SALIB = "SALib is not installed (pip install 'uavftc[campaign]'): inputs are ranked by rank correlation alone"


def has_salib() -> bool:
    """Return whether SALib can be imported."""
    try:
        from SALib.analyze import pawn  # noqa: F401, PLC0415 - an extra, and it takes a second
    except ImportError:
        return False
    return True


def influence(
    inputs: Mapping[str, tuple[np.ndarray, Sequence[str] | None]], margin: np.ndarray, seed: int
) -> dict[str, dict[str, Any]] | None:
    """Return of each key its index, what chance would give, and the rank correlation; None where nothing can be said.

    Parameters
    ----------
    inputs
        What each key took, shape (cases,), and its words where it is a text.
    margin
        Of one variant, shape (cases,); NaN where there is none.
    seed
        Of the shuffles.
    """
    there = np.isfinite(margin)
    y = margin[there]
    if len(y) < FEWEST or np.ptp(y) == 0.0:
        return None
    salib = has_salib()
    found = {}
    by_chance: float | None = None
    for key, (values, words) in inputs.items():
        x = values[there]
        if np.ptp(x) == 0.0:
            continue
        sliced = words is not None or len(np.unique(x)) <= SLICES
        rank = None if words is not None else float(spearmanr(x, y).statistic)
        one: dict[str, Any] = {"index": None, "chance": None, "rank_correlation": rank}
        if salib:
            one["index"] = index(x, y, sliced=sliced)
            if sliced or by_chance is None:
                chance = _chance(x, y, sliced, stream(seed, f"report shuffled {key}" if sliced else "report shuffled"))
                by_chance = by_chance if sliced else chance
            one["chance"] = chance if sliced else by_chance
        found[key] = one
    return found


def index(x: np.ndarray, y: np.ndarray, *, sliced: bool) -> float:
    """Return the PAWN index of what a key took, x, on the margins, y, both shape (n,).

    `sliced`: whether each value of x is a slice of its own.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an exact p-value, which nobody asks for, that becomes an asymptotic one
        if sliced:
            return float(np.median([ks_2samp(y[x == value], y, method="asymp").statistic for value in np.unique(x)]))
        from SALib.analyze import pawn  # noqa: PLC0415

        problem = {"num_vars": 1, "names": ["x"], "bounds": [[float(x.min()), float(x.max())]]}
        return float(np.asarray(pawn.analyze(problem, x[:, None], y, S=SLICES)["median"])[0])


def _chance(x: np.ndarray, y: np.ndarray, sliced: bool, rng: np.random.Generator) -> float:
    shuffled = [index(rng.permutation(x), y, sliced=sliced) for _ in range(SHUFFLES)]
    return float(np.mean(shuffled) + DEVIATIONS * np.std(shuffled, ddof=1))


def order(found: Sequence[Mapping[str, Mapping[str, Any]] | None], keys: Sequence[str]) -> list[str]:
    """Return the keys, the most influential first: by the index, or the rank correlation, averaged over variants."""
    scores: dict[str, list[float]] = {key: [] for key in keys}
    for one in found:
        for key, said in (one or {}).items():
            of = said["index"] if said["index"] is not None else abs(said["rank_correlation"] or 0.0)
            scores[key].append(of)
    return sorted(keys, key=lambda key: -float(np.mean(scores[key])) if scores[key] else 0.0)
