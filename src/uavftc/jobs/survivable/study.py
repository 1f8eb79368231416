"""A flight looked at phase by phase, and what one phase is at other airspeeds and at a share of its faults."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from uavftc.actuators.at_rest import Reach
from uavftc.flight.build import Flight
from uavftc.jobs.survivable.judge import LEVELS, Judged, Question, Spare, judge, spans_of, spare_of
from uavftc.jobs.survivable.phases import Case, Phase, Sampled, cases_of, part_of, phases_of, sampled, unfaulted
from uavftc.jobs.survivable.vehicle import Vehicle, vehicle_of
from uavftc.plants.interface import State

SPEEDS = 13
"""Airspeeds that are tried between the ends of the range."""
SHARES = np.concatenate([[0.0, 0.02, 0.05], np.linspace(0.1, 1.0, 10)])
HALVINGS = 7
"""Of the step between two shares, to find where a steady state ends."""

Told = Callable[[int], object]
"""Told of the work that is done, in parts of `Study.parts`."""


class Seen(NamedTuple):
    """A phase, as judged: its worst case."""

    phase: Phase
    question: Question
    judged: Judged
    spare: Spare | None
    """What the surfaces have left; None without a steady state."""
    clean: Question
    """The same asked of the vehicle without faults and damage."""
    clean_judged: Judged
    clean_spare: Spare | None
    cases: int
    """How many were judged."""

    @property
    def weakest(self) -> float:
        """Least share of the authority without faults that is left of any axis, 0 without a steady state."""
        if not self.judged.holds or self.spare is None or self.clean_spare is None:
            return 0.0
        return float(np.min(shares_of(self.spare, self.clean_spare)))


def shares_of(spare: Spare, clean: Spare) -> np.ndarray:
    """Return the authority left over that without faults, about each axis to either side, (3, 2); nan of none."""
    has, had = np.abs(spare.authority()), np.abs(clean.authority())
    with np.errstate(divide="ignore", invalid="ignore"):
        shares: np.ndarray = np.where(had > 0.0, np.where(np.isinf(had), 1.0, has / had), np.nan)
    return shares


class Study:
    """A flight that was built, and what is known of its phases so far.

    Parameters
    ----------
    flight
        As built; it is not flown.
    within
        How near to the reference a steady state must be, rad.
    """

    def __init__(self, flight: Flight, within: float) -> None:
        self.flight, self.within = flight, within
        self.phases = phases_of(flight.scenario)
        self._free = unfaulted(flight.scenario, flight.given)
        self._clean = vehicle_of(flight)
        self._before: list[tuple[float, np.ndarray, float]] = []
        """Of each phase that was judged: its end, s, the deflections at its end, rad about trim, and the throttle."""

    def look(self, phase: Phase) -> Seen:
        """Return a phase, as judged; the phases before it were looked at before, in their order."""
        flight, seen = self.flight, sampled(self.flight, phase)
        vehicle = self._vehicle(phase)
        cases = cases_of(flight.scenario, flight.given, seen, lambda start_s: self._at(start_s)[0])
        loads = vehicle.loads(seen)
        found: list[tuple[Question, Judged]] = []
        hints: list[np.ndarray] = []
        for case in cases:
            question = Question(vehicle, case, loads, self.within, phase.end_s - phase.start_s)
            judged = judge(question, hints[-1:])
            if judged.at.met:
                hints.append(judged.at.x)
            found.append((question, judged))
        question, judged = max(found, key=_badness)
        self._remember(phase, found[-1][1])
        clean = self._asked_of_clean(question, seen)
        clean_judged = judge(clean, hints[-1:])
        return Seen(
            phase,
            question,
            judged,
            spare_of(question, judged.system, judged.at) if judged.holds else None,
            clean,
            clean_judged,
            spare_of(clean, clean_judged.system, clean_judged.at) if clean_judged.at.met else None,
            len(cases),
        )

    def _vehicle(self, phase: Phase, share: float = 1.0) -> Vehicle:
        engines = [fault for fault in phase.faults if hasattr(fault, "engine")]
        throttles = [self._at(fault.start_s)[1] for fault in engines]
        if not phase.damage and not engines:
            return self._clean
        return vehicle_of(self.flight, phase.damage, engines, share=share, throttles=throttles)

    def _asked_of_clean(self, question: Question, seen: Sampled) -> Question:
        case = question.case._replace(reach=self._free)
        return question._replace(vehicle=self._clean, case=case, loads=self._clean.loads(seen))

    def _at(self, start_s: float) -> tuple[np.ndarray, float]:
        """Return deflections and throttle at the end of the phase before a time; those of the trim at the start."""
        for end, deflections, throttle in self._before:
            if abs(end - start_s) <= 1e-9:
                return deflections, throttle
        return np.zeros(len(self.flight.layout.names)), float(self._clean.trim[State.THROTTLE])

    def _remember(self, phase: Phase, judged: Judged) -> None:
        x, reach = judged.at.x, judged.case.reach
        moved = reach.at(x[State.COUNT :], float(x[State.ALPHA]), float(x[State.BETA]))
        self._before.append((phase.end_s, np.clip(moved, *self._clean.stops.T), float(x[State.THROTTLE])))

    def speeds(self, seen: Seen) -> list[tuple[float, Judged, Judged]]:
        """Return airspeeds, m/s, with what the case of a phase is at each, and what it is without faults."""
        vehicle = seen.question.vehicle
        low, high = vehicle.system.low[State.AIRSPEED], vehicle.system.high[State.AIRSPEED]
        here = float(vehicle.trim[State.AIRSPEED])
        tried = np.unique(np.append(np.linspace(low, high, SPEEDS), here))
        found: dict[float, tuple[Judged, Judged]] = {}
        ordered = [v for v in tried if v >= here], [v for v in tried[::-1] if v < here]
        for way in ordered:  # away from the scenario's airspeed, each from the one before
            hints = [[seen.judged.at.x], [seen.clean_judged.at.x]]
            for v in way:
                pair = []
                for question, hint in zip((seen.question, seen.clean), hints, strict=True):
                    start = hint[-1].copy()
                    start[State.AIRSPEED] = v
                    judged = judge(question, [start, _level(question, start)], thorough=False)
                    hint.append(judged.at.x if judged.at.met else start)
                    pair.append(judged)
                found[float(v)] = (pair[0], pair[1])
        return [(v, *found[v]) for v in sorted(found)]

    def severities(self, seen: Seen, told: Told = id) -> list[dict[str, Any]]:
        """Return what a phase is at shares of its faults and damage: one entry a share."""
        found = []
        hint = seen.clean_judged.at.x
        somewhere: dict[int, list[np.ndarray]] = {State.BANK: [], State.PITCH: []}
        for share in SHARES:
            question, judged = self._at_share(seen, float(share), hint)
            if judged.at.met:
                hint = judged.at.x
            spans: list[list[tuple[float, float]]] = []
            for unknown, before in somewhere.items():
                ends = spans_of(question, judged, before, unknown) if question.vehicle.has_flow else []
                spans.append([(float(low.x[unknown]), float(high.x[unknown])) for low, high in ends])
                somewhere[unknown] = [end.x for pair in ends for end in pair]
            spare = spare_of(question, judged.system, judged.at)
            found.append({"share": float(share), "judged": judged, "spare": spare, "bank": spans[0], "pitch": spans[1]})
            told(1)
        return found

    def ends_at(self, seen: Seen, swept: list[dict[str, Any]]) -> tuple[float, float] | None:
        """Return two shares of the faults between which the steady state ends first, or None where it does not."""
        broken = next((i for i, point in enumerate(swept) if not point["judged"].holds), None)
        if broken is None:
            return None
        if broken == 0:
            return 0.0, 0.0
        low, high = swept[broken - 1]["share"], swept[broken]["share"]
        hint = swept[broken - 1]["judged"].at.x
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            _, judged = self._at_share(seen, middle, hint)
            if judged.holds:
                low, hint = middle, judged.at.x
            else:
                high = middle
        return low, high

    def _at_share(self, seen: Seen, share: float, hint: np.ndarray) -> tuple[Question, Judged]:
        whole = seen.question
        reach: Reach = part_of(whole.case.reach, self._free, share)
        vehicle = self._vehicle(seen.phase, share) if share < 1.0 else whole.vehicle
        case: Case = whole.case._replace(reach=reach)
        loads = seen.clean.loads + share * (whole.loads - seen.clean.loads)
        question = whole._replace(vehicle=vehicle, case=case, loads=loads)
        return question, judge(question, [hint], thorough=False)


def _badness(pair: tuple[Question, Judged]) -> tuple[bool, int, float, float, float]:
    """Return what makes one case worse than another: level, disturbances, how far off it is, authority left."""
    question, judged = pair
    disturbance = -1.0 if np.isnan(judged.disturbance) else judged.disturbance
    off = question.start()[[State.BANK, State.PITCH, State.TURN]] - judged.at.x[[State.BANK, State.PITCH, State.TURN]]
    left = 0.0
    if judged.holds:
        spare = spare_of(question, judged.system, judged.at)
        left = float(np.min(np.abs(spare.authority()) / np.maximum(spare.size, 1e-12)[:, None]))
    return not judged.holds, LEVELS.index(judged.level), disturbance, round(float(np.max(np.abs(off))), 6), -left


def _level(question: Question, start: np.ndarray) -> np.ndarray:
    """Return a start with the incidence that carries the same lift at another airspeed."""
    trim = question.vehicle.trim
    made = start.copy()
    ratio = (trim[State.AIRSPEED] / start[State.AIRSPEED]) ** 2
    low, high = question.vehicle.system.low[State.ALPHA], question.vehicle.system.high[State.ALPHA]
    made[State.ALPHA] = np.clip(trim[State.ALPHA] + 0.08 * (ratio - 1.0), low, high)
    return made
