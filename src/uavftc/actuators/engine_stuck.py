"""A throttle that is stuck: on [start_s, end_s) it stays where it is, or where `at` says.

    position = at                              given: there at once
    position = that of the first sample of the window      left out

From the first sample at or after `end_s` it follows the controls of the aircraft again, at once.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from uavftc.actuators.engine import ON_JSBSIM, Change, EngineFault
from uavftc.config.values import NonNegative

ENTRY_OF = "faults"
REFUSED_ON = ON_JSBSIM


class Config(EngineFault):
    """An engine whose throttle is stuck on [start_s, end_s)."""

    kind: Literal["stuck"] = "stuck"
    """throttle stays where it is, or at `at`"""
    at: Annotated[NonNegative, Field(le=1)] | None = None
    """throttle position at which it stays, 0..1; `null` is where it is"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "throttle stuck" if self.at is None else f"throttle stuck at {self.at:g}"


def change(entry: Config) -> Change:
    """Return what it does to its engine."""
    return Change(gain=0.0, held=entry.at)
