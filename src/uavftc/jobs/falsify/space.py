"""The space that is searched: the ranges of a campaign as a unit cube, and how far from nominal a point of it is.

A key that is drawn has one coordinate s on [0, 1] along its own scale,

    uniform, integer    s = (v - a)/(b - a)
    log-uniform         s = ln(v/a)/ln(b/a)
    normal              s = 1/2 + (v - m)/(6 d), so that the range is the mean m and three deviations d to either side

and so has a choice or a grid, whose k values share the coordinate in equal parts; lists, which go in step, have one
between them. Nominal is what the base scenario has: the fault that is none. The distance of a fault is Euclidean,

    sqrt(sum_k (s_k - s_k,nominal)^2),    of values that are counted off |v - v_nominal|/(max - min), or, where one of
                                          them is no number, 0 for the nominal one and 1 for any other

so that 1 is the whole range of one key. Where the base has no number that the range could be compared with (nothing, or
an expression of t), the middle of the range stands for it, or the first of values that are counted off; `nominal:`
next to the range says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtri

from uavftc.config.values import is_number
from uavftc.errors import InputError
from uavftc.jobs.campaign.cases import quantile
from uavftc.jobs.campaign.variants import at
from uavftc.scenario.campaign import Campaign, Vary, where_varied
from uavftc.scenario.schema import Scenario

DEVIATIONS = 3.0
"""To either side of the mean: the range of a normal distribution."""


class Axis(NamedTuple):
    """One coordinate of the cube."""

    keys: tuple[str, ...]
    """One, or those of all lists."""
    levels: int
    """How many values share the coordinate; 0 where it is continuous."""


class Space:
    """What is searched with one variant.

    Parameters
    ----------
    campaign
        Its `vary`; how many cases it has, and by which design, is no matter.
    scenario
        The base, with a controller, plant and aircraft: what is nominal.

    Raises
    ------
    InputError
        If nothing varies.
    """

    def __init__(self, campaign: Campaign, scenario: Scenario) -> None:
        self.vary: Mapping[str, Vary] = campaign.vary
        lists = tuple(key for key, vary in self.vary.items() if vary.kind == "list")
        self.axes: list[Axis] = []
        for key, vary in self.vary.items():
            if key not in lists:
                self.axes.append(Axis((key,), _levels(vary)))
            elif key == lists[0]:
                self.axes.append(Axis(lists, len(vary.given)))
        if not self.axes:
            raise InputError(
                campaign.origin.where(("vary",)),
                found="nothing that varies",
                expected="at least one key with its range",
                remedy='write vary: {"faults[0].effectiveness": {uniform: [0, 1]}}',
            )
        self.nominal = {key: _nominal(campaign, scenario, key) for key in self.vary}
        """Value of each key; None where the middle of its range stands for it."""

    @property
    def dimension(self) -> int:
        """How many coordinates there are."""
        return len(self.axes)

    @property
    def finite(self) -> int | None:
        """How many points there are, or None where a coordinate is continuous."""
        levels = [axis.levels for axis in self.axes]
        return math.prod(levels) if all(levels) else None

    def drawn(self, u: np.ndarray) -> np.ndarray:
        """Return the point of a draw u, uniform on the cube, shape (d,): as likely as the campaign draws it."""
        s = np.array(u, dtype=float)
        for i, axis in enumerate(self.axes):
            if self.vary[axis.keys[0]].kind == "normal":
                s[i] = 0.5 + float(ndtri(u[i])) / (2.0 * DEVIATIONS) if 0.0 < u[i] < 1.0 else u[i]
        return np.clip(s, 0.0, 1.0)

    def values(self, s: np.ndarray) -> dict[str, Any]:
        """Return what the keys take at a point, shape (d,), each coordinate on [0, 1]."""
        found: dict[str, Any] = {}
        for axis, at_s in zip(self.axes, np.clip(s, 0.0, 1.0), strict=True):
            for key in axis.keys:
                found[key] = _value(self.vary[key], float(at_s))
        return {key: found[key] for key in self.vary}

    def parts(self, values: Mapping[str, Any]) -> dict[str, float]:
        """Return how far each key is from nominal, signed where it is a number, along its own scale."""
        return {key: self._part(key, value) for key, value in values.items()}

    def distance(self, values: Mapping[str, Any]) -> float:
        """Return how far a fault is from nominal."""
        return math.hypot(*self.parts(values).values())

    def coordinates(self, values: Mapping[str, Any]) -> dict[str, float]:
        """Return where values are along the range of their keys, 0 to 1, for a figure; beyond where they are."""
        return {key: _coordinate(self.vary[key], value) for key, value in values.items()}

    def nominal_values(self) -> dict[str, Any]:
        """Return the value of each key that distances are from; the middle of the range where nothing is nominal."""
        return {key: _value(self.vary[key], 0.5) if value is None else value for key, value in self.nominal.items()}

    def start(self) -> np.ndarray:
        """Return the point of the cube nearest to nominal, shape (d,)."""
        s = np.empty(self.dimension)
        for i, axis in enumerate(self.axes):
            if axis.levels:
                far = [
                    math.hypot(*(self._part(key, _value(self.vary[key], (k + 0.5) / axis.levels)) for key in axis.keys))
                    for k in range(axis.levels)
                ]
                s[i] = (int(np.argmin(far)) + 0.5) / axis.levels
            else:
                (key,) = axis.keys
                s[i] = 0.5 if self.nominal[key] is None else _coordinate(self.vary[key], self.nominal[key])
        return np.clip(s, 0.0, 1.0)

    def _part(self, key: str, value: Any) -> float:
        vary, nominal = self.vary[key], self.nominal[key]
        if vary.kind not in _COUNTED:
            return _coordinate(vary, value) - (0.5 if nominal is None else _coordinate(vary, nominal))
        if all(map(is_number, (*vary.given, nominal))):
            spread = max(vary.given) - min(vary.given)
            return (value - nominal) / spread if spread else 0.0
        return 0.0 if value == nominal else 1.0


_COUNTED = ("choice", "grid", "list")
FEW = 16
"""Whole numbers, up to which they are taken one by one; more are as good as a continuous range."""


def _levels(vary: Vary) -> int:
    if vary.kind in _COUNTED:
        return len(vary.given)
    count = int(vary.given[1] - vary.given[0]) + 1 if vary.kind == "integer" else 0
    return count if count <= FEW else 0


def _value(vary: Vary, s: float) -> Any:
    if vary.kind in _COUNTED:
        return vary.given[min(int(s * len(vary.given)), len(vary.given) - 1)]
    if vary.kind == "integer":
        return min(quantile(vary, s), int(vary.given[1]))
    if vary.kind == "normal":
        mean, deviation = vary.given
        return float(mean + 2.0 * DEVIATIONS * (s - 0.5) * deviation)
    return quantile(vary, s)


def _coordinate(vary: Vary, value: Any) -> float:
    if vary.kind in _COUNTED:
        place = next((k for k, one in enumerate(vary.given) if one == value), None)
        return 0.5 if place is None else (place + 0.5) / len(vary.given)
    a, b = vary.given
    if vary.kind == "normal":
        return float(0.5 + (value - a) / (2.0 * DEVIATIONS * b))
    if vary.kind == "log-uniform":
        return math.log(value / a) / math.log(b / a) if value > 0.0 else 0.0
    return float((value - a) / (b - a))


def _nominal(campaign: Campaign, scenario: Scenario, key: str) -> Any:
    vary = campaign.vary[key]
    if vary.nominal is not None:
        if vary.kind not in _COUNTED and not is_number(vary.nominal):
            raise InputError(
                f"{where_varied(campaign, key)}, key {key}",
                found=f"nominal: {vary.nominal}",
                expected="a number, as the range has",
                remedy="write a number, or leave nominal out for that of the base",
            )
        return vary.nominal
    found = at(scenario, key)
    found = getattr(found, "written", found)  # of a signal
    if vary.kind not in _COUNTED:
        return found if is_number(found) else None
    if isinstance(found, tuple):
        found = list(found)
    same = found in vary.given or all(map(is_number, (*vary.given, found)))
    return found if same else vary.given[0]
