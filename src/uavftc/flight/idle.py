"""Faults that did nothing: those that a flight ended before, and those that changed no deflection."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavftc.actuators import CHAIN, effectiveness, intermittent
from uavftc.actuators.servo import LEAST_RAD, farthest
from uavftc.config.values import key_text, window_of
from uavftc.flight.build import Flight
from uavftc.scenario.checks import entries

OF_SERVO = {effect.FAULT: effect for effect in CHAIN if hasattr(effect, "FAULT")}
"""The laws that a kind of fault changes a parameter of."""


class Idle:
    """Watches what eq. (6) changes while a flight is flown; a recorder. The other faults know how far they moved."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._entries = [
            (i, fault) for i, fault in enumerate(flight.scenario.faults) if isinstance(fault, effectiveness.Config)
        ]
        self._changed = {i: 0.0 for i, _ in self._entries}

    def take(self, records: np.ndarray) -> None:
        """Look at the next rows."""
        for i, fault in self._entries:
            part = records["effectors"][window_of(fault, records["t"])]
            if len(part) and self._changed[i] <= LEAST_RAD:
                members = part[:, list(self._flight.layout.targets[fault.surface])]
                change = np.abs((1.0 - members["effectiveness"]) * members["command"]) + np.abs(members["bias"])
                self._changed[i] = float(np.max(change, initial=0.0))

    def remarks(self, ended_s: float) -> tuple[str, ...]:
        """Return what is worth a warning after a flight that ended at `ended_s`, one line each."""
        lines = []
        duration = self._flight.scenario.duration_s
        places: dict[type, int] = {}
        for key, _, entry in entries(self._flight.scenario):
            if key[0] != "faults":
                continue
            place = places[type(entry)] = places.get(type(entry), -1) + 1
            if ended_s < entry.start_s <= duration:
                lines.append(f"{key_text(key)}: never began; the flight ended at {ended_s:g} s")
            elif entry.start_s <= ended_s:
                moved = self._moved(int(key[1]), entry, place)
                if moved is not None and moved <= LEAST_RAD:
                    what = f"changed nothing: the {entry.surface} did what it would have done without it"
                    lines.append(f"{key_text(key)}: {what}")
        return tuple(lines)

    def _moved(self, i: int, entry: Any, place: int) -> float | None:
        """Return how far a fault moved its surfaces, rad; None where nobody knows."""
        if i in self._changed:
            return self._changed[i]
        program = self._flight.program
        if (servo := OF_SERVO.get(type(entry))) is not None:
            if servo.stage.name not in program.names:  # too small a change for a number: 5e-324 deg
                return 0.0
            return farthest(program[servo.stage.name], servo.FIRST, type(entry), i, self._flight.given)
        name = f"{entry.kind} {place}"
        if name not in program.names:
            return None
        state = program[name].state
        if isinstance(entry, intermittent.Config):
            return float(state[:, intermittent.MOST].max())
        return float(state["most"].max()) if "most" in (state.dtype.names or ()) else None
