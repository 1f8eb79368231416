"""The analytic flight against a general solver of ordinary differential equations on the same closed loop."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from uavftc.analysis.metrics import INTEGRALS, metrics_of
from uavftc.flight.build import build_flight
from uavftc.jobs.bench import continuous
from uavftc.jobs.bench.flights import flown, scenario
from uavftc.jobs.bench.loop import closed_loop
from uavftc.jobs.bench.measure import Figure, Job, NotMeasuredError, alternately, of, ratios, timed

SOLVERS: dict[str, tuple[str, float, float]] = {
    "LSODA": ("LSODA", 1e-3, 1e-6),  # solve_ivp's own tolerances, rtol and atol
    "Radau": ("Radau", 1e-3, 1e-6),
    "Radau_loose": ("Radau", 1e-3, 1e-5),  # steps over the oscillation of the adaptation instead of resolving it
}
ALLOWED = 0.02  # relative difference of the integral metrics


def analytic_over_solve_ivp(rounds: int) -> dict[str, Figure]:
    """Time of solve_ivp on scenario 2's continuous loop over that of our whole flight, at the same metrics."""
    return {name: _over_flight(*given, rounds) for name, given in SOLVERS.items()}


def _over_flight(method: str, rtol: float, atol: float, rounds: int) -> Figure:
    solve = functools.partial(solve_ivp, method=method, rtol=rtol, atol=atol, **_problem())
    solution = solve()
    if not solution.success:
        return Figure([], reason=f"solve_ivp: {solution.message}")
    difference = largest_difference(solution.y)
    if difference > ALLOWED:
        return Figure([], reason=f"its metrics differ from ours by {100.0 * difference:.1f} %")
    job: Job = lambda: timed(solve)  # noqa: E731
    try:
        # the solution above has compiled and warmed everything of the solver's
        solver, ours = alternately(
            rounds, job, _warm(closed_loop(scenario("scenario2", plant="analytic"))), warm_up=False
        )
    except NotMeasuredError as reason:
        return Figure([], reason=str(reason))
    details = {
        "largest_difference": difference,
        "rtol": rtol,
        "atol": atol,
        "evaluations": int(solution.nfev),
        "solve_ivp_s": of(solver),
        "flight_ms": of([1e3 * s for s in ours]),
    }
    return Figure(ratios(solver, ours), details)


def _warm(job: Job) -> Job:
    """Return the job done twice and measured the second time: after seconds of other work its code is cold."""

    def twice() -> float:
        job()
        return job()

    return twice


def _problem() -> dict[str, Any]:
    records = flown("scenario2", "analytic")
    flight = build_flight(scenario("scenario2", plant="analytic"))
    return {
        "fun": continuous.right_hand_side,
        "t_span": (0.0, float(records["t"][-1])),
        "y0": continuous.start(records["x1"][0]),
        "t_eval": records["t"],
        "args": (continuous.loop_of(flight, records["x1_c"][0]),),
    }


def largest_difference(y: np.ndarray) -> float:
    """Return the largest relative difference in the twelve integral metrics between a solution, (51, n), and ours."""
    ours = flown("scenario2", "analytic")
    theirs = ours.copy()
    theirs["x1"] = y[:3].T
    a, b = metrics_of(theirs), metrics_of(ours)
    return max(abs(float(a[axis][m] or 0.0) / float(b[axis][m] or np.nan) - 1.0) for axis in a for m in INTEGRALS)
