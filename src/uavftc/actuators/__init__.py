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
    engine_loss,
    engine_reduced,
    engine_stuck,
    floating,
    hardover,
    intermittent,
    lag,
    loop_gain,
    oscillatory,
    saturation,
    servo_delay,
    stops,
    stuck,
    total_loss,
)

CHAIN = (
    loop_gain,
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

ENGINES = (engine_loss, engine_stuck, engine_reduced)
"""What can happen to an engine; one at a time. No step on an effector: the plant does it, see `engine.py`."""
