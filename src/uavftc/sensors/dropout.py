"""Dropout of a sensor: for a time nothing arrives, and the controller is shown what the receiver makes of that.

While a sensor is lost, x_meas is the last value that arrived (`mode: hold`) or 0 (`mode: zero`). Without mean times it
is lost on the whole window. With them it is lost and there by turns, at random: a two-state Markov process in which
each stretch has an exponentially distributed length,

    lost, with the mean mean_lost_s        there, with the mean mean_between_s,

taken at the samples exactly: with a = 1 / mean_between_s, b = 1 / mean_lost_s and e = 1 - exp(-(a + b) h), a sensor
that is there is lost at the next sample with the probability e a / (a + b), one that is lost is there again with
e b / (a + b). It is there before the window, and lost for a / (a + b) of it in the long run.

Each entry has a stream of its own, by (seed, sensor, axis, entry): the k-th sample of its window takes the k-th number.
All axes of an entry are lost together. From the first sample at or after `end_s` the measurement passes unchanged; one
that is lost from the start of the flight holds its first sample. Entries act in their order.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import model_validator

from uavftc.config.values import Model, Positive, Problem, Window, refusal
from uavftc.core.given import Given
from uavftc.core.random import key, uniform
from uavftc.core.signals import AXES
from uavftc.core.stage import Block, Stage, law, params_of

KEYS_IN = "sensors"
MODES = ("hold", "zero")

PARAMS = np.dtype(
    [
        ("attitude", "i8"),  # 1 of the attitude, 0 of the gyro
        ("axis", "i8", (3,)),  # 1 where it acts
        ("start", "f8"),  # s
        ("end", "f8"),  # s
        ("holds", "i8"),  # 1 in mode hold
        ("at_random", "i8"),  # 0 where it is lost on the whole window
        ("key", "u8"),
        ("loses", "f8"),  # probability of being lost at the next sample
        ("returns", "f8"),  # of being there again
    ]
)
STATE = np.dtype(
    [
        ("started", "i8"),
        ("lost", "i8"),
        ("k", "i8"),  # the sample of the window
        ("last", "f8", (3,)),  # what arrived last, rad or rad/s
    ]
)


class Dropout(Window):
    """A loss of the measurement on [start_s, end_s), on all of it or at random."""

    axis: Literal["roll", "pitch", "yaw"] | None = None
    """`roll`, `pitch` or `yaw`; `null` is all three, lost together"""
    mode: Literal["hold", "zero"] = "hold"
    """`hold`: the last value that arrived; `zero`: 0"""
    mean_lost_s: Positive | None = None
    """mean length of the losses, where they are random; `null` is a loss of the whole window"""
    mean_between_s: Positive | None = None
    """mean length of the times between them"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        lost = "lost" if self.mean_lost_s is None else "lost at times"
        return f"{lost}, {'holds' if self.mode == 'hold' else 'shows 0'}"

    @model_validator(mode="after")
    def _both_means(self) -> Dropout:
        missing = [name for name in ("mean_lost_s", "mean_between_s") if getattr(self, name) is None]
        if len(missing) == 1:
            expected = "mean_lost_s and mean_between_s, or neither"
            remedy = f"add {missing[0]}, s, or remove the other for a loss of the whole window"
            raise refusal([Problem((missing[0],), "nothing", expected, remedy)])
        return self


class Config(Model):
    """Losses of the measured attitude and of the measured body rates."""

    attitude_dropout: tuple[Dropout, ...] = ()
    """list of [losses](#dropout-and-stuck) of the attitude"""
    gyro_dropout: tuple[Dropout, ...] = ()
    """list of [losses](#dropout-and-stuck) of the gyro"""


@law
def receive(p, s, t, x):
    """Show what the receiver makes of x, in place; t is the time, s."""
    inside = p.start <= t < p.end
    lost = inside
    if inside and p.at_random == 1:
        u = uniform(p.key, s.k)
        s.lost = int(u >= p.returns) if s.lost == 1 else int(u < p.loses)
        s.k += 1
        lost = s.lost == 1
    for i in range(3):
        if not lost or s.started == 0:
            s.last[i] = x[i]
        if lost and p.axis[i] == 1:
            x[i] = s.last[i] if p.holds == 1 else 0.0
    s.started = 1


@law
def step(p, s, row):
    """Lose the measurement of one sensor, in place."""
    if p.attitude == 1:
        receive(p, s, row.t, row.x1_meas)
    else:
        receive(p, s, row.t, row.x2_meas)


stage = Stage(step, PARAMS, STATE, reads=["t", "x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return a block for each entry."""
    entries = [("attitude", config.attitude_dropout), ("gyro", config.gyro_dropout)]
    return [
        stage.block(_params(sensor, i, entry, given), name=f"{sensor}_dropout_{i}")
        for sensor, dropouts in entries
        for i, entry in enumerate(dropouts)
    ]


def _params(sensor: str, i: int, entry: Dropout, given: Given) -> np.ndarray:
    axis = 3 if entry.axis is None else AXES.index(entry.axis)
    loses = returns = 0.0
    if entry.mean_lost_s is not None and entry.mean_between_s is not None:
        a, b = 1.0 / entry.mean_between_s, 1.0 / entry.mean_lost_s
        change = -np.expm1(-(a + b) * given.h)
        loses, returns = change * a / (a + b), change * b / (a + b)
    return params_of(
        PARAMS,
        attitude=int(sensor == "attitude"),
        axis=np.array([axis in (j, 3) for j in range(3)], dtype=np.int64),
        start=entry.start_s,
        end=np.inf if entry.end_s is None else entry.end_s,
        holds=int(entry.mode == "hold"),
        at_random=int(entry.mean_lost_s is not None),
        key=key(given.seed, f"{sensor} dropout {i}", axis),
        loses=loses,
        returns=returns,
    )
