"""What JSBSim is told once, at a given row of a flight: an engine that fails, a mass that is lost.

    Event(row, property, value)

is written before the frame that begins at t_row, after the state at t_row was read: row k of the history still has the
vehicle as it was at t_k, and the forces from t_k on know of it. `value` is a number, or the name of a property whose
value at that moment is written (a throttle that stays where it is). Rows count from the start of the flight, and an
event before the first row is written there. Events of one row are written in their order.

The plant splits its loop at the rows of its events (`JSBSimPlant.run`): between two events nothing is written, and a
flight without any runs the loop that it always ran. A flight that `flight.numerical` flies again at finer steps is
given the same events: they are made from the scenario, in `flight.build.make_plant`, as `Told`.

What an event writes to may have to be put into the aircraft first: `copy.Change`, given to `JSBSimPlant` next to the
events. `row_at` turns the edge of a window [start_s, end_s) into a row, as `values.window_of` does for signals.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import jsbsim

from uavftc.plants.jsbsim.copy import Change
from uavftc.plants.jsbsim.engines import has
from uavftc.plants.jsbsim.writer import Getter, Setter
from uavftc.plants.schedule import row_at

__all__ = ["Event", "Schedule", "Told", "existing", "row_at"]


class Event(NamedTuple):
    """One property written once."""

    row: int
    """Of the flight, from 0: before the frame that begins at t_row."""
    property: str
    value: float | str
    """A number, or the property whose value at that moment is written."""
    where_it_exists: bool = False
    """Whether an aircraft without the property is left alone."""


def _nothing(_fdm: jsbsim.FGFDMExec) -> Sequence[Event]:
    return ()


def _as_it_is(_fdm: jsbsim.FGFDMExec) -> None:
    pass


class Told(NamedTuple):
    """What a fault, damage or uncertainty tells JSBSim, and what the aircraft must have for it."""

    events: tuple[Event, ...] = ()
    additions: tuple[Change, ...] = ()
    at_start: Callable[[jsbsim.FGFDMExec], Sequence[Event]] = _nothing
    """Given the aircraft at its start, frozen at the trim: prepares what it must, and returns further events."""
    settled: Callable[[jsbsim.FGFDMExec], None] = _as_it_is
    """Given the aircraft at the nominal trim, still frozen and settled: makes it the vehicle that flies."""


def existing(fdm: jsbsim.FGFDMExec, name: str) -> jsbsim.FGPropertyNode:
    """Return a property that exists.

    Raises
    ------
    KeyError
        If it does not; JSBSim would create it silently at the first write.
    """
    found = fdm.get_property_manager().get_node(name)
    if found is None:
        raise KeyError(name)
    return found


class Schedule:
    """The events of one flight, bound to its JSBSim; each is written once.

    Raises
    ------
    KeyError
        If a property does not exist.
    """

    def __init__(self, fdm: jsbsim.FGFDMExec, events: Sequence[Event]) -> None:
        self._bound: list[tuple[int, Setter, float | Getter]] = []
        for row, name, value, optional in sorted(events, key=lambda event: event.row):  # stable: in order within a row
            if optional and not has(fdm, name):
                continue
            of = existing(fdm, value).get_double_value if isinstance(value, str) else float(value)
            self._bound.append((row, existing(fdm, name).set_double_value, of))
        self._next = 0

    @property
    def row(self) -> float:
        """Row of the next event; infinite after the last."""
        return self._bound[self._next][0] if self._next < len(self._bound) else math.inf

    def write(self, row: int) -> bool:
        """Write all events up to this row that were not written yet; return whether there were any."""
        first = self._next
        while self.row <= row:
            _, write, value = self._bound[self._next]
            write(value if isinstance(value, float) else value())
            self._next += 1
        return self._next > first
