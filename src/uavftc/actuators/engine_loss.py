"""An engine that is lost: on [start_s, end_s) its throttle is 0, and it has neither fuel nor ignition.

    position = 0, running = 0, cutoff = 1, magnetos = 0      those that the engine has

At throttle 0 alone a piston engine or a turbine idles. The thrust falls to 0, or below to the drag of a propeller that
the air turns, once the revolutions have fallen; before the flight this is tried at the trim, and an engine that goes on
pulling is refused. From `end_s` on throttle, fuel and ignition are back; an engine too slow to start by itself then
stays off.
"""

from __future__ import annotations

from typing import Literal

from uavftc.actuators.engine import ON_JSBSIM, Change, EngineFault

ENTRY_OF = "faults"
REFUSED_ON = ON_JSBSIM


class Config(EngineFault):
    """An engine without power on [start_s, end_s)."""

    kind: Literal["loss"] = "loss"
    """gives no power: throttle 0, fuel and ignition shut"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "lost"


def change(entry: Config) -> Change:
    """Return what it does to its engine."""
    return Change(gain=0.0, stopped=True)
