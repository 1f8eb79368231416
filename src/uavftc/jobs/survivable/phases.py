"""The phases of a scenario: the stretches between the edges of its windows, and what is looked at in each.

In a phase the same faults, damage and disturbances act throughout. What changes within it (a signal of t, a drift, a
surface that runs) is looked at at the samples where it is extreme: the first and the last, and those at which the
reference, or an end of what an effector reaches, is least or greatest.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.actuators import CHAIN
from uavftc.actuators.at_rest import Reach, Rest, acting, reaches
from uavftc.config.values import key_text
from uavftc.core.given import Given
from uavftc.core.kinematics import body_rates
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight.build import Flight
from uavftc.plants.schedule import row_at
from uavftc.scenario.checks import damage_of, entries
from uavftc.scenario.schema import Scenario

SAMPLES = 400
"""Of a phase, at most: enough for an oscillation of 10 Hz in 20 s."""
ALIKE = 1e-9
"""rad: references and reaches nearer than this are one."""


class Phase(NamedTuple):
    """A stretch of the flight in which the same entries act."""

    start_s: float
    end_s: float
    first: int
    """Row at which it begins."""
    last: int
    """Its last row."""
    active: tuple[tuple[str, Any], ...]
    """What acts: the key of each fault and damage, and the entry."""

    @property
    def faults(self) -> list[Any]:
        """Those that are faults, of surfaces and of engines."""
        return [entry for key, entry in self.active if key.startswith("faults")]

    @property
    def damage(self) -> list[Any]:
        """Those that are damage."""
        return [entry for key, entry in self.active if key.startswith("damage")]


class Case(NamedTuple):
    """What is asked at one moment of a phase."""

    t: float
    """s."""
    bank: float
    """Reference, rad; as is the pitch."""
    pitch: float
    turn: float
    """Rate at which the reference turns, rad/s."""
    reach: Reach
    """Where the effectors can be."""


def phases_of(scenario: Scenario) -> list[Phase]:
    """Return the phases of a scenario, in their order."""
    named = [(key_text(key), entry) for key, _, entry in entries(scenario) if key[0] == "faults"]
    named += [(key_text(key), entry) for key, entry in damage_of(scenario)]
    windows = [entry for _, entry in named]
    windows += [entry for key, effect, entry in entries(scenario) if {"d1", "d2"} & set(getattr(effect, "FIELDS", ()))]
    end, rate = scenario.duration_s, scenario.controller.rate_hz
    edges = {0.0, *(edge for entry in windows for edge in (entry.start_s, entry.end_s) if edge is not None)}
    inside = [edge for edge in sorted(edges) if edge < end]
    found = []
    for start, stop in zip(inside, [*inside[1:], end], strict=True):
        first = row_at(start, rate)
        last = scenario.steps if stop == end else row_at(stop, rate) - 1
        if first <= last:  # else no sample is in it
            active = tuple((key, entry) for key, entry in named if entry in acting([entry], start))
            found.append(Phase(start, stop, first, last, active))
    return found


class Sampled(NamedTuple):
    """What the scenario prescribes in a phase, at N samples."""

    t: np.ndarray
    """Shape (N,), s."""
    attitude: np.ndarray
    """Reference, shape (N, 3), rad."""
    turn: np.ndarray
    """Rate of the reference of the heading, shape (N,), rad/s."""
    d1: np.ndarray
    """Shape (N, 3), rad/s."""
    d2: np.ndarray
    """Shape (N, 3), rad/s^2."""


def sampled(flight: Flight, phase: Phase) -> Sampled:
    """Return what is prescribed in a phase, at `SAMPLES` of its samples or all."""
    rate = flight.scenario.controller.rate_hz
    rows = np.unique(np.linspace(phase.first, phase.last, SAMPLES).round().astype(int))
    n = len(flight.layout.names)
    constant = flight.scenario.reference.psi_deg.constant is not None
    found = []
    for row in rows.tolist():
        records = as_records(empty_rows(2, n))
        flight.inputs.fill(records, row)
        now, later = records
        turn = 0.0 if constant else float(later["x1_c"][2] - now["x1_c"][2]) * rate
        found.append((row / rate, now["x1_c"].copy(), turn, now["d1"].copy(), now["d2"].copy()))
    return Sampled(*map(np.array, zip(*found, strict=True)))


def rates_of(attitude: np.ndarray, turn: float, d1: np.ndarray) -> np.ndarray:
    """Return the body rates, shape (3,), rad/s, that hold bank and pitch and turn at a rate in spite of d1."""
    return np.array(body_rates(attitude, np.array([0.0, 0.0, turn]) - d1))


def cases_of(scenario: Scenario, given: Given, seen: Sampled, before: Callable[[float], np.ndarray]) -> list[Case]:
    """Return what is asked in a phase: each different case once.

    `before(start_s)` is where the effectors were when a fault began, shape (n,), rad about trim.
    """
    every = [reaches(CHAIN, scenario, given, Rest(float(t), before)) for t in seen.t]
    chosen = {0, len(seen.t) - 1}
    for line in (seen.attitude[:, 0], seen.attitude[:, 1], seen.turn):
        chosen |= _extremes(line)
    ends = np.array([[np.concatenate([one.low, one.high]) for one in made] for made in every])  # (N, variants, 2 n)
    for line in ends.reshape(len(seen.t), -1).T:
        if np.isfinite(line).all():
            chosen |= _extremes(line)
    found: list[Case] = []
    known = set()
    for k in sorted(chosen):
        for reach in every[k]:
            bank, pitch = map(float, seen.attitude[k, :2])
            case = Case(float(seen.t[k]), bank, pitch, float(seen.turn[k]), reach)
            mark = _mark(case)
            if mark not in known:
                known.add(mark)
                found.append(case)
    return found


def _extremes(line: np.ndarray) -> set[int]:
    if np.ptp(line) <= ALIKE:
        return set()
    return {int(np.argmin(line)), int(np.argmax(line))}


def _mark(case: Case) -> bytes:
    reach = case.reach
    numbers = [np.array([case.bank, case.pitch, case.turn]), reach.low, reach.high, reach.by_alpha, reach.by_beta]
    mark: np.ndarray = np.round(np.concatenate(numbers) / ALIKE)
    return mark.tobytes()


def part_of(whole: Reach, free: Reach, share: float) -> Reach:
    """Return what is reached where a fault is only a share of itself, 0..1.

    A surface that is held is held at the share of its deflection about trim; of any other the ends are moved from those
    without the fault, `free`, to those with it.
    """
    low, high = (
        np.where(whole.held, share * there, np.where(there == here, here, _between(here, there, share)))
        for here, there in ((free.low, whole.low), (free.high, whole.high))
    )
    if share == 0.0:  # held at trim by a fault that is none
        low, high = np.where(whole.held, free.low, low), np.where(whole.held, free.high, high)
    return Reach(low, high, share * whole.by_alpha, share * whole.by_beta, whole.held & (share > 0.0))


def _between(here: np.ndarray, there: np.ndarray, share: float) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.asarray(here + share * (there - here))


def unfaulted(scenario: Scenario, given: Given) -> Reach:
    """Return where the effectors can be without any fault and damage."""
    whole = given._replace(faults=(), damage=())
    (found,) = reaches(CHAIN, scenario.model_copy(update={"faults": (), "damage": ()}), whole, Rest(0.0, _nowhere))
    return found


def _nowhere(_start_s: float) -> np.ndarray:
    raise AssertionError("no fault, and so nothing before it")


def words_of(active: Sequence[tuple[str, Any]]) -> list[str]:
    """Return in words what acts in a phase, one text each."""
    found = []
    for key, entry in active:
        if key.startswith("damage"):
            found.append(f"{key}: {entry.name or 'damage'}")
        else:
            on = entry.surface if hasattr(entry, "surface") else f"engine {entry.engine}"
            found.append(f"{key}: {on}, {' '.join(entry.label.split())}")
    return found
