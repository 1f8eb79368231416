"""A stuck sensor: an axis shows one value on [start_s, end_s), whatever the vehicle does.

The value is the given one, or what the axis showed last before the window: x_meas[k] = x_meas[k0 - 1], k0 the first
sample of the window; at the start of the flight that of the first sample. It holds to the bit. From the first sample at
or after `end_s` the measurement passes unchanged. Entries act in their order.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.config.values import Model, Number, Window
from uavftc.core.given import Given
from uavftc.core.signals import AXES
from uavftc.core.stage import Block, Stage, law, params_of

KEYS_IN = "sensors"

PARAMS = np.dtype(
    [
        ("attitude", "i8"),  # 1 of the attitude, 0 of the gyro
        ("axis", "i8", (3,)),  # 1 where it acts
        ("start", "f8"),  # s
        ("end", "f8"),  # s
        ("is_given", "i8"),  # 0 where it is stuck at what it showed last
        ("at", "f8"),  # the given value, rad or rad/s
    ]
)
STATE = np.dtype(
    [
        ("started", "i8"),
        ("last", "f8", (3,)),  # what was shown last, rad or rad/s
    ]
)


class Stuck(Window):
    """An axis that is stuck on [start_s, end_s)."""

    axis: Literal["roll", "pitch", "yaw"] | None = None
    """`roll`, `pitch` or `yaw`; `null` is all three"""


class StuckAttitude(Stuck):
    """A measured angle that is stuck."""

    at_deg: Number | None = None
    """at which angle; `null` is where it is"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "stuck" if self.at_deg is None else f"stuck at {self.at_deg:g} deg"


class StuckGyro(Stuck):
    """A measured rate that is stuck."""

    at_degps: Number | None = None
    """at which rate; `null` is where it is"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "stuck" if self.at_degps is None else f"stuck at {self.at_degps:g} deg/s"


class Config(Model):
    """Stuck axes of the measured attitude and of the measured body rates."""

    attitude_stuck: tuple[StuckAttitude, ...] = ()
    """list of [stuck](#dropout-and-stuck) axes of the attitude"""
    gyro_stuck: tuple[StuckGyro, ...] = ()
    """list of [stuck](#dropout-and-stuck) axes of the gyro"""


@law
def freeze(p, s, t, x):
    """Show the value at which the axes are stuck, in place; t is the time, s."""
    inside = p.start <= t < p.end
    for i in range(3):
        if not inside or s.started == 0:
            s.last[i] = x[i]
        if inside and p.axis[i] == 1:
            x[i] = p.at if p.is_given == 1 else s.last[i]
    s.started = 1


@law
def step(p, s, row):
    """Freeze axes of one sensor, in place."""
    if p.attitude == 1:
        freeze(p, s, row.t, row.x1_meas)
    else:
        freeze(p, s, row.t, row.x2_meas)


stage = Stage(step, PARAMS, STATE, reads=["t", "x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return a block for each entry."""
    of_attitude = [(1, f"attitude_stuck_{i}", entry, entry.at_deg) for i, entry in enumerate(config.attitude_stuck)]
    of_gyro = [(0, f"gyro_stuck_{i}", entry, entry.at_degps) for i, entry in enumerate(config.gyro_stuck)]
    return [
        stage.block(_params(attitude, entry, at), name=name) for attitude, name, entry, at in [*of_attitude, *of_gyro]
    ]


def _params(attitude: int, entry: Stuck, at: float | None) -> np.ndarray:
    return params_of(
        PARAMS,
        attitude=attitude,
        axis=np.array([entry.axis in (None, axis) for axis in AXES], dtype=np.int64),
        start=entry.start_s,
        end=np.inf if entry.end_s is None else entry.end_s,
        is_given=int(at is not None),
        at=0.0 if at is None else np.radians(at),
    )
