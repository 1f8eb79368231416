"""d2 of eq. (7): an angular acceleration in body axes; on JSBSim the body moment J d2."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.config.labels import parts
from uavftc.config.values import ZERO, Signal, Window
from uavftc.core.layout import Targets

ENTRY_OF = "disturbances"
FIELDS = ("d2",)


class Config(Window):
    """d2 of eq. (7): an angular acceleration in body axes, deg/s^2."""

    kind: Literal["angular-acceleration"] = "angular-acceleration"
    p_degps2: Signal = ZERO
    """signal: angular acceleration about the body x axis"""
    q_degps2: Signal = ZERO
    """signal: about the body y axis"""
    r_degps2: Signal = ZERO
    """signal: about the body z axis"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return parts({"p": self.p_degps2, "q": self.q_degps2, "r": self.r_degps2}, "deg/s^2")


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Add it to d2, rad/s^2, at the times t, s, of the window."""
    for i, signal in enumerate((entry.p_degps2, entry.q_degps2, entry.r_degps2)):
        records["d2"][:, i] += np.pi / 180.0 * signal.sample(t)
