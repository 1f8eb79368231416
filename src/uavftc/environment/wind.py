"""Wind: the velocity of the air over ground, constant or a function of time."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.config.labels import parts
from uavftc.config.values import ZERO, Signal, Window
from uavftc.core.layout import Targets
from uavftc.environment import air

ENTRY_OF = "disturbances"
FIELDS, REFUSED_ON = air.FIELDS, air.REFUSED_ON


class Config(Window):
    """Velocity of the air over ground, north-east-down, m/s: the direction it blows to."""

    kind: Literal["wind"] = "wind"
    north_mps: Signal = ZERO
    """signal: velocity of the air to the north"""
    east_mps: Signal = ZERO
    """signal: to the east"""
    down_mps: Signal = ZERO
    """signal: down"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        said = parts({"north": self.north_mps, "east": self.east_mps, "down": self.down_mps}, "m/s")
        return f"wind, {said}"


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Add it to wind_n, m/s, at the times t, s, of the window."""
    for i, signal in enumerate((entry.north_mps, entry.east_mps, entry.down_mps)):
        records["wind_n"][:, i] += signal.sample(t)
