"""Watches whether a flight stays where the aircraft's own documentation trusts the model (`trusted` of its companion).

A model has no opinion on its own limits: a wing without a stall flies at any incidence. What the watch sees ends no
flight and changes none; it becomes a warning in the summary.
"""

from __future__ import annotations

import numpy as np

from uavftc.aircraft.definition import Trusted

_SIGNALS = (  # key of the companion, field of the row, factor to the key's unit, what it is called, unit
    ("alpha_deg", "alpha", 180.0 / np.pi, "angle of attack", "deg"),
    ("beta_deg", "beta", 180.0 / np.pi, "sideslip", "deg"),
    ("airspeed_mps", "airspeed", 1.0, "airspeed", "m/s"),
)


class TrustedRange:
    """A recorder that keeps, for each range, when it was first left and the value furthest outside with its time.

    Parameters
    ----------
    trusted
        The ranges; None is not watched. Signals that a plant lacks are nan and never outside.
    """

    def __init__(self, trusted: Trusted) -> None:
        self._ranges = [(row, *bounds) for row in _SIGNALS if (bounds := getattr(trusted, row[0])) is not None]
        self._first: dict[str, float] = {}
        self._furthest: dict[str, tuple[float, float, float]] = {}  # distance outside, value, time

    def take(self, records: np.ndarray) -> None:
        """Look at the next rows, shape (n,), dtype `signals.ROW`."""
        for (key, field, factor, _, _), low, high in self._ranges:
            value = factor * records[field]
            outside = np.nan_to_num(np.maximum(low - value, value - high), nan=-np.inf)
            if not len(outside) or not (outside > 0.0).any():
                continue
            self._first.setdefault(key, float(records["t"][np.argmax(outside > 0.0)]))
            k = int(np.argmax(outside))
            if outside[k] > self._furthest.get(key, (0.0,))[0]:
                self._furthest[key] = (float(outside[k]), float(value[k]), float(records["t"][k]))

    def remarks(self) -> tuple[str, ...]:
        """Return one line for each range that was left."""
        lines = []
        for (key, _, _, name, unit), low, high in self._ranges:
            if key in self._furthest:
                _, value, at = self._furthest[key]
                lines.append(
                    f"{name} outside what the aircraft's documentation trusts, {low:g} to {high:g} {unit}, from "
                    f"t = {self._first[key]:g} s on; furthest {value:.2f} {unit} at t = {at:g} s"
                )
        return tuple(lines)
