"""A doublet of the roll acceleration: up for half of its length, down for the other half.

An example of a kind of disturbance in one file; it takes part by its place in `environment.KINDS`.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.config.values import Model, NonNegative, Number, Positive
from uavftc.core.layout import Targets

ENTRY_OF = "disturbances"
FIELDS = ("d2",)


class Config(Model):
    """A doublet of the roll acceleration, d2 of eq. (7)."""

    kind: Literal["doublet"] = "doublet"
    start_s: NonNegative = 0.0
    """beginning of the doublet"""
    length_s: Positive
    """length of the whole of it"""
    peak_degps2: Number
    """angular acceleration about the body x axis in its first half"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"doublet, {self.peak_degps2:g} deg/s^2"

    @property
    def end_s(self) -> float:
        """The time at which it is over, s."""
        return self.start_s + self.length_s


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Add it to d2, rad/s^2, at the times t, s, of the window."""
    first = t < entry.start_s + 0.5 * entry.length_s
    records["d2"][:, 0] += np.radians(np.where(first, entry.peak_degps2, -entry.peak_degps2))
