"""Motion of a servo: a lag of first or second order, within limits of its rate and of its position.

First order:  y' = w (u - y).    Second order:  y'' = w^2 (u - y) - 2 zeta w y'.    |y'| <= R,  min <= y <= max

w is `bandwidth_radps` (null: y = u as far as the limits allow), zeta `damping`, R `rate_limit_degps`. The limits act
as those of limited integrators (`response.py`). Commands are held over a plant step, and the motion is exact for that.

The effector gets what the plant needs for a loop that is accurate to the second order of its step: the mean of y over
the step on the analytic plant, which holds its inputs over one, and y at the end of the step on JSBSim, which reads the
surfaces there and integrates by a multi-step rule. The servo itself, y at t_k, is in the history as
`<effector>_servo_rad`.

A servo of first order begins each command with a jump of y', at the beginning of a plant step of T. Adams-Bashforth 3,
by which JSBSim integrates the body rates, then gives the integral of y short by T^2/12 of the jump, as a delay of 7 us
would (57 rad/s, T = 1.25 ms); a loop near its phase margin feels that. So there the effector gets T/12 of the jump
besides, at that one step, unless it has backlash or a servo of the aircraft's, which would follow it.

A fault of the kind `rate-limit` lowers R to `rate_degps`; a servo that is slower by itself stays so. The memory, y and
y', goes on after the window with the servo's own limit: from where the servo is it catches up as that allows, and an
ideal servo at once.
"""

from __future__ import annotations

from math import ceil, inf, radians
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from uavftc.actuators import backlash
from uavftc.actuators.at_rest import Reach, Rest
from uavftc.actuators.fault import SurfaceFault
from uavftc.actuators.response import LONGEST, first_order, rate_of, second_order
from uavftc.actuators.servo import LEAST_RAD, Keys, moved_of, note, part_of, schedule, servos, value_of
from uavftc.config.values import Number, Positive, Problem
from uavftc.core.given import Given
from uavftc.core.stage import RAW, Block, Stage, floats, law

KEYS_IN = "actuators"

PARAMS = np.dtype(
    [
        ("order", "i8"),  # 0: no lag, 1, 2
        ("w", "f8"),  # rad/s
        ("zeta", "f8"),
        ("low", "f8"),  # rad about trim
        ("high", "f8"),
        ("dt", "f8"),  # plant step, s
        ("corner", "f8"),  # of a jump of y', s: what the effector gets of it
        ("end", "f8"),  # 1 where the plant takes the position at its end, 0 for the mean
        ("part", "f8"),  # of it, at most in one series, s
        ("count", "i8"),  # of switches of the limit of the rate
    ]
)
STATE = RAW  # y, rad, and y', rad/s, in [0] and [1]; then the switches, the limits of the rate, rad/s, and how far each
# moved the servo, rad
FIRST = 2  # place of the switches

CORNER = 1.0 / 12.0  # of a jump of y', times the step: what Adams-Bashforth 3 leaves out
MOST_RADPS = 1e4  # a servo of 1600 Hz; beyond it a plant step of 5 ms takes hundreds of series of second order
MOST_DAMPING = 10.0


class Config(Keys):
    """How a servo moves."""

    bandwidth_radps: Annotated[Positive, Field(le=MOST_RADPS)] | None = None
    """bandwidth of a lag of first order; with `damping`, natural frequency of one of second order; up to 10000; `null`
    is no lag"""
    damping: Annotated[Positive, Field(le=MOST_DAMPING)] | None = None
    """damping ratio: makes the lag one of second order; up to 10; `null` is first order"""
    rate_limit_degps: Positive | None = None
    """greatest rate of the servo; `null` is none"""
    min_deg: Annotated[Number, Field(le=0)] | None = None
    """least position of the servo about trim, <= 0; `null` is none"""
    max_deg: Annotated[Number, Field(ge=0)] | None = None
    """greatest position of the servo about trim, >= 0 and above `min_deg`; `null` is none"""

    def problems(self) -> list[Problem]:
        """Return what is wrong with these keys together."""
        found = []
        if self.damping is not None and self.bandwidth_radps is None:
            expected = "bandwidth_radps next to it, the natural frequency of the lag"
            found.append(Problem(("damping",), f"{self.damping:g} alone", expected, "add bandwidth_radps, or leave it"))
        if self.min_deg is not None and self.max_deg is not None and self.min_deg == self.max_deg:
            found.append(Problem(("max_deg",), "0, and 0 for min_deg", "a servo that can move", "widen one of them"))
        return found


class Slowed(SurfaceFault):
    """A servo no faster than `rate_degps` on [start_s, end_s)."""

    kind: Literal["rate-limit"] = "rate-limit"
    """a slow servo"""
    rate_degps: Positive
    """greatest rate of the servo, > 0; one that is slower by itself stays so"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"at most {self.rate_degps:g} deg/s"


FAULT = Slowed


@law
def move(p, y, v, u, R):
    """Return position and rate after a plant step towards u, and the mean of the position, with a limit of the rate."""
    if p.order == 2:
        return second_order(y, v, u, p.w, p.zeta, R, p.low, p.high, p.dt, p.part)
    if p.order == 1 or inf != R:
        end, mean = first_order(y, u, p.w, R, p.low, p.high, p.dt)
        return end, rate_of(end, u, p.w, R, p.low, p.high), mean
    end = p.low if u < p.low else (p.high if u > p.high else u)
    return end, v, end


@law
def step(p, s, e, row):
    """Move the servo by one plant step; the effector gets where it is at the end, or the mean."""
    memory = floats(s, 3 * p.count + 4)
    i = part_of(memory, FIRST, p.count, row.t)
    R, own = value_of(memory, FIRST, p.count, i), value_of(memory, FIRST, p.count, 0)
    u, y, v = e.deflection, memory[0], memory[1]
    memory[0], memory[1], e.deflection = move(p, y, v, u, R)
    e.servo = e.deflection if p.order == 0 and inf == R else y
    if own > R and moved_of(memory, FIRST, p.count, i) <= LEAST_RAD:  # once it has acted there is no more to be found
        y_own, _, mean_own = move(p, y, v, u, own)
        note(memory, FIRST, p.count, i, memory[0] - y_own)
        if p.end == 0.0:
            note(memory, FIRST, p.count, i, e.deflection - mean_own)
    if p.end != 0.0:
        end = memory[0]
        if p.corner != 0.0:
            end += p.corner * (rate_of(y, u, p.w, R, p.low, p.high) - v)
        e.deflection = p.low if end < p.low else (p.high if end > p.high else end)


stage = Stage(step, PARAMS, STATE, reads=["deflection", "t"], writes=["deflection", "servo"])


def acts_on(config: Config, given: Given) -> np.ndarray:
    """Return which effectors have a servo that takes time or has limits, shape (n,)."""
    return np.array([s.keys is not None and (s.keys.bandwidth_radps, s.keys.min_deg, s.keys.max_deg) != (None,) * 3
                     for s in servos(config, given)]) | rate_limits(config, given).acts  # fmt: skip


def rate_limits(config: Config, given: Given) -> Any:
    """Return the limit of the rate of each effector in time, rad/s; inf is none."""
    own = [
        inf if s.keys is None or s.keys.rate_limit_degps is None else radians(s.keys.rate_limit_degps)
        for s in servos(config, given)
    ]
    return schedule(own, inf, Slowed, lambda R, fault: min(R, radians(fault.rate_degps)), given)


def positions(config: Config, given: Given) -> np.ndarray:
    """Return the limits of the position of each effector's servo about trim, rad, shape (n, 2); inf is none."""
    table = np.empty((len(given.effectors), 2))
    for row, servo in zip(table, servos(config, given), strict=True):
        low = -inf if servo.keys is None or servo.keys.min_deg is None else radians(servo.keys.min_deg)
        high = inf if servo.keys is None or servo.keys.max_deg is None else radians(servo.keys.max_deg)
        row[:] = (low, high) if servo.sign > 0.0 else (-high, -low)
    return table


def blocks(config: Config, given: Given) -> list[Block]:
    """Return the servo of each effector; none where all are ideal."""
    if not acts_on(config, given).any():
        return []
    rate, T = rate_limits(config, given), given.plant_step
    params = np.zeros(len(given.effectors), PARAMS)
    followed = backlash.widths(config, given).acts | np.array([bool(own) for own in given.servos] or [False])
    for p, servo in zip(params, servos(config, given), strict=True):
        keys = Config() if servo.keys is None else servo.keys
        w = inf if keys.bandwidth_radps is None else keys.bandwidth_radps
        p["order"] = 0 if w == inf else 1 if keys.damping is None else 2
        p["w"], p["zeta"], p["dt"], p["end"] = w, keys.damping or 0.0, T, given.at_end
        p["part"] = T / ceil(T * w * max(1.0, 2.0 * (keys.damping or 0.0)) / LONGEST) if w != inf else T
    params["corner"] = np.where((params["order"] == 1) & ~followed, CORNER * T, 0.0)
    params["low"], params["high"] = positions(config, given).T
    params["count"] = rate.switches
    return [stage.block(params, np.column_stack([np.zeros((len(params), 2)), rate.table]))]


def at_rest(config: Config, given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return what is between the limits of the servo's position."""
    return [reach.within(*positions(config, given).T)]
