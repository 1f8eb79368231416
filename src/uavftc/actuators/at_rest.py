"""What the chain leaves of an effector at rest: the deflections that a constant command reaches, at a time of a flight.

Each effect of the chain that changes them says so by `at_rest(config, given, rest, reach)`, in its file, and returns
what it makes of a reach: one or, of a fault that comes and goes or swings, the extremes of what it does. Delays, lags,
rates, dead bands and backlash change how a surface gets to a place and not which places there are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.config.effect import Effect, config_of
from uavftc.core.given import Given


class Rest(NamedTuple):
    """When a vehicle is looked at, and where its surfaces were before."""

    t: float
    """Time of the flight, s."""
    before: Callable[[float], np.ndarray]
    """before(start_s): deflection of each effector about trim, shape (n,), rad, when a fault began that holds it."""


class Reach(NamedTuple):
    """Where each of n effectors can be: c + by_alpha alpha + by_beta beta about trim, with low <= c <= high."""

    low: np.ndarray
    """Shape (n,), rad."""
    high: np.ndarray
    """Shape (n,), rad; equal to `low` where no command moves the surface."""
    by_alpha: np.ndarray
    """Shape (n,): of a floating surface, deflection per angle of attack."""
    by_beta: np.ndarray
    """Shape (n,): and per sideslip."""
    held: np.ndarray
    """Shape (n,): whether a fault holds the surface at a place, which is then `low`, or lets it float."""

    def at(self, c: np.ndarray, alpha: float, beta: float) -> np.ndarray:
        """Return the deflections about trim, shape (n,), rad, of c at an incidence and a sideslip, rad."""
        deflections: np.ndarray = c + self.by_alpha * alpha + self.by_beta * beta
        return deflections

    def scaled(self, gain: np.ndarray, offset: np.ndarray) -> Reach:
        """Return gain u + offset for each u that is reached; gain >= 0, both shape (n,)."""
        low, high = (
            np.multiply(gain, end, out=np.zeros_like(end), where=gain != 0.0) for end in (self.low, self.high)
        )  # 0 of an infinite command is 0
        return Reach(low + offset, high + offset, gain * self.by_alpha, gain * self.by_beta, self.held)

    def within(self, low: np.ndarray, high: np.ndarray) -> Reach:
        """Return the part between limits, shape (n,), rad; what is beyond one stays at it, but for what floats."""
        floats = (self.by_alpha != 0.0) | (self.by_beta != 0.0)
        ends = (np.where(floats, end, np.clip(end, low, high)) for end in (self.low, self.high))
        return self._replace(**dict(zip(("low", "high"), ends, strict=True)))

    def put(self, hit: np.ndarray, at: np.ndarray) -> Reach:
        """Return it with the effectors of `hit` held at a place, both shape (n,)."""
        low, high = np.where(hit, at, self.low), np.where(hit, at, self.high)
        return Reach(low, high, np.where(hit, 0.0, self.by_alpha), np.where(hit, 0.0, self.by_beta), self.held | hit)


def everywhere(n: int) -> Reach:
    """Return the reach of n effectors that nothing limits."""
    return Reach(np.full(n, -np.inf), np.full(n, np.inf), np.zeros(n), np.zeros(n), np.zeros(n, dtype=bool))


def acting(entries: Iterable[Any], t: float) -> list[Any]:
    """Return the entries with a window in which the time t, s, lies."""
    return [e for e in entries if e.start_s <= t and (e.end_s is None or t < e.end_s)]


def reaches(chain: Sequence[Effect], scenario: Any, given: Given, rest: Rest) -> list[Reach]:
    """Return where the effectors of a flight can be at a time, by a chain: one, or the extremes of what faults do."""
    found = [everywhere(len(given.effectors))]
    for effect in chain:
        if hasattr(effect, "at_rest"):
            found = [made for one in found for made in effect.at_rest(config_of(effect, scenario), given, rest, one)]
    return found
