"""What the laws of a servo share: whose keys an effector follows, and how a fault changes one of them for a time.

An effector follows the keys under its own name, else those under the name of a gang that it belongs to, else the common
ones. The common ones leave out an effector that the aircraft moves by a servo of its own: it is not doubled.

The numbers are those of each servo: a gang's weights do not scale them, and their signs turn its position limits.

A fault of the servo changes a key on [start_s, end_s), which begins with the first row at or after `start_s` and ends
with the first at or after `end_s`, also where a row has several plant steps. In its window the law compares what it
gives with what the servo's own value would give from the same memory, and keeps the largest difference: as long as
there is none, the two servos are one, so a difference of zero says that the fault did nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from uavftc.config.values import Model, Problem
from uavftc.core.given import Given
from uavftc.core.stage import Block, law

LEAST_RAD = 1e-12
"""What a fault moves a surface by to have done something."""


class Keys(Model):
    """Keys of a servo."""

    def named(self) -> Mapping[str, Keys | None]:
        """Return the keys given by the name of an effector or gang; None is a servo that does nothing."""
        return {}

    def problems(self) -> list[Problem]:
        """Return what is wrong with these keys together."""
        return []


class Servo(NamedTuple):
    """The servo of one effector."""

    keys: Any
    """What it follows; None where it does nothing."""
    sign: float
    """Of its deflection, per angle of the keys: 1 or -1."""


def servos(config: Keys, given: Given) -> list[Servo]:
    """Return the servo of each effector, in their order in a row."""
    named, gangs = config.named(), given.gangs
    found = []
    for j, name in enumerate(given.effectors):
        weights = given.mixing[j]
        sign = -1.0 if weights[np.argmax(weights != 0.0)] < 0.0 else 1.0  # as the first axis that it serves counts
        own = bool(given.servos) and bool(given.servos[j])
        gang = next((gang for gang, members in gangs.items() if name in members and gang in named), None)
        if name in named and name not in gangs:
            found.append(Servo(named[name], 1.0))
        elif gang is not None:
            found.append(Servo(named[gang], -1.0 if gangs[gang][name] < 0.0 else 1.0))
        else:
            found.append(Servo(None if own else config, sign))
    return found


class Schedule(NamedTuple):
    """A parameter of each effector in time, constant between switches."""

    switches: np.ndarray
    """Switches of each effector, shape (n,)."""
    table: np.ndarray
    """Their times, s, the values before, between and after them, and how far each value moved the servo from what the
    first one would have given, rad, from the first column on, shape (n, width)."""
    acts: np.ndarray
    """Whether it ever has another value than `off`, shape (n,)."""


def schedule(
    own: Sequence[float], off: float, kind: type, change: Callable[[float, Any], float], given: Given
) -> Schedule:
    """Return a parameter as the faults of a kind change it.

    Parameters
    ----------
    own, off
        Its value on each effector without a fault, and the value with which it does nothing.
    kind, change
        Of the faults, and change(own, fault) -> the value inside the window.
    given
        The flight.
    """
    lines: list[tuple[list[float], list[float]]] = [([], [value]) for value in own]
    for _, entry in _in_time(kind, given):
        for j in given.targets[entry.surface]:
            times, values = lines[j]
            times.append(entry.start_s)
            values.append(change(own[j], entry))
            if entry.end_s is not None:
                times.append(entry.end_s)
                values.append(own[j])
    count = np.array([len(times) for times, _ in lines])
    table = np.zeros((len(lines), 3 * int(count.max(initial=0)) + 2))
    for row, (times, values) in zip(table, lines, strict=True):
        row[: len(times) + len(values)] = [*times, *values]
    return Schedule(count, table, np.array([any(value != off for value in values) for _, values in lines]))


def _in_time(kind: type, given: Given) -> list[tuple[int, Any]]:
    return sorted(given.faults_of(kind), key=lambda item: item[1].start_s)


@law
def part_of(memory, first, count, t):
    """Return the place, among the values of a parameter whose switches begin at `first`, of that at the time t, s."""
    i = 0
    while i < count and t >= memory[first + i]:
        i += 1
    return i


@law
def value_of(memory, first, count, i):
    """Return the value of a parameter at a place; at 0 is the servo's own."""
    return memory[first + count + i]


@law
def moved_of(memory, first, count, i):
    """Return how far the value at a place has moved the servo, rad."""
    return memory[first + 2 * count + 1 + i]


@law
def note(memory, first, count, i, moved):
    """Keep how far the value at a place moved the servo, rad, where it is the farthest."""
    memory[first + 2 * count + 1 + i] = max(memory[first + 2 * count + 1 + i], abs(moved))


def farthest(block: Block, first: int, kind: type, fault: int, given: Given) -> float:
    """Return how far a fault of a servo moved any of its effectors, rad, as far as the flight is flown.

    Parameters
    ----------
    block, first
        Of the law that it changes, and where the switches begin in its memory.
    kind, fault
        Of the fault, and its place in the scenario's list.
    given
        The flight.
    """
    seen = [0] * len(given.effectors)
    found = 0.0
    for i, entry in _in_time(kind, given):
        for j in given.targets[entry.surface]:
            if i == fault:
                count = int(block.params["count"][j])
                found = max(found, float(block.state[j, first + 2 * count + 2 + seen[j]]))
            seen[j] += 1 if entry.end_s is None else 2
    return found
