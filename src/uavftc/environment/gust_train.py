"""A train of 1-cosine gusts: several alike, evenly spaced or at random moments, of one sign, alternating or random.

Gust i = 0 .. count - 1 has the profile of `gust.py` with the peak s_i [north, east, down] and begins at

    regular    start_s + i spacing_s
    random     start_s + i spacing_s + (spacing_s - length) U_i,     length = 2 ramp_s + hold_s, U_i uniform on [0, 1)

so that there is one gust in each interval and none overlaps the next. s_i is 1 with `signs: same`, 1, -1, 1, ... with
`alternating`, and 1 or -1 by an even chance with `random`. What is random is drawn before the flight from the
scenario's `seed`, for each entry by itself. A spacing near the period of a mode excites it.

Source: MIL-F-8785C 3.7.1.3 for the single gust, of which discrete gusts of either sign are made up.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from uavftc.config.labels import parts
from uavftc.config.values import Model, NonNegative, Number, Positive, Problem, Whole, refusal, window_of
from uavftc.core.layout import Targets
from uavftc.core.random import stream
from uavftc.environment import air, gust

ENTRY_OF = "disturbances"
FIELDS, REFUSED_ON = air.FIELDS, air.REFUSED_ON

COUNT_MAX = 10_000


class Config(Model):
    """Several 1-cosine gusts one after the other, as `gust` has one; peak velocity of the air, m/s."""

    kind: Literal["gust-train"] = "gust-train"
    start_s: NonNegative = 0.0
    """beginning of the first interval"""
    count: Annotated[Whole, Field(ge=1, le=COUNT_MAX)]
    """number of gusts, 1 to 10000"""
    spacing_s: Positive | None = None
    """from the beginning of one to that of the next, at least the length of one; `null` is that length, back to back"""
    ramp_s: Positive
    """time in which each rises, and in which it falls"""
    hold_s: NonNegative = 0.0
    """time for which each holds its peak"""
    north_mps: Number = 0.0
    """peak velocity of the air to the north"""
    east_mps: Number = 0.0
    """to the east"""
    down_mps: Number = 0.0
    """down"""
    signs: Literal["same", "alternating", "random"] = "same"
    """`same`, `alternating` or `random`: sign of the peak from gust to gust"""
    onset: Literal["regular", "random"] = "regular"
    """`regular`: each begins with its interval of `spacing_s`; `random`: anywhere in it that leaves it whole"""

    remedies: ClassVar[dict[str, str]] = {"end_s": "remove it: a train ends by itself, after count gusts"}

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        said = parts({"north": self.north_mps, "east": self.east_mps, "down": self.down_mps}, "m/s")
        return f"{self.count} gusts, {said}"

    @property
    def length_s(self) -> float:
        """Length of one gust, s."""
        return 2 * self.ramp_s + self.hold_s

    @property
    def interval_s(self) -> float:
        """From the beginning of one interval to that of the next, s."""
        return self.length_s if self.spacing_s is None else self.spacing_s

    @property
    def end_s(self) -> float:
        """The time at which the air is still again at the latest, s."""
        last = self.interval_s if self.onset == "random" else self.length_s
        return self.start_s + (self.count - 1) * self.interval_s + last

    @model_validator(mode="after")
    def _one_at_a_time(self) -> Config:
        if self.spacing_s is not None and self.spacing_s < self.length_s:
            expected = f"at least the length of a gust, 2*ramp_s + hold_s = {self.length_s:g} s"
            remedy = "lengthen it, shorten ramp_s or hold_s, or give two trains"
            raise refusal([Problem(("spacing_s",), f"{self.spacing_s:g} s", expected, remedy)])
        return self


class Train(NamedTuple):
    """An entry, its random parts drawn."""

    start_s: float
    end_s: float
    gusts: tuple[gust.Config, ...]


def drawn(entry: Config, seed: int, place: int) -> Train:
    """Return the gusts of an entry, the `place`-th of its kind."""
    shifts = stream(seed, "gust train onset", place).random(entry.count)
    turns = stream(seed, "gust train sign", place).random(entry.count) < 0.5
    gusts = []
    for i in range(entry.count):
        start = entry.start_s + i * entry.interval_s
        if entry.onset == "random":
            start += (entry.interval_s - entry.length_s) * shifts[i]
        negative = i % 2 == 1 if entry.signs == "alternating" else entry.signs == "random" and turns[i]
        sign = -1.0 if negative else 1.0
        peak = {f"{name}_mps": sign * getattr(entry, f"{name}_mps") for name in ("north", "east", "down")}
        gusts.append(gust.Config(start_s=start, ramp_s=entry.ramp_s, hold_s=entry.hold_s, **peak))
    return Train(entry.start_s, entry.end_s, tuple(gusts))


def prescribe(entry: Train, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Add the gusts to wind_n, m/s, at the times t, s, of the window."""
    for one in entry.gusts:
        window = window_of(one, t)
        if window.start < window.stop:
            gust.prescribe(one, t[window], records[window], targets)
