"""The 1-cosine gust of airworthiness codes (CS-23.333(c), MIL-F-8785C 3.7.1.3), with an optional hold."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from uavftc.config.labels import parts
from uavftc.config.values import Model, NonNegative, Number, Positive
from uavftc.core.layout import Targets
from uavftc.environment import air

ENTRY_OF = "disturbances"
FIELDS, REFUSED_ON = air.FIELDS, air.REFUSED_ON


class Config(Model):
    """A 1-cosine gust: rises over `ramp_s`, holds `hold_s`, falls over `ramp_s`; peak velocity of the air, m/s."""

    kind: Literal["gust"] = "gust"
    start_s: NonNegative = 0.0
    """beginning of the gust"""
    ramp_s: Positive
    """time in which it rises, and in which it falls"""
    hold_s: NonNegative = 0.0
    """time for which it holds its peak"""
    north_mps: Number = 0.0
    """peak velocity of the air to the north"""
    east_mps: Number = 0.0
    """to the east"""
    down_mps: Number = 0.0
    """down"""

    remedies: ClassVar[dict[str, str]] = {"end_s": "remove it: a gust ends by itself, at start_s + 2*ramp_s + hold_s"}

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        said = parts({"north": self.north_mps, "east": self.east_mps, "down": self.down_mps}, "m/s")
        return f"gust, {said}"

    @property
    def end_s(self) -> float:
        """The time at which the air is still again, s."""
        return self.start_s + 2 * self.ramp_s + self.hold_s


def one_minus_cosine(t: np.ndarray, *, start: float, ramp: float, hold: float) -> np.ndarray:
    """Return the profile of a gust of unit peak at the times t, s, same shape.

    It rises as (1 - cos(pi (t - start) / ramp)) / 2 over `ramp` s, holds for `hold` s and falls as it rose.
    """
    tau = np.asarray(t, dtype=float) - start
    fall = tau - ramp - hold
    phase = np.where(tau < ramp, tau, np.where(fall < 0.0, ramp, ramp - fall)) / ramp
    return 0.5 * (1.0 - np.cos(np.pi * np.clip(phase, 0.0, 1.0)))


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Add it to wind_n, m/s, at the times t, s, of the window."""
    profile = one_minus_cosine(t, start=entry.start_s, ramp=entry.ramp_s, hold=entry.hold_s)
    records["wind_n"] += profile[:, None] * (entry.north_mps, entry.east_mps, entry.down_mps)
