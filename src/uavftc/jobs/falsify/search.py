"""How a space is searched: a start of Sobol points, and from the best of them CMA-ES, again and again.

A search is a coroutine: it asks for batches of points and is told what came of them, so that it does not know who flies
them, and where. What it asks for depends on its seed and on what it is told, on nothing else: a search that was ended
is gone on with by telling it again what is known.

    nominal     the point of the ranges that is nearest to nominal
    start       scrambled Sobol points, drawn as the campaign draws
    cma         generations of CMA-ES (N. Hansen, "The CMA evolution strategy: a tutorial", arXiv 1604.00772; package
                `cma`) on the margin, from the best start point that no run has begun near to; a run that has stopped
                to improve is followed by the next, every second one with twice the population

The margin of a flight is that of its worst requirement, so a requirement that no fault changes (how the first step of
the reference is followed) hides those that faults bring nearer to their limits. So a run goes down

    f = m - 0.1 ln(e/e_nominal) max(m, 0),    e the integral of |error| over time, summed over the axes,

which is the margin m where it is below 0, and above it lower for a flight that is further off its reference.

Bounds are those of `cma`'s `BoundTransform`; a coordinate of k values keeps a deviation of at least a third of a value.
Points whose values were flown before are not flown again, and cost nothing.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import qmc

from uavftc.core.random import stream
from uavftc.errors import InputError
from uavftc.jobs.falsify.space import Space

LEAST_STARTS, START_SHARE = 16, 16
"""Start points: a power of two near the budget over this, at least so many and the dimension."""
SIGMA = 0.2
"""First deviation of CMA-ES, in ranges."""
NEAR = 0.15
"""Times the square root of the dimension: a start point so near to where a run has been is not another one."""
STALL = 1e-3
"""A run that improves by less, in margin, over its last generations has stopped to."""
IDLE = 30
"""Batches in a row without a new flight, after which there is nothing left to fly."""
GUIDE = 0.1
"""How much of a margin above 0 e times the strain of nominal is worth."""
WORSE = 2.0
"""Stands for the margin of a flight that could not be flown: above any margin."""


class Ask(NamedTuple):
    """A flight that a search asks for."""

    stage: str
    values: dict[str, Any]
    distance: float


class Told(NamedTuple):
    """What came of it."""

    margin: float | None
    """None where it could not be flown."""
    failed: bool
    """Flown, and not survived."""
    strain: float = 0.0
    """How far the flight was off its reference, in any unit; what guides where the margin says nothing."""


class Flown(NamedTuple):
    """A point and what is known of it."""

    s: np.ndarray
    """On the cube, shape (d,)."""
    margin: float
    fitness: float
    """What a run goes down: the margin, guided."""
    failed: bool
    distance: float


Batches = Generator[list[Ask], Sequence[Told], None]


class OverError(Exception):
    """The budget is spent, or there is nothing left to fly."""


class Search:
    """The lowest margin; `nearest.Nearest` is the other objective.

    Parameters
    ----------
    space
        What is searched.
    budget
        Flights.
    seed
        Of all that is drawn.
    """

    def __init__(self, space: Space, budget: int, seed: int) -> None:
        self.space, self.budget, self._seed = space, budget, seed
        self.runs = 0
        self.flown: list[dict[str, Any]] = []
        """The values of each flight, in order."""
        self._known: dict[str, Told] = {}
        self._idle = 0
        self._at_rest: float | None = None
        self._begun: list[np.ndarray] = []
        self._start: list[Flown] = []
        self._sobol: qmc.Sobol | None = None

    def batches(self) -> Batches:
        """Ask for batches of flights, each new, until the budget is spent."""
        with suppress(OverError):
            yield from self._search()

    def _search(self) -> Batches:
        yield from self._begin()
        while True:
            yield from self._run(self._next_start())

    def _begin(self) -> Generator[list[Ask], Sequence[Told], Flown]:
        """Fly nominal and the start points, and return the former."""
        (nominal,) = yield from self._fly([self.space.start()], "nominal")
        yield from self._more_starts()
        return nominal

    def _more_starts(self) -> Batches:
        d = self.space.dimension
        if self._sobol is None:
            self._sobol = qmc.Sobol(d, scramble=True, seed=stream(self._seed, "falsify start"))
        asked = max(self.budget / START_SHARE, LEAST_STARTS, d)
        count = 2 ** round(math.log2(asked))
        flown = yield from self._fly([self.space.drawn(u) for u in self._sobol.random(count)], "start")
        self._start += flown

    def _next_start(self) -> Flown:
        """Return the start point of the lowest margin that no run has been near to, or a fresh one."""
        free = [one for one in self._start if self._is_new(one.s)]
        if free:
            return min(free, key=lambda one: one.fitness)
        assert self._sobol is not None
        (u,) = self._sobol.random(1)
        return Flown(self.space.drawn(u), WORSE, WORSE, False, math.inf)

    def _is_new(self, s: np.ndarray) -> bool:
        least = NEAR * math.sqrt(self.space.dimension)
        return all(float(np.linalg.norm(s - other)) > least for other in self._begun)

    def _run(self, start: Flown, until_failed: bool = False) -> Generator[list[Ask], Sequence[Told], list[Flown]]:
        """Let CMA-ES go down the margin from a point; return what it flew."""
        self._begun.append(start.s)
        es = self._strategy(start.s, SIGMA, doubled=self.runs // 2)
        best: list[float] = []
        flown: list[Flown] = []
        while not es.stop():
            points = es.ask()
            generation = yield from self._fly(points, "cma")
            self.runs += not flown
            if len(generation) < len(points):
                return generation
            es.tell(points, [one.fitness for one in generation])
            flown += generation
            if until_failed and any(one.failed for one in generation):
                break
            best.append(min([one.fitness for one in generation] + best[-1:]))
            patience = 6 + 3 * self.space.dimension // es.popsize * 2
            if len(best) > patience and best[-patience - 1] - best[-1] < STALL:
                break
        self._begun.append(np.resize(start.s if es.best.x is None else es.best.x, self.space.dimension))
        return flown

    def _strategy(self, at: np.ndarray, sigma: float, doubled: int = 0) -> Any:
        cma = load_cma()
        d = max(self.space.dimension, 2)  # the package knows no single one: a second that does nothing
        at = np.resize(at, d)
        rng = stream(self._seed, "falsify cma", len(self._begun))
        least = [sigma * 1e-3 if axis.levels == 0 else 1.0 / (3.0 * axis.levels) for axis in self.space.axes]
        least = np.resize(least, d).tolist()
        options = {
            "bounds": [[0.0] * d, [1.0] * d],
            "popsize": (4 + int(3 * math.log(d))) * 2 ** min(doubled, 4),
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": math.nan,  # so that it leaves numpy's global generator alone
            "minstd": least,
            "tolx": 1e-4,
            "tolfun": 1e-6,
            "verbose": -9,
            "verb_log": 0,
            "verb_disp": 0,
        }
        inside = np.clip(at, 1e-3, 1.0 - 1e-3)
        return cma.CMAEvolutionStrategy(inside, sigma, options)

    def _fly(self, points: Sequence[np.ndarray], stage: str) -> Generator[list[Ask], Sequence[Told], list[Flown]]:
        """Fly what is new among the points, and return them all, or the first of them where the budget ends.

        Raises
        ------
        OverError
            If the budget was spent before, or nothing new has come up for long.
        """
        if len(self.flown) >= self.budget:
            raise OverError
        asked: dict[str, Ask] = {}
        found: list[tuple[np.ndarray, str, float]] = []
        for point in points:
            s = np.clip(np.asarray(point[: self.space.dimension], dtype=float), 0.0, 1.0)
            values = self.space.values(s)
            key, distance = repr(values), self.space.distance(values)
            if key not in self._known and key not in asked:
                if len(self.flown) + len(asked) >= self.budget:
                    break
                asked[key] = Ask(stage, values, distance)
            found.append((s, key, distance))
        self._idle = 0 if asked else self._idle + 1
        if self._idle > IDLE or (self.space.finite or math.inf) <= len(self._known):
            raise OverError
        if asked:
            self.flown += [ask.values for ask in asked.values()]
            told = yield list(asked.values())
            self._known |= dict(zip(asked, told, strict=True))
        return [self._made(s, self._known[key], distance) for s, key, distance in found]

    def _made(self, s: np.ndarray, told: Told, distance: float) -> Flown:
        margin = WORSE if told.margin is None else told.margin
        if self._at_rest is None:
            self._at_rest = told.strain  # the first flight is nominal
        more = math.log(told.strain / self._at_rest) if told.strain > 0.0 and self._at_rest > 0.0 else 0.0
        fitness = margin - GUIDE * min(max(more, -1.0), 5.0) * min(max(margin, 0.0), 1.0)
        return Flown(s, margin, fitness, told.failed, distance)


def load_cma() -> Any:
    """Return the package `cma`.

    Raises
    ------
    InputError
        If it is not installed.
    """
    try:
        import cma  # noqa: PLC0415 - takes seconds, and is an extra
    except ModuleNotFoundError:
        raise InputError(
            "uavftc falsify",
            found="no package cma",
            expected="the extra falsify",
            remedy="python -m pip install 'uavftc[falsify]'",
        ) from None
    return cma
