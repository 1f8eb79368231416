"""What the figures of a flight show next to its history: limits, what happened and when, the moment that decided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from uavftc.core.axes import ALL, Controlled
from uavftc.core.layout import OwnSignal
from uavftc.results.windows import FlightWindow


@dataclass(frozen=True)
class FigureContext:
    """What the figures show next to the history."""

    title: str
    limits_rad: Mapping[str, tuple[float, float] | None] = field(default_factory=dict)
    """Least and greatest deflection of each surface, rad; None or absent where there is no limit. Of `aileron`,
    `elevator` and `rudder` it is about trim, of any other effector as its position counts, trim included."""
    effectors: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """The effectors of each axis, by the name of its surface."""
    windows: Sequence[FlightWindow] = ()
    """Faults, damage, moving air, disturbances and errors of the sensors; figures number them in this order, from 1."""
    ending: tuple[str, str] | None = None
    """How it ended, as `summary.ending_of` says it; None says nothing of it."""
    controlled: Controlled = ALL
    """Whether roll, pitch and yaw are controlled; another axis has neither reference nor command."""
    signals: Sequence[OwnSignal] = ()
    """A custom controller's own, each with a panel in custom.png."""
    limiting: tuple[str, float] | None = None
    """The name of the requirement that limits the verdict, and when, s: marked in every panel."""
    twin: Mapping[str, np.ndarray] | None = None
    """Published columns of the same flight without faults, shape (m,) each: drawn beneath what the vehicle did."""

    def concerning(self, *names: str) -> list[tuple[int, FlightWindow]]:
        """Return the windows that concern one of these signals (see `FlightWindow.concerns`), with their numbers."""
        return [(i, w) for i, w in enumerate(self.windows, 1) if w.concerns.intersection(names)]

    @property
    def has(self) -> frozenset[str]:
        """The kinds of window that there are."""
        return frozenset(window.kind for window in self.windows)
