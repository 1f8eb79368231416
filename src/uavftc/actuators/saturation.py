"""Input saturation, eq. (20): each effector limited to [u_min, u_max] about trim.

sat(v) = u_min  for v < u_min,    v  between,    u_max  for v > u_max
"""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Discriminator, Field, Tag, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from uavftc.actuators.at_rest import Reach, Rest
from uavftc.config.values import Model, Number
from uavftc.core.given import Given
from uavftc.core.layout import Targets
from uavftc.core.signals import SURFACES
from uavftc.core.stage import NOTHING, Block, Stage, law, records_of

SECTION = "saturation"

PARAMS = np.dtype([("u_min", "f8"), ("u_max", "f8")])  # rad; +-inf for no limit
STATE = NOTHING


class Limits(Model):
    """Limits of a commanded deflection about trim, rad."""

    min_rad: Annotated[Number, Field(le=0)]
    """least deflection about trim, <= 0"""
    max_rad: Number
    """greatest deflection about trim, >= 0 and above `min_rad`"""

    @field_validator("max_rad")
    @classmethod
    def _ordered(cls, max_rad: float, info: ValidationInfo) -> float:
        if max_rad < 0 or max_rad <= info.data.get("min_rad", -math.inf):
            raise PydanticCustomError("limits", "min <= 0 <= max and min < max")
        return max_rad


class SurfaceLimits(Model):
    """Limits of surfaces by name: of an axis, or of one effector of the aircraft; null is unlimited."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, Limits | None]

    aileron: Limits | None = None
    elevator: Limits | None = None
    rudder: Limits | None = None

    def named(self) -> dict[str, Limits]:
        """Return the limits that there are, by the name of the surface."""
        return {name: limits for name, limits in self if limits is not None}


def _limits_or_surfaces(value: Any) -> str:
    if not isinstance(value, dict):
        return "SurfaceLimits" if isinstance(value, SurfaceLimits) else "Limits"
    by_name = any(key in SURFACES or isinstance(limits, dict | Limits | None) for key, limits in value.items())
    return "SurfaceLimits" if by_name and not value.keys() & Limits.model_fields.keys() else "Limits"


Config = Annotated[
    Annotated[Limits, Tag("Limits")] | Annotated[SurfaceLimits, Tag("SurfaceLimits")],
    Discriminator(_limits_or_surfaces),
]


@law
def sat(v, u_min, u_max):
    """Return v limited to [u_min, u_max], rad (eq. 20); nan stays nan."""
    return u_min if v < u_min else (u_max if v > u_max else v)


@law
def step(p, s, e, row):
    """Limit the deflection in place."""
    e.deflection = sat(e.deflection, p.u_min, p.u_max)


stage = Stage(step, PARAMS, STATE, reads=["deflection"], writes=["deflection"])


def limits_rad(config: Limits | SurfaceLimits | None, effectors: tuple[str, ...] = SURFACES) -> np.ndarray:
    """Return the limits about trim, rad, shape (n, 2): [min, max] of each effector; inf is none."""
    table = np.array([[-np.inf, np.inf]] * len(effectors))
    for i, effector in enumerate(effectors):
        limits = getattr(config, effector, None) if isinstance(config, SurfaceLimits) else config
        if limits is not None:
            table[i] = limits.min_rad, limits.max_rad
    return table


def effector_limits(config: Limits | SurfaceLimits | None, mixing: np.ndarray, targets: Targets) -> np.ndarray:
    """Return the limits of each effector about trim, rad, shape (n, 2); inf is none.

    Limits of a gang are those of its members times their weights. One pair for all limits each effector, counted as the
    first axis that it serves does. Of several limits on an effector the tightest act.
    """
    table = np.array([[-np.inf, np.inf]] * len(mixing))
    if isinstance(config, SurfaceLimits):
        named = [(targets[name], limits) for name, limits in config.named().items()]
    else:
        signs = {j: -1.0 if row[np.argmax(row != 0.0)] < 0.0 else 1.0 for j, row in enumerate(mixing)}
        named = [] if config is None else [(signs, config)]
    for members, limits in named:
        for j, weight in members.items():
            low, high = sorted((weight * limits.min_rad, weight * limits.max_rad))
            table[j] = max(table[j, 0], low), min(table[j, 1], high)
    return table


def axis_limits(limits: np.ndarray, mixing: np.ndarray) -> np.ndarray:
    """Return within what each axis may be commanded so that no effector meets its limits, rad, shape (3, 2).

    Parameters
    ----------
    limits
        Least and greatest deflection of each effector, shape (n, 2), rad.
    mixing
        Deflection of each effector per rad of axis command, shape (n, 3); one axis at a time.
    """
    table = np.array([[-np.inf, np.inf]] * 3)
    for j, i in np.argwhere(mixing != 0.0):
        low, high = sorted(limits[j] / mixing[j, i])
        table[i] = max(table[i, 0], low), min(table[i, 1], high)
    return table


def blocks(config: Limits | SurfaceLimits | None, given: Given) -> list[Block]:
    """Return the limits of each effector; none where nothing is limited."""
    if config is None:
        return []
    low, high = effector_limits(config, given.mixing, given.targets).T
    return [stage.block(records_of(PARAMS, len(given.effectors), u_min=low, u_max=high))]


def at_rest(config: Limits | SurfaceLimits | None, given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return what is within the limits."""
    return [reach.within(*effector_limits(config, given.mixing, given.targets).T)]
