"""What every plant offers the flight loop."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from uavftc.core.program import Program
from uavftc.core.stage import Block


class Timing(NamedTuple):
    """How a plant's time advances."""

    h: float
    """Sample time of the controller, s."""
    substeps: int
    """Plant steps a sample."""

    @property
    def plant_step(self) -> float:
        """Time step of the plant, s."""
        return self.h / self.substeps


class State:
    """The places of what describes a vehicle that is held: m/s, rad, rad, rad, rad, rad/s about the vertical, 0..1."""

    AIRSPEED, ALPHA, BETA, BANK, PITCH, TURN, THROTTLE = range(7)
    COUNT = 7


class Plant(Protocol):
    """A vehicle: it writes its state into each row, and moves on under the deflections it finds there."""

    x1_trim: np.ndarray
    """Attitude of the trim, shape (3,), rad: references and the heading of the networks count from here."""

    u_limits: np.ndarray
    """Mechanical stops: least and greatest deflection of each effector about trim, shape (n, 2), rad."""

    settings: dict[str, Any]
    """How it is integrated and started; recorded with the results."""

    program_substeps: int
    """Plant steps a row that the program takes by itself: all of a compiled plant, 1 of one that drives them."""

    takes_end: bool
    """Whether it takes a deflection as that at the end of a plant step: else it holds it over the step."""

    def before(self) -> list[Block]:
        """Return the blocks that run at the start of a row, before the controller."""

    def given(self) -> list[Block]:
        """Return the blocks that run at the end of a row's sample: what the plant is given once a row."""

    def after(self) -> list[Block]:
        """Return the blocks that run at each plant step, after the actuators."""

    def look(self) -> None:
        """Take in the vehicle as it is, for blocks of `before` that run before the plant does; `run` does by itself."""

    def run(self, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        """Fly rows `first` to `last - 1`; return the row at which the vehicle was lost, or `last`."""
