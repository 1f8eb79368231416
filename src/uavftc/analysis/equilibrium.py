"""Equilibria within bounds: equations f(x) = 0 of which some unknowns are free, and what comes nearest to one.

    solve     x with f_rows(x) = 0 and low <= x <= high; where there is none, the least sum of squares
    nearest   of those x the one nearest to given values of some unknowns
    reach     of those x the one with an unknown furthest on the way to a value
    least     of the x with all other equations met, the one that leaves least of one equation

By scipy's `least_squares` (dogbox), and by its SLSQP for what is least or nearest, on differences of a step of `STEP`
of each unknown's size, since f is measured. All are local: several starts are tried, and what was not found may still
exist.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

STEP = 1e-4
"""Of a difference, in sizes of the unknown."""
EVALUATIONS = 18
NEXT = 8
"""Evaluations from a solution to the next one."""
STALLED = 1e-4
"""Relative change of the sum of squares below which it no longer falls towards zero."""
ITERATIONS = 60


class System(NamedTuple):
    """Equations of m unknowns, k of them."""

    f: Callable[[np.ndarray], np.ndarray]
    """f(x), shape (k,), of x, shape (m,)."""
    low: np.ndarray
    """Least value of each unknown, shape (m,)."""
    high: np.ndarray
    """Greatest, shape (m,)."""
    size: np.ndarray
    """What is much of each unknown, shape (m,)."""
    scale: np.ndarray
    """What is much of each equation, shape (k,)."""
    tolerance: np.ndarray
    """Below which each equation is met, shape (k,)."""
    near: Callable[[np.ndarray], np.ndarray] | None = None
    """In place of f for differences: cheaper, and wrong by what is the same at points near each other."""
    slow: tuple[int, ...] = ()
    """Unknowns over which differences are those of f all the same."""

    def bounded(self, i: int, low: float, high: float) -> System:
        """Return it with other bounds of an unknown."""
        lows, highs = self.low.copy(), self.high.copy()
        lows[i], highs[i] = low, high
        return self._replace(low=lows, high=highs)


class Found(NamedTuple):
    """A point that was found."""

    x: np.ndarray
    """Shape (m,)."""
    residual: np.ndarray
    """f(x), shape (k,)."""
    met: bool
    """Whether the equations asked for are met."""


class _Measured:
    """Equations and their differences over the free unknowns, in units of scale and size; the last point is kept."""

    def __init__(self, system: System, x: np.ndarray, free: Sequence[int]) -> None:
        self.system, self.x, self.free = system, np.array(x, dtype=float), np.array(free, dtype=int)
        self.size = system.size[self.free]
        self.bounds = system.low[self.free] / self.size, system.high[self.free] / self.size
        self._at: tuple[bytes, np.ndarray] | None = None
        self._slope: tuple[bytes, np.ndarray] | None = None

    def point(self, z: np.ndarray) -> np.ndarray:
        x = self.x.copy()
        x[self.free] = np.clip(z * self.size, self.system.low[self.free], self.system.high[self.free])
        return x

    def f(self, z: np.ndarray) -> np.ndarray:
        key = z.tobytes()
        if self._at is None or self._at[0] != key:
            self._at = key, self._scaled(self.system.f, z)
        return self._at[1]

    def slope(self, z: np.ndarray) -> np.ndarray:
        key = z.tobytes()
        if self._slope is None or self._slope[0] != key:
            system, f = self.system, self.f(z)
            J = np.zeros((len(f), len(z)))
            base = f if system.near is None else self._scaled(system.near, z)
            quick = [i for i, k in enumerate(self.free) if k not in system.slow]
            for i in (*quick, *(i for i, k in enumerate(self.free) if k in system.slow)):  # f moves engines: it is last
                h = STEP if z[i] + STEP <= self.bounds[1][i] else -STEP
                moved = z.copy()
                moved[i] += h
                if system.near is not None and i in quick:
                    J[:, i] = (self._scaled(system.near, moved) - base) / h
                else:
                    J[:, i] = (self._scaled(system.f, moved) - f) / h
            self._slope = key, J
        return self._slope[1]

    def _scaled(self, f: Callable[[np.ndarray], np.ndarray], z: np.ndarray) -> np.ndarray:
        return np.nan_to_num(f(self.point(z)) / self.system.scale, nan=1e6, posinf=1e6, neginf=-1e6)

    def found(self, z: np.ndarray, rows: Sequence[int]) -> Found:
        residual = self.f(z) * self.system.scale
        met = bool(np.all(np.abs(residual[list(rows)]) <= self.system.tolerance[list(rows)]))
        return Found(self.point(z), residual, met)


def differences(system: System, x: np.ndarray, places: Sequence[int]) -> np.ndarray:
    """Return the change of f with the unknowns at some places, shape (k, len(places))."""
    measured = _Measured(system, x, places)
    J = measured.slope(np.asarray(x)[measured.free] / measured.size)
    found: np.ndarray = J * system.scale[:, None] / measured.size
    return found


def solve(
    system: System,
    starts: Iterable[np.ndarray],
    free: Sequence[int],
    rows: Sequence[int],
    *,
    evaluations: int = EVALUATIONS,
) -> Found:
    """Return the first x that meets the equations `rows`, by moving the unknowns `free` from one start after another.

    Where none does within so many evaluations, the one with the least sum of squares, each equation over its scale.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - 0.1 s that a command without it need not pay

    best: Found | None = None
    cost = np.inf
    chosen = list(rows)
    for start in starts:
        measured = _Measured(system, start, free)
        low, high = measured.bounds
        z = np.clip(start[measured.free] / measured.size, low, high)
        if len(z):
            method = "dogbox"
            result = least_squares(
                lambda z, m=measured: m.f(z)[chosen],
                z,
                jac=lambda z, m=measured: m.slope(z)[chosen],
                bounds=(low, high),
                method=method,
                xtol=1e-12,
                ftol=STALLED,
                gtol=1e-12,
                max_nfev=evaluations,
            )
            z = result.x
        found = measured.found(z, rows)
        size = float(np.sum((found.residual / system.scale)[chosen] ** 2))
        if found.met:
            return found
        if size < cost:
            best, cost = found, size
    assert best is not None  # there is a start
    return best


def nearest(
    system: System, start: np.ndarray, free: Sequence[int], rows: Sequence[int], goals: Sequence[int], at: np.ndarray
) -> Found:
    """Return the x that meets `rows` with the unknowns `goals` nearest to the values `at`, counted in sizes.

    Parameters
    ----------
    start
        Best one that meets them, shape (m,).
    free
        What may be moved, the goals among them.
    """
    measured = _Measured(system, start, free)
    places = [list(free).index(g) for g in goals]
    wanted = np.asarray(at) / system.size[list(goals)]

    def gradient(z: np.ndarray) -> np.ndarray:
        g = np.zeros(len(z))
        g[places] = 2.0 * (z[places] - wanted)
        return g

    return _constrained(measured, start, rows, lambda z: float(np.sum((z[places] - wanted) ** 2)), gradient)


def reach(
    system: System,
    start: np.ndarray,
    free: Sequence[int],
    rows: Sequence[int],
    goal: int,
    *,
    towards: float,
    step: float,
    accuracy: float,
    guess: float | None = None,
) -> Found:
    """Return the x that meets `rows` with the unknown `goal` furthest on the way from `start` to the value `towards`.

    By steps, each from the solution of the one before, as long as there is one; then by bisection. `start` meets the
    equations, and the goal is not among `free`. A `guess` of how far it is is tried first.
    """
    best = solve(system, [start], free, rows)
    end, ahead = float(np.clip(towards, system.low[goal], system.high[goal])), step
    sign = 1.0 if end >= best.x[goal] else -1.0
    if guess is not None and sign * (guess - best.x[goal]) > accuracy:
        ahead = abs(guess - float(best.x[goal]))

    def tried(value: float) -> Found:
        moved = best.x.copy()
        moved[goal] = value
        return solve(system, [moved], free, rows, evaluations=NEXT)

    while best.met and sign * (end - best.x[goal]) > 0.0:
        value = float(best.x[goal]) + sign * min(ahead, sign * (end - float(best.x[goal])))
        found = tried(value)
        if found.met and guess is not None:  # a jump: over no gap
            middle = tried(0.5 * (value + float(best.x[goal])))
            found = found if middle.met else middle
        if found.met:
            best, ahead = found, (2.0 * accuracy if guess is not None else 2.0 * ahead)
            guess = None
        elif ahead <= accuracy:
            break
        else:
            ahead = 0.5 * min(ahead, abs(value - float(best.x[goal])))
            end = value  # there is none
            guess = None
    return best


def least(system: System, start: np.ndarray, free: Sequence[int], rows: Sequence[int], row: int) -> Found:
    """Return the x that leaves least of the equation `row` with the equations `rows`, others, met.

    `start` best meets `rows`, shape (m,). `met` of what is returned is that of `rows`.
    """
    measured = _Measured(system, start, free)
    z = start[measured.free] / measured.size
    sign = 1.0 if measured.f(z)[row] >= 0.0 else -1.0
    return _constrained(
        measured,
        start,
        rows,
        lambda z: sign * float(measured.f(z)[row]),
        lambda z: sign * measured.slope(z)[row],
        above=(row, sign),
    )


def _constrained(
    measured: _Measured,
    start: np.ndarray,
    rows: Sequence[int],
    objective: Callable[[np.ndarray], float],
    gradient: Callable[[np.ndarray], np.ndarray],
    above: tuple[int, float] | None = None,
) -> Found:
    """Minimise an objective with equations met; then meet them as well as `solve` does, from there."""
    from scipy.optimize import minimize  # noqa: PLC0415

    chosen = list(rows)
    constraints: list[dict[str, Any]] = [
        {"type": "eq", "fun": lambda z: measured.f(z)[chosen], "jac": lambda z: measured.slope(z)[chosen]}
    ]
    if above is not None:
        row, sign = above
        constraints.append(
            {
                "type": "ineq",
                "fun": lambda z: sign * measured.f(z)[[row]],
                "jac": lambda z: sign * measured.slope(z)[[row]],
            }
        )
    low, high = measured.bounds
    z = np.clip(start[measured.free] / measured.size, low, high)
    result = minimize(
        objective,
        z,
        jac=gradient,
        bounds=list(zip(low, high, strict=True)),
        constraints=constraints,
        method="SLSQP",
        options={"maxiter": ITERATIONS, "ftol": 1e-10},
    )
    x = measured.point(result.x)
    return solve(measured.system, [x], [int(i) for i in measured.free], rows)
