"""What the figures of a flight show next to its history: limits, faults, disturbances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from uavftc.core.axes import ALL, Controlled
from uavftc.core.layout import OwnSignal


class FaultWindow(NamedTuple):
    """A fault on one surface from `start_s` to `end_s` (may reach past the flight), and what to write into it.

    A fault of an effector has one window of its own name, and one for each axis that it serves; so has one of a gang.
    """

    surface: str
    start_s: float
    end_s: float
    label: str
    known_from_s: float | None = None
    """When the controller is told of it; None where it never is. It knows of the end as late."""

    @property
    def known_until_s(self) -> float | None:
        """Until when the controller takes it to last; None where it is never told."""
        return None if self.known_from_s is None else self.end_s + (self.known_from_s - self.start_s)


@dataclass(frozen=True)
class FigureContext:
    """What the figures show next to the history."""

    title: str
    limits_rad: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    """Least and greatest deflection of each surface, rad; None or absent where there is no limit. Of `aileron`,
    `elevator` and `rudder` it is about trim, of any other effector as its position counts, trim included."""
    faults: Sequence[FaultWindow] = ()
    disturbances_s: Sequence[float] = ()
    """Times at which a disturbance begins, ends or changes, s."""
    controlled: Controlled = ALL
    """Whether roll, pitch and yaw are controlled; another axis has neither reference nor command."""
    wind: bool = False
    """Whether the scenario has wind; without it, the figure of the air shows the throttle in its place."""
    twin: Mapping[str, np.ndarray] | None = None
    """Published columns of the same flight without faults, shape (m,) each."""
    signals: Sequence[OwnSignal] = ()
    """A custom controller's own, each with a panel in custom.png."""
