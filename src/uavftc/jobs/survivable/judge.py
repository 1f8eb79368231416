"""Whether a case has a steady state, by how much, and where it has none, what stands in the way and what is near.

Levels, from the best:

    steady     all six accelerations are zero at the reference: attitude, path and airspeed hold
    attitude   moments, side force and lift balance: attitude, incidence and sideslip hold; the airspeed does not
    moments    at some incidence and sideslip the moments balance, at none of these the forces: it holds for moments
    none       no incidence and sideslip at which the moments balance

The first two are a yes: of the attitude, which is what the controllers hold. A steady state within a tolerance of the
reference counts as one at it, and the difference is given: of bank and pitch, and of the heading in the time that the
phase lasts, so that a slow turn is within it for a short one. On the rotational model there are moments only, and their
balance is `steady`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from uavftc.analysis.attainable import extremes, kept, left, share_of
from uavftc.analysis.equilibrium import Found, System, differences, least, nearest, reach, solve
from uavftc.jobs.survivable.phases import Case
from uavftc.jobs.survivable.vehicle import ATTITUDE, EVERY, FORWARD, MOMENTS, Vehicle
from uavftc.plants.interface import State

LEVELS = ("steady", "attitude", "moments", "none")
HELD = LEVELS[:2]
FLOWS = ((0.0, 0.15), (0.0, -0.15), (0.1, 0.0), (-0.08, 0.0), (0.0, 0.4), (0.0, -0.4), (0.1, 0.3), (0.1, -0.3))
"""Incidence and sideslip, rad, added to those of the first start to make the others."""


WAY_RAD = 1.0
"""What a surface without stops counts as."""


class Judged(NamedTuple):
    """One case, as judged."""

    case: Case
    level: str
    at: Found
    """The steady state; where there is none, the least sum of squares that was found at the reference."""
    system: System
    disturbance: float
    """Largest share of what the surfaces can do that a disturbance takes, at the steady state; nan without one."""
    worst: np.ndarray
    """The disturbance that does, about its mean, shape (3,), rad/s^2."""

    @property
    def holds(self) -> bool:
        """Whether there is a steady state, and enough left for the disturbances."""
        return self.level in HELD and not self.disturbance > 1.0


class Question(NamedTuple):
    """A case on a vehicle, and how near a steady state must be."""

    vehicle: Vehicle
    case: Case
    loads: np.ndarray
    """Of the disturbances, shape (N, 3), rad/s^2."""
    within: float
    """rad, of bank and pitch, and of the heading as long as it lasts."""
    lasts: float
    """s."""

    @property
    def system(self) -> System:
        """Its equations, with the mean of the disturbances."""
        return self.vehicle.with_reach(self.case.reach, self.loads.mean(axis=0))

    @property
    def free(self) -> list[int]:
        """Unknowns that are free at the reference, the throttle included."""
        flow = [State.ALPHA, State.BETA] if self.vehicle.has_flow else []
        throttle = [State.THROTTLE] if self.vehicle.powered else []
        return [*flow, *throttle, *self.vehicle.free_surfaces(self.case.reach)]

    def start(self, x: np.ndarray | None = None, airspeed: float | None = None) -> np.ndarray:
        """Return a start at the reference, by default from the trim."""
        made = np.array(self.vehicle.trim if x is None else x)
        made[[State.BANK, State.PITCH, State.TURN]] = self.case.bank, self.case.pitch, self.case.turn
        if airspeed is not None:
            made[State.AIRSPEED] = airspeed
        made[State.COUNT :] = np.clip(made[State.COUNT :], self.case.reach.low, self.case.reach.high)
        return made

    def starts(self, first: np.ndarray) -> list[np.ndarray]:
        """Return several starts, the first among them."""
        if not self.vehicle.has_flow:
            return [first]
        found = [first]
        for alpha, beta in FLOWS:
            moved = first.copy()
            moved[State.ALPHA], moved[State.BETA] = first[State.ALPHA] + alpha, first[State.BETA] + beta
            found.append(moved)
        return found


def judge(question: Question, hints: Sequence[np.ndarray] = (), *, thorough: bool = True) -> Judged:
    """Return what comes of a case.

    Parameters
    ----------
    hints
        Unknowns near which a steady state may be.
    thorough
        Whether many starts are tried before there is none.
    """
    vehicle, case, system, free = question.vehicle, question.case, question.system, question.free
    first = [question.start(x, float(x[State.AIRSPEED])) for x in (*hints, vehicle.trim)]
    at = solve(system, first[:1], free, vehicle.rows)
    if at.met:
        return _settled(question, system, "steady", at)
    every = question.starts(first[0]) if thorough else []
    level, at = _attitude(question, system, [*first, at.x, *every]) if vehicle.has_flow else ("none", at)
    if level in HELD:
        return _settled(question, system, level, at)
    if vehicle.has_flow and thorough:
        flow = [i for i in free if i != State.THROTTLE]
        moments = solve(system, [at.x, *every], flow, MOMENTS)
        if moments.met:
            least_force = solve(system, [moments.x], free, ATTITUDE)
            return Judged(case, "moments", least_force, system, np.nan, np.zeros(3))
    return Judged(case, "none", at, system, np.nan, np.zeros(3))


def _attitude(question: Question, system: System, starts: Sequence[np.ndarray]) -> tuple[str, Found]:
    """Return the level where the attitude may be off by the tolerance, and the state nearest to the reference."""
    case, free, goals = question.case, question.free, [State.BANK, State.PITCH, State.TURN]
    wanted = np.array([case.bank, case.pitch, case.turn])
    off = question.within * np.array([1.0, 1.0, 2.0 / question.lasts])  # a heading from one end to the other
    loose = system
    for i, at, most in zip(goals, wanted, off, strict=True):
        loose = loose.bounded(i, at - most, at + most)
    found = solve(loose, starts, [*free, *goals], ATTITUDE)
    if not found.met:
        return "none", solve(system, [question.start(found.x, found.x[State.AIRSPEED])], free, ATTITUDE)
    exact = solve(system, [question.start(found.x, found.x[State.AIRSPEED])], free, ATTITUDE)
    if exact.met:
        if not question.vehicle.powered:
            return "attitude", exact
        steady = solve(system, [_throttled(question, exact), exact.x], free, EVERY)
        return ("steady", steady) if steady.met else ("attitude", _nearest_thrust(system, exact, free))
    nearer = _nearest_of(loose, found, free, ATTITUDE, wanted, off)
    steady = solve(loose, [_throttled(question, nearer), nearer.x], [*free, *goals], EVERY)
    return ("steady", _nearest_of(loose, steady, free, EVERY, wanted, off)) if steady.met else ("attitude", nearer)


def _nearest_of(
    loose: System, found: Found, free: Sequence[int], rows: Sequence[int], wanted: np.ndarray, off: np.ndarray
) -> Found:
    """Return, of what meets the equations near `found`, the nearest to a bank, pitch and turn, counted by `off`."""
    goals = [State.BANK, State.PITCH, State.TURN]
    size = loose.size.copy()
    size[goals] = off
    best = nearest(loose._replace(size=size), found.x, [*free, *goals], rows, goals, wanted)
    return best if best.met else found


def _throttled(question: Question, found: Found) -> np.ndarray:
    """Return what was found with the throttle of the trim, away from its ends."""
    start = found.x.copy()
    start[State.THROTTLE] = question.vehicle.trim[State.THROTTLE]
    return start


def _nearest_thrust(system: System, exact: Found, free: Sequence[int]) -> Found:
    """Return, of no throttle and full throttle, the state in which the airspeed changes least."""
    others = [i for i in free if i != State.THROTTLE]
    found = [exact]
    for end in (system.low, system.high):
        start = exact.x.copy()
        start[State.THROTTLE] = end[State.THROTTLE]
        found.append(solve(system, [start], others, ATTITUDE))
    return min((one for one in found if one.met), key=lambda one: abs(one.residual[FORWARD]))


def _settled(question: Question, system: System, level: str, at: Found) -> Judged:
    """Return a case with a steady state, and what its disturbances take of the surfaces there."""
    away = question.loads - question.loads.mean(axis=0)
    if not np.any(np.ptp(question.loads, axis=0) > 1e-12):
        return Judged(question.case, level, at, system, np.nan, np.zeros(3))
    spare = spare_of(question, system, at)
    demands = extremes(away)
    shares = [share_of(spare.B[spare.kept], spare.low, spare.high, -demand[spare.kept]) for demand in demands]
    k = int(np.argmax(shares))
    return Judged(question.case, level, at, system, float(shares[k]), demands[k])


class Spare(NamedTuple):
    """What the surfaces have left at a state."""

    B: np.ndarray
    """Angular acceleration per deflection of those that a command moves, shape (3, n), 1/s^2 per rad."""
    low: np.ndarray
    """Ways that they have, shape (n,), rad, <= 0."""
    high: np.ndarray
    """>= 0."""
    kept: list[int]
    """Axes that they can still move apart from each other."""
    size: np.ndarray
    """What all surfaces together, with their stops alone, could do about each axis, shape (3,), rad/s^2."""

    def authority(self) -> np.ndarray:
        """Return the angular acceleration left about each axis to either side, shape (3, 2), rad/s^2.

        With the other axes at zero, but for those that are lost: of these nothing is left.
        """
        found = np.zeros((3, 2))
        if self.kept:
            found[self.kept] = left(self.B[self.kept], self.low, self.high)
        return found


def spare_of(question: Question, system: System, at: Found) -> Spare:
    """Return what the surfaces have left at a state, as linear in their deflections."""
    vehicle, n = question.vehicle, len(question.case.reach.low)
    places = vehicle.free_surfaces(question.case.reach)
    every = differences(system, at.x, [State.COUNT + j for j in range(n)])[list(MOMENTS)]
    B = every[:, [place - State.COUNT for place in places]]
    ways = np.minimum(np.ptp(vehicle.stops, axis=1), WAY_RAD)
    own = np.minimum(system.high[places] - system.low[places], WAY_RAD)
    size = np.abs(every) @ ways
    low = np.minimum(system.low[places] - at.x[places], 0.0)
    high = np.maximum(system.high[places] - at.x[places], 0.0)
    return Spare(B, low, high, kept(B * own, size), size)


class Unmet(NamedTuple):
    """An equation that stands in the way: all others can be met, and this much is left of it at least."""

    row: int
    residual: float
    """m/s^2 or rad/s^2."""
    alone: bool
    """Whether it is the only one; else the equations with the largest share of what is left together."""


def unmet(question: Question, judged: Judged) -> list[Unmet]:
    """Return which equations stand in the way at the reference, the one of which least is left first."""
    vehicle, system, free = question.vehicle, judged.system, question.free
    found = []
    for row in vehicle.attitude_rows:
        others = [r for r in vehicle.attitude_rows if r != row]
        start = solve(system, [*question.starts(question.start())[:3], judged.at.x], free, others)
        if start.met:
            best = least(system, start.x, free, others, row)
            best = best if best.met and abs(best.residual[row]) <= abs(start.residual[row]) else start
            found.append(Unmet(row, float(best.residual[row]), alone=True))
    if found:
        return sorted(found, key=lambda one: abs(one.residual) / system.scale[one.row])
    size = np.abs(judged.at.residual / system.scale)
    rows = [r for r in vehicle.attitude_rows if size[r] > 0.1 * np.max(size[list(vehicle.attitude_rows)])]
    return [Unmet(r, float(judged.at.residual[r]), alone=False) for r in sorted(rows, key=lambda r: -size[r])]


INSTEAD = {
    "bank": (State.BANK,),
    "pitch": (State.PITCH,),
    "airspeed": (State.AIRSPEED,),
    "turn": (State.TURN,),
    "attitude": (State.BANK, State.PITCH),
}
"""What may be given up, and the unknowns that then are free."""


NEAR = 1e-3
"""Of the size of an unknown: how closely the nearest is found."""


def instead(question: Question, judged: Judged) -> dict[str, tuple[str, Found] | None]:
    """Return what could be held in place of the reference, by what is given up: the nearest, with its level.

    None of what was not found. Everything that is not given up is at the reference. Where the attitude holds and the
    airspeed does not, only what holds the airspeed counts.
    """
    vehicle, system, free = question.vehicle, judged.system, question.free
    if not vehicle.has_flow:
        return {}
    at = question.start(judged.at.x, float(vehicle.trim[State.AIRSPEED]))
    found: dict[str, tuple[str, Found] | None] = {}
    for name, goals in INSTEAD.items():
        wanted = at[list(goals)]
        unknowns, starts = [*free, *goals], [*question.starts(question.start())[:5], at]
        found[name] = None
        some = solve(system, starts, unknowns, ATTITUDE)
        if not some.met:
            continue
        steady = solve(system, [_throttled(question, some), some.x, starts[0]], unknowns, EVERY)
        if judged.level == "attitude" and not steady.met:
            continue
        level, rows, some = ("steady", EVERY, steady) if steady.met else ("attitude", ATTITUDE, some)
        tried = [some]
        if len(goals) == 1:
            size = float(system.size[goals[0]])
            ends = {"towards": float(wanted[0]), "step": size, "accuracy": NEAR * size}
            tried.append(reach(system, some.x, free, rows, goals[0], **ends))
        else:
            parts = [one for one in (found["bank"], found["pitch"]) if one is not None]
            tried += [one for reached, one in parts if level in (reached, "attitude")]
        best = min((one for one in tried if one.met), key=lambda one: _apart(system, one, goals, wanted))
        tried.append(nearest(system, best.x, unknowns, rows, goals, wanted))
        best = min((one for one in tried if one.met), key=lambda one: _apart(system, one, goals, wanted))
        found[name] = level, best
    return found


def _apart(system: System, found: Found, goals: Sequence[int], wanted: np.ndarray) -> float:
    return float(np.linalg.norm((found.x[list(goals)] - wanted) / system.size[list(goals)]))


SPAN_STEP = np.radians(6.0)
SPAN_ACCURACY = np.radians(0.4)
INWARDS = 0.9
"""Of the way of a hint from the reference: at the end itself too much is at its limit."""


def spans_of(
    question: Question, judged: Judged, hints: Sequence[np.ndarray], unknown: int
) -> list[tuple[Found, Found]]:
    """Return the states with the least and greatest bank or pitch that are reached from each of the hints.

    The other is at the reference and the airspeed that of the scenario; all is steady, incidence and sideslip in the
    range that the aircraft is trusted in. A range that was reached from a hint before counts once. The hints are those
    of a case that is nearly the same: how far it goes there is tried first.
    """
    guesses = [float(hint[unknown]) for hint in hints]
    reference = float(question.start()[unknown])
    steady = judged.level == "steady" and abs(judged.at.x[unknown] - reference) < SPAN_ACCURACY
    free, system = question.free, question.system
    for flow, (low, high) in question.vehicle.trusted.items():
        system = system.bounded(flow, max(low, float(system.low[flow])), min(high, float(system.high[flow])))
    found: list[tuple[Found, Found]] = []
    for hint in (judged.at.x, *hints):
        inner, outer = (question.start(hint, question.vehicle.trim[State.AIRSPEED]) for _ in range(2))
        inner[unknown] += INWARDS * (hint[unknown] - inner[unknown])
        outer[unknown] = hint[unknown]
        if any(_inside(one, float(inner[unknown]), unknown) for one in found):
            continue
        some = solve(system, [inner, outer], [*free, unknown], EVERY)
        if not some.met or any(_inside(one, float(some.x[unknown]), unknown) for one in found):
            continue
        at, accuracy = float(some.x[unknown]), SPAN_ACCURACY
        low, high = float(system.low[unknown]), float(system.high[unknown])
        if not steady:  # nothing is reached across the reference
            low, high = (low, max(at, reference)) if at < reference else (min(at, reference), high)
        least_one, greatest = (
            reach(system, some.x, free, EVERY, unknown, towards=end, step=SPAN_STEP, accuracy=accuracy, guess=guess)
            for end, guess in (
                (low, min((g for g in guesses if low < g < at), default=None)),
                (high, max((g for g in guesses if at < g < high), default=None)),
            )
        )
        found.append((least_one, greatest))
    return sorted(found, key=lambda one: float(one[0].x[unknown]))


def _inside(one: tuple[Found, Found], value: float, unknown: int) -> bool:
    low, high = (float(end.x[unknown]) for end in one)
    return low - 2.0 * SPAN_ACCURACY <= value <= high + 2.0 * SPAN_ACCURACY
