"""d1 of eq. (7): an addition to the attitude rates, a device of the analytic model."""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.config.labels import parts
from uavftc.config.values import ZERO, Signal, Window
from uavftc.core.layout import Targets

ENTRY_OF = "disturbances"
FIELDS = ("d1",)
REFUSED_ON = {
    "jsbsim": (
        "no attitude-rate: on JSBSim the kinematics are exact, d1 is a device of the analytic model",
        "use sensors.gyro_bias_degps, or plant: analytic (--plant analytic)",
    )
}


class Config(Window):
    """d1 of eq. (7): an addition to the attitude rates, deg/s; analytic plant only."""

    kind: Literal["attitude-rate"] = "attitude-rate"
    phi_degps: Signal = ZERO
    """signal: added to the rate of bank"""
    theta_degps: Signal = ZERO
    """signal: added to the rate of pitch"""
    psi_degps: Signal = ZERO
    """signal: added to the rate of heading"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return parts({"roll": self.phi_degps, "pitch": self.theta_degps, "yaw": self.psi_degps}, "deg/s")


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Add it to d1, rad/s, at the times t, s, of the window."""
    for i, signal in enumerate((entry.phi_degps, entry.theta_degps, entry.psi_degps)):
        records["d1"][:, i] += np.pi / 180.0 * signal.sample(t)
