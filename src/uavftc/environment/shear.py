"""Wind shear: wind that changes with the height h above ground, by a power law or linearly.

    power     W(h) = W_0 (h / h_0)^n
    linear    W(h) = W_0 + G (h - h_0)

W_0 is the velocity of the air at the reference height h_0, north and east, so its direction too; G may turn it with the
height. h is the vehicle's at each sample, so the wind follows its climb; a height below ground counts as 0. A flight
whose shear begins at t = 0 starts in the wind of its height. The turning of the air that goes with a shear acts on no
moment. Nothing goes on after the window.

Source: the power law of wind engineering with n = 1/7 over open ground (IEC 61400-1, 6.3.1.2 has 0.2 over land).
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from uavftc.config.labels import parts
from uavftc.config.values import NonNegative, Number, Positive, Problem, Window, refusal
from uavftc.core.given import Given
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of
from uavftc.environment import air

ENTRY_OF = "disturbances"
FIELDS, REFUSED_ON = air.FIELDS, air.REFUSED_ON

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s
        ("end", "f8"),  # s
        ("wind", "f8", (2,)),  # W_0, north and east, m/s
        ("gradient", "f8", (2,)),  # G, 1/s
        ("height", "f8"),  # h_0, m
        ("exponent", "f8"),  # n; negative for a linear profile
    ]
)
STATE = NOTHING
LINEAR = -1.0


class Config(Window):
    """Wind that changes with the height above ground, by a power law or linearly: velocity of the air over ground."""

    kind: Literal["shear"] = "shear"
    profile: Literal["power", "linear"] = "power"
    """`power`: W (h/h_0)^n; `linear`: W + G (h - h_0)"""
    reference_height_m: Positive = 10.0
    """h_0: height above ground at which the wind is as given"""
    north_mps: Number = 0.0
    """velocity of the air to the north at the reference height"""
    east_mps: Number = 0.0
    """to the east"""
    exponent: NonNegative | None = None
    """n of the power law; `null` is 1/7, of open ground"""
    north_mps_per_m: Number | None = None
    """G of a linear profile: change of the velocity to the north with height; `null` is 0"""
    east_mps_per_m: Number | None = None
    """to the east"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        said = parts({"north": self.north_mps, "east": self.east_mps}, "m/s")
        return f"{self.profile} shear, {said} at {self.reference_height_m:g} m"

    foreign: ClassVar[dict[str, tuple[str, ...]]] = {
        "power": ("north_mps_per_m", "east_mps_per_m"),
        "linear": ("exponent",),
    }

    @model_validator(mode="after")
    def _of_the_profile(self) -> Config:
        found = [name for name in self.foreign[self.profile] if getattr(self, name) is not None]
        other = "linear" if self.profile == "power" else "power"
        if found:
            expected, remedy = f"no {found[0]} with profile: {self.profile}", f"remove it, or set profile: {other}"
            raise refusal([Problem((found[0],), f"{getattr(self, found[0]):g}", expected, remedy)])
        return self


@law
def velocity(p, height):
    """Return the velocity of the air to the north and to the east, m/s, at a height above ground, m."""
    h = height if height > 0.0 else 0.0
    if p.exponent < 0.0:
        above = h - p.height
        return p.wind[0] + p.gradient[0] * above, p.wind[1] + p.gradient[1] * above
    factor = (h / p.height) ** p.exponent
    return factor * p.wind[0], factor * p.wind[1]


@law
def step(p, s, row):
    """Add the wind of the height to wind_n."""
    if row.t < p.start or row.t >= p.end:
        return
    north, east = velocity(p, row.height)
    row.wind_n[0] += north
    row.wind_n[1] += east


stage = Stage(step, PARAMS, STATE, reads=["t", "height", "wind_n"], writes=["wind_n"])


def params(entry: Config) -> np.ndarray:
    """Return the parameters of an entry."""
    power = 1.0 / 7.0 if entry.exponent is None else entry.exponent
    return params_of(
        PARAMS,
        start=entry.start_s,
        end=np.inf if entry.end_s is None else entry.end_s,
        wind=np.array([entry.north_mps, entry.east_mps]),
        gradient=np.array([entry.north_mps_per_m or 0.0, entry.east_mps_per_m or 0.0]),
        height=entry.reference_height_m,
        exponent=power if entry.profile == "power" else LINEAR,
    )


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return the wind of each entry."""
    return [stage.block(params(entry), name=air.name("shear", i)) for i, entry in enumerate(config)]


def wind_at_start(entry: Config, height: float) -> np.ndarray:
    """Return the velocity of the air at a height above ground, m, north-east-down, shape (3,), m/s."""
    record: Any = params(entry).view(np.recarray)[0]
    north, east = velocity.py_func(record, height) if hasattr(velocity, "py_func") else velocity(record, height)
    return np.array([north, east, 0.0])
