"""What lies between a command and a deflection: one effect a file, in the order in which they act."""

from __future__ import annotations

from uavftc.actuators import delay, effectiveness, saturation, stops

CHAIN = (delay, saturation, effectiveness, stops)
"""The order on an effector, from the command on."""
