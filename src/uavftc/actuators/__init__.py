"""What lies between a command and a deflection: one effect a file, in the order in which they act.

Of the kinds of fault at most one acts on an effector at a time, so their order among each other changes nothing.
"""

from __future__ import annotations

from uavftc.actuators import (
    backlash,
    control_power,
    deadband,
    delay,
    drift,
    effectiveness,
    floating,
    hardover,
    intermittent,
    lag,
    oscillatory,
    saturation,
    servo_delay,
    stops,
    stuck,
    total_loss,
)

CHAIN = (
    delay,
    saturation,
    deadband,
    servo_delay,
    lag,
    backlash,
    effectiveness,
    intermittent,
    oscillatory,
    drift,
    hardover,
    floating,
    stuck,
    total_loss,
    control_power,
    stops,
)
"""The order on an effector, from the command on."""
