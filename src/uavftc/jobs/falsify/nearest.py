"""The failure that is nearest to nominal: first any failure, as `search` finds it, then ever nearer ones.

From a failure, in turn, until none of it comes nearer:

    ray         bisection between nominal, which survives, and the failure, on the straight line
    reset       each key alone back to nominal; those that the failure does not need go back together
    plane       the margin as a plane, from what each key alone changed: the point of the plane at which it is 0 nearest
                to nominal (the design point of structural reliability: A. M. Hasofer and N. C. Lind, J. Eng. Mech. Div.
                100, 1974), and from there along its ray
    cma         CMA-ES on distance + rho max(0, margin), rho raised while most of a generation survives, and lowered
                while most of it fails

and then from the next failure that lies elsewhere, or after a new run down the margin where there is none.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence

import numpy as np

from uavftc.jobs.falsify.search import Ask, Batches, Flown, Search, Told

BISECTIONS = 5
"""Of a ray."""
BEGINNINGS = 4
"""Failures whose rays are bisected before the nearest of them is gone on with."""
NEARER = 0.01
"""Share of the distance by which a step must come nearer to count."""
ELSEWHERE = 0.5
"""Cosine of the angle, seen from nominal, below which a failure lies elsewhere."""
PATIENCE = 4
"""Generations of CMA-ES, and a quarter of one a dimension, that may pass before it comes nearer."""
SPREAD = 0.35
"""First deviation of CMA-ES, in distances, over the root of the dimension."""

Step = Generator[list[Ask], Sequence[Told], Flown]


class Nearest(Search):
    """The nearest failure; parameters as those of `Search`."""

    def _search(self) -> Batches:
        nominal = yield from self._begin()
        if nominal.failed:
            return
        self._nominal = nominal
        failures = [one for one in self._start if one.failed]
        done: list[np.ndarray] = []
        while True:
            fresh = [one for one in failures if self._lies_elsewhere(one, done)]
            while not fresh:
                fresh = [one for one in (yield from self._run(self._next_start(), until_failed=True)) if one.failed]
            some = sorted(fresh, key=lambda one: one.distance)[:BEGINNINGS]
            some = yield from self._bisect(some)
            best = min(some, key=lambda one: one.distance)
            done += [one.s for one in some if one is not best and not self._lies_elsewhere(one, [best.s])]
            done.append(best.s)
            best = yield from self._nearer(best)
            done.append(best.s)

    def _lies_elsewhere(self, one: Flown, done: Sequence[np.ndarray]) -> bool:
        return all(_cosine(one.s - self._nominal.s, s - self._nominal.s) < ELSEWHERE for s in done)

    def _nearer(self, best: Flown) -> Step:
        """Come nearer from a failure until no step helps any more."""
        while True:
            before = best.distance
            best = yield from self._reset(best)
            if best.distance < (1.0 - 5 * NEARER) * before:
                continue
            best = yield from self._evolve(best)
            if best.distance > (1.0 - NEARER) * before:
                return best

    def _bisect(
        self, failures: Sequence[Flown], times: int = BISECTIONS
    ) -> Generator[list[Ask], Sequence[Told], list[Flown]]:
        """Bisect the rays of several failures at once; return the nearest failure on each."""
        held, broke = [0.0] * len(failures), [1.0] * len(failures)
        best = list(failures)
        origin = self._nominal.s
        for _ in range(times):
            shares = [0.5 * (a + b) for a, b in zip(held, broke, strict=True)]
            points = [origin + share * (one.s - origin) for share, one in zip(shares, failures, strict=True)]
            flown = yield from self._fly(points, "ray")
            for i, one in enumerate(flown):
                if one.failed:
                    broke[i] = shares[i]
                    best[i] = min(best[i], one, key=lambda x: x.distance)
                else:
                    held[i] = shares[i]
        return best

    def _reset(self, best: Flown) -> Step:
        """Put keys back to nominal that the failure does not need, then go to the nearest point of the plane."""
        origin = self._nominal.s
        away = [i for i in range(self.space.dimension) if abs(best.s[i] - origin[i]) > 1e-3]
        points = [_with(best.s, [i], origin) for i in away]
        flown = yield from self._fly(points, "reset")
        if len(flown) < len(points):
            return min([best, *(one for one in flown if one.failed)], key=lambda one: one.distance)
        idle = [i for i, one in zip(away, flown, strict=True) if one.failed]
        candidates = [one for one in flown if one.failed]
        if len(idle) > 1:
            candidates += yield from self._fly([_with(best.s, idle, origin)], "reset")
        plane = self._plane(best, away, flown)
        if plane is not None:
            (one,) = yield from self._fly([plane], "plane")
            if not one.failed:  # a little further out
                (one,) = yield from self._fly([origin + 1.3 * (one.s - origin)], "plane")
            candidates.append(one)
        best = min([best, *(one for one in candidates if one.failed)], key=lambda one: one.distance)
        (best,) = yield from self._bisect([best], 3)
        return best

    def _plane(self, best: Flown, away: Sequence[int], flown: Sequence[Flown]) -> np.ndarray | None:
        """Return the point nearest to nominal at which the margin, taken as a plane, is 0; None where there is none."""
        origin = self._nominal.s
        slope = np.zeros(self.space.dimension)
        for i, one in zip(away, flown, strict=True):
            slope[i] = (best.margin - one.margin) / (best.s[i] - origin[i])
        at_nominal = best.margin - float(slope @ (best.s - origin))
        if at_nominal <= 0.0:  # more than a plane: from the margin that nominal has
            at_nominal = self._nominal.margin
        free = slope != 0.0
        x = origin.copy()
        for _ in range(self.space.dimension):  # coordinates that reach their bounds stay there
            left = at_nominal + float(slope[~free] @ (x - origin)[~free])
            size = float(slope[free] @ slope[free])
            if size == 0.0 or left <= 0.0:
                break
            x[free] = origin[free] - slope[free] * left / size
            out = free & ((x < 0.0) | (x > 1.0))
            if not out.any():
                return x
            x = np.clip(x, 0.0, 1.0)
            free &= ~out
        return None

    def _evolve(self, best: Flown) -> Step:
        """Let CMA-ES go nearer along the edge between failing and surviving."""
        sigma = max(SPREAD * best.distance / math.sqrt(self.space.dimension), 0.005)
        self._begun.append(best.s)
        es = self._strategy(best.s, sigma)
        rho = 2.0 * best.distance / max(self._nominal.margin, 0.05)
        since, before = 0, best.distance
        while not es.stop() and since < PATIENCE + self.space.dimension // 4:
            points = es.ask()
            flown = yield from self._fly(points, "cma")
            best = min([best, *(one for one in flown if one.failed)], key=lambda one: one.distance)
            if len(flown) < len(points):
                break
            es.tell(points, [one.distance + rho * max(0.0, 0.0 if one.failed else one.fitness) for one in flown])
            failed = sum(one.failed for one in flown) / len(flown)
            rho *= 1.5 if failed < 0.2 else 1.0 / 1.2 if failed > 0.6 else 1.0
            since += 1
            if best.distance < (1.0 - NEARER) * before:
                since, before = 0, best.distance
        return best


def _with(s: np.ndarray, which: Sequence[int], origin: np.ndarray) -> np.ndarray:
    changed = s.copy()
    changed[list(which)] = origin[list(which)]
    return changed


def _cosine(a: np.ndarray, b: np.ndarray) -> float:
    return float(a @ b) / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-12)
