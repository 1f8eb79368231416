"""The `disturbances` section: what pushes the vehicle, and when. Windows are [start_s, end_s); overlaps add up."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from uavftc.config.values import Model, NonNegative, Number, Positive, Signal

ZERO = Signal(0.0)


class Window(Model):
    """Something that acts on [start_s, end_s), s; `end_s` null means till the end of the flight."""

    start_s: NonNegative = 0.0
    end_s: Number | None = None

    @field_validator("end_s")
    @classmethod
    def _after_start(cls, end_s: float | None, info: ValidationInfo) -> float | None:
        start_s = info.data.get("start_s")
        if end_s is not None and start_s is not None and end_s <= start_s:
            raise PydanticCustomError("window", "after start_s, {start_s} s", {"start_s": f"{start_s:g}"})
        return end_s

    def active(self, t: np.ndarray) -> np.ndarray:
        """Return, for each time `t`, s, whether the window holds it; bool, same shape."""
        return (t >= self.start_s) & (t < (np.inf if self.end_s is None else self.end_s))


class AngularAcceleration(Window):
    """d2 of eq. (7): an angular acceleration in body axes, deg/s^2."""

    kind: Literal["angular-acceleration"] = "angular-acceleration"
    p_degps2: Signal = ZERO
    q_degps2: Signal = ZERO
    r_degps2: Signal = ZERO


class AttitudeRate(Window):
    """d1 of eq. (7): an addition to the attitude rates, deg/s; analytic plant only."""

    kind: Literal["attitude-rate"] = "attitude-rate"
    phi_degps: Signal = ZERO
    theta_degps: Signal = ZERO
    psi_degps: Signal = ZERO


class Wind(Window):
    """Velocity of the air over ground, north-east-down, m/s: the direction it blows to."""

    kind: Literal["wind"] = "wind"
    north_mps: Signal = ZERO
    east_mps: Signal = ZERO
    down_mps: Signal = ZERO


class Gust(Model):
    """A 1-cosine gust: rises over `ramp_s`, holds `hold_s`, falls over `ramp_s`; peak velocity of the air, m/s."""

    kind: Literal["gust"] = "gust"
    start_s: NonNegative = 0.0
    ramp_s: Positive
    hold_s: NonNegative = 0.0
    north_mps: Number = 0.0
    east_mps: Number = 0.0
    down_mps: Number = 0.0

    @property
    def end_s(self) -> float:
        """The time at which the air is still again, s."""
        return self.start_s + 2 * self.ramp_s + self.hold_s


class Turbulence(Model):
    """A kind that is known by name and refused."""

    kind: Literal["turbulence"] = "turbulence"

    @model_validator(mode="before")
    @classmethod
    def _refuse(cls, data: Any) -> Any:
        raise PydanticCustomError("turbulence", "turbulence is not available yet")


Disturbance = Annotated[
    AngularAcceleration | AttitudeRate | Wind | Gust | Turbulence,
    Field(discriminator="kind"),
]
AIR = (Wind, Gust)
