"""Delay of a sensor, of any length: the controller is shown what was measured that long ago.

A delay of d samples of the controller and a part f of one, 0 <= f < 1, is read between two samples along the line that
joins them,

    x_meas[k] = (1 - f) x_meas[k - d] + f x_meas[k - d - 1],

exact where the rate of change is constant, and within h^2 / 8 of the second derivative elsewhere (h is the sample
time). With f > 0 it is a mean of two samples: white noise before it keeps sqrt((1 - f)^2 + f^2) of its standard
deviation, 0.71 at half a sample, and a value may lie between two steps of a converter. A delay of whole samples changes
no bit of what it hands on.

Before the flight everything was as in its first sample. What is on the way when an error before it ends arrives later.
"""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from uavftc.config.values import Model, NonNegativeVector3, Problem, refusal
from uavftc.core.given import Given
from uavftc.core.stage import RAW, Block, Stage, floats, law, params_of

KEYS_IN = "sensors"

MAX_DELAY_S = 600.0  # s; at 10 kHz the lines of both sensors are 0.3 GB then

PARAMS = np.dtype(
    [
        ("length", "i8"),  # samples in a line
        ("attitude_whole", "i8", (3,)),  # d
        ("attitude_part", "f8", (3,)),  # f
        ("gyro_whole", "i8", (3,)),
        ("gyro_part", "f8", (3,)),
    ]
)
STATE = RAW  # [0] 1 once there was a sample, [1] the place of the next one, then the lines of attitude and gyro
HEAD = 2


class Config(Model):
    """Delays of the measured attitude and of the measured body rates."""

    attitude_delay_s: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """delay of the measured [phi, theta, psi], 0 to 600"""
    gyro_delay_s: NonNegativeVector3 = (0.0, 0.0, 0.0)
    """delay of the measured [p, q, r], 0 to 600"""

    @model_validator(mode="after")
    def _short(self) -> Config:
        keys = ("attitude_delay_s", "gyro_delay_s")
        expected, remedy = f"at most {MAX_DELAY_S:g} s", "shorten the delay"
        found = [
            Problem((key,), f"{max(getattr(self, key)):g} s", expected, remedy)
            for key in keys
            if max(getattr(self, key)) > MAX_DELAY_S
        ]
        if found:
            raise refusal(found)
        return self


@law
def late(line, length, newest, filled, whole, part, x):
    """Put x into its line, shape (3 length,), and give it the value of its delay ago, in place."""
    for i in range(3):
        for j in range(0 if filled else length):
            line[i * length + j] = x[i]
        line[i * length + newest] = x[i]
        current = line[i * length + (newest - whole[i] + length) % length]
        before = line[i * length + (newest - whole[i] - 1 + length) % length]
        x[i] = (1.0 - part[i]) * current + part[i] * before if part[i] > 0.0 else current


@law
def step(p, s, row):
    """Put the measurement into the lines, and show the one of the delay ago."""
    n = 3 * p.length
    memory = floats(s, HEAD + 2 * n)
    newest, filled = int(memory[1]), memory[0] != 0.0
    late(memory[HEAD : HEAD + n], p.length, newest, filled, p.attitude_whole, p.attitude_part, row.x1_meas)
    late(memory[HEAD + n : HEAD + 2 * n], p.length, newest, filled, p.gyro_whole, p.gyro_part, row.x2_meas)
    memory[0], memory[1] = 1.0, (newest + 1) % p.length


stage = Stage(step, PARAMS, STATE, reads=["x1_meas", "x2_meas"], writes=["x1_meas", "x2_meas"])


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the lines of both sensors; none without a delay."""
    delays = np.array([config.attitude_delay_s, config.gyro_delay_s])
    if not delays.any():
        return []
    # a delay longer than the flight acts as one of the flight's length; so the lines stay small
    samples = np.minimum(delays, (given.steps + 1) * given.h) / given.h
    whole = np.floor(samples + 1e-9).astype(np.int64)
    part = np.where(samples - whole > 1e-9, samples - whole, 0.0)
    length = int(whole.max()) + 2
    lines = params_of(
        PARAMS,
        length=length,
        attitude_whole=whole[0],
        attitude_part=part[0],
        gyro_whole=whole[1],
        gyro_part=part[1],
    )
    return [stage.block(lines, np.zeros(HEAD + 6 * length), name="sensor_delay")]
