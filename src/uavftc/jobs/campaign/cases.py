"""The cases of a campaign: what each varied key takes in case i, a function of the campaign's file and i alone.

A drawn key takes the quantile of its distribution at a number u in (0, 1), which comes of the design:

    random   u from the stream (seed, key, case): another key more or less changes no other's numbers
    sobol    u from a scrambled Sobol sequence, point i of it (scipy.stats.qmc), a dimension a key in the file's order
    lhs      u from a Latin hypercube of all cases (scipy.stats.qmc), which depends on their number too

Grids and lists are counted off: all lists in step are the slowest digit, then the grids in the file's order, the last
the fastest; case i takes combination i modulo their number.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from uavftc.core.random import stream
from uavftc.scenario.campaign import Campaign, Vary

CHUNK = 256  # points of a Sobol sequence drawn at once
EDGE = 2.0**-53  # u stays as far from 0 and 1, whose normal quantiles are infinite
NEAR_END = 1e-6  # the quantile that stands for the end of a range, which no case reaches
NEAR_NORMAL = 1e-3  # and for that of a normal distribution, which has none


class Cases:
    """The cases of a campaign, each to be had alone."""

    def __init__(self, campaign: Campaign) -> None:
        self.count = campaign.count
        self.vary: Mapping[str, Vary] = campaign.vary
        self._seed, self._design = campaign.seed, campaign.design
        self._drawn = [key for key, vary in campaign.vary.items() if not vary.enumerated]
        self._grids = [key for key, vary in campaign.vary.items() if vary.kind == "grid"]
        self._lists = [key for key, vary in campaign.vary.items() if vary.kind == "list"]
        self._chunk: tuple[int, np.ndarray] | None = None
        self._sequence: qmc.Sobol | None = None
        self._cube: np.ndarray | None = None

    def values(self, case: int) -> dict[str, Any]:
        """Return what each varied key takes in a case, in the order of the file."""
        found = self._counted(case)
        if self._drawn:
            u = np.clip(self._points(case), EDGE, 1.0 - EDGE)
            found |= {key: quantile(self.vary[key], float(at)) for key, at in zip(self._drawn, u, strict=True)}
        return {key: found[key] for key in self.vary}

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return (self.values(case) for case in range(self.count))

    def _counted(self, case: int) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key in reversed(self._grids):
            given = self.vary[key].given
            case, digit = divmod(case, len(given))
            found[key] = given[digit]
        for key in self._lists:
            found[key] = self.vary[key].given[case % len(self.vary[key].given)]
        return found

    def _points(self, case: int) -> np.ndarray:
        if self._design == "sobol":
            return self._sobol(case)
        if self._design == "lhs":
            if self._cube is None:
                rng = stream(self._seed, "campaign lhs")
                self._cube = qmc.LatinHypercube(len(self._drawn), seed=rng).random(self.count)
            point: np.ndarray = self._cube[case]
            return point
        return np.array([stream(self._seed, f"campaign {key}", case).random() for key in self._drawn])

    def _sobol(self, case: int) -> np.ndarray:
        first = case - case % CHUNK
        if self._chunk is None or self._chunk[0] != first:
            if self._sequence is None or self._sequence.num_generated > first:
                self._sequence = qmc.Sobol(len(self._drawn), scramble=True, seed=stream(self._seed, "campaign sobol"))
            if ahead := first - self._sequence.num_generated:  # each step of it takes its time
                self._sequence.fast_forward(ahead)
            self._chunk = first, self._sequence.random(CHUNK)
        point: np.ndarray = self._chunk[1][case - first]
        return point


def quantile(vary: Vary, u: float) -> Any:
    """Return the value of a drawn key at u in (0, 1)."""
    given = vary.given
    if vary.kind == "choice":
        return given[int(u * len(given))]
    a, b = given
    if vary.kind == "integer":
        return int(a) + int(u * (int(b) - int(a) + 1))
    if vary.kind == "normal":
        return float(a + b * ndtri(u))
    if vary.kind == "log-uniform":
        return min(max(math.exp(math.log(a) + u * (math.log(b) - math.log(a))), a), b)
    return float(min(a + u * (b - a), b))


def extremes(vary: Vary) -> tuple[Any, ...]:
    """Return the values of a key between which all others lie, or all of them where they are counted off."""
    if vary.kind in ("choice", "grid", "list"):
        return vary.given
    if vary.kind == "integer":
        return tuple(map(int, vary.given))
    edge = NEAR_NORMAL if vary.kind == "normal" else NEAR_END
    return quantile(vary, edge), quantile(vary, 1.0 - edge)
