"""An engine of reduced power: on [start_s, end_s) its throttle does `power` of what it is set to.

    position = power x (position that the aircraft's own controls give)

The position is what is scaled: the power of an engine is in proportion to it only where its model says so, as that of
an electric motor. An autothrottle or airspeed hold opens the throttle further, at most to `power` of full throttle.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from uavftc.actuators.engine import ON_JSBSIM, Change, EngineFault
from uavftc.config.values import NonNegative

ENTRY_OF = "faults"
REFUSED_ON = ON_JSBSIM


class Config(EngineFault):
    """An engine of reduced power on [start_s, end_s)."""

    kind: Literal["reduced"] = "reduced"
    """throttle position is `power` of what it is set to"""
    power: Annotated[NonNegative, Field(le=1)]
    """throttle position over that without the fault, 0..1"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"throttle times {self.power:g}"


def change(entry: Config) -> Change:
    """Return what it does to its engine."""
    return Change(gain=entry.power)
