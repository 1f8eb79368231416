"""Loss of effectiveness and additive fault, eq. (6): u2 = omega v2 + v_2a, after the saturation (eq. 7).

omega (`effectiveness`) and v_2a (`bias`) are signals of the row, so all four cases of the paper's section 2.2 and
their changes in time are one formula: (1) omega = 1, v_2a = 0, no fault; (2) omega < 1, v_2a = 0, loss of
effectiveness; (3) omega = 1, v_2a != 0, additive fault; (4) both.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault
from uavftc.config.values import ZERO, AtLeast, Signal
from uavftc.core.given import Given
from uavftc.core.layout import Targets
from uavftc.core.stage import NOTHING, Block, Stage, law

ENTRY_OF = "faults"

PARAMS = NOTHING
STATE = NOTHING

Effectiveness = Annotated[Signal, AtLeast(0.0, "an effectiveness >= 0", "0 is a surface without effect")]


class Config(SurfaceFault):
    """A surface at `effectiveness` times its limited command, plus `bias_deg`, on [start_s, end_s)."""

    remedies: ClassVar[dict[str, str]] = {
        "at_deg": "write kind: stuck for a surface that is stuck at an angle",
        "engine": "write kind: loss, stuck or reduced for an engine",
    }

    kind: Annotated[Literal["effectiveness"], Field(exclude=True)] = "effectiveness"
    """eq. (6), a gain and a bias; where `kind` is left out"""
    effectiveness: Effectiveness = Signal(1.0)
    """signal, finite and >= 0 at every sample of the window; over 1 is flown as written, with a warning"""
    bias_deg: Signal = ZERO
    """signal, added to the deflection, outside the limits"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        bias = "" if self.bias_deg.written in (0, "0") else f"\nbias {self.bias_deg.written} deg"
        return f"ω = {self.effectiveness.written}{bias}"


@law
def step(p, s, e, row):
    """Apply eq. (6) in place."""
    e.deflection = e.effectiveness * e.deflection + e.bias


stage = Stage(step, PARAMS, STATE, reads=["deflection", "effectiveness", "bias"], writes=["deflection"])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return eq. (6) on each effector; none without such a fault."""
    return [stage.block(np.zeros(len(given.effectors), PARAMS))] if config else []


def prescribe(entry: Config, t: np.ndarray, records: np.ndarray, targets: Targets) -> None:
    """Write omega and v_2a of the effectors at the times t, s, of the window; a bias of a gang by their weights."""
    omega, bias = entry.effectiveness.sample(t), np.radians(entry.bias_deg.sample(t))
    for j, weight in targets[entry.surface].items():
        records["effectors"]["effectiveness"][:, j], records["effectors"]["bias"][:, j] = omega, weight * bias


def warnings(entry: Config, t: np.ndarray, window: str) -> list[tuple[str, str]]:
    """Return (key, line) where omega is over 1; t holds the times of the window that lie in the flight, s."""
    peak = float(entry.effectiveness.sample(t).max()) if t.size else 0.0
    if peak <= 1.0:
        return []
    line = f"over 1 the {entry.surface} does more than commanded; it is flown as written"
    return [("effectiveness", f"{entry.effectiveness.text} reaches {peak:.3g} on {window}; {line}")]


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return eq. (6) of what is reached, with omega and v_2a as they are at the time."""
    gain, offset, now = np.ones(len(reach.low)), np.zeros(len(reach.low)), np.array([rest.t])
    for entry in acting(config, rest.t):
        for j, weight in given.targets[entry.surface].items():
            gain[j] = entry.effectiveness.sample(now)[0]
            offset[j] = weight * np.radians(entry.bias_deg.sample(now)[0])
    return [reach.scaled(gain, offset)]
