"""What a flight gives to the laws and effects that are built for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from uavftc.core.axes import ALL, Controlled
from uavftc.core.layout import OWN_GANGS, Gangs, Targets, targets_of
from uavftc.core.signals import SURFACES


class ControlDesign(NamedTuple):
    """What a controller may be designed from: x2' = A x2 + B v2 about the trim, and the limits of v2."""

    A: np.ndarray
    """Rotational state matrix, shape (3, 3), 1/s, of x2 = [p, q, r]."""
    B: np.ndarray
    """Control matrix, shape (3, 3), 1/s^2 per rad of [aileron, elevator, rudder]; a column of zeros where
    `axes` is false."""
    limits_rad: np.ndarray
    """Least and greatest deflection about trim, shape (3, 2), rad: saturation, servos and stops, inf where there are
    none; 0 where `axes` is false."""
    x1_trim: np.ndarray
    """Attitude of the trim [phi, theta, psi], shape (3,), rad."""
    name: str
    """Of the aircraft."""
    axes: Controlled = ALL
    """Whether roll, pitch and yaw are controlled; what is commanded about another axis has no effect."""
    effectors: tuple[str, ...] = SURFACES
    """Names of the n effectors, in the order of their positions."""
    positions_trim_rad: np.ndarray = np.zeros(3)
    """Position of each effector at trim, as it counts it, shape (n,), rad."""
    mixing: np.ndarray = np.eye(3)
    """Position of each effector about trim, as it counts it, per rad of v2, shape (n, 3)."""


class Given(NamedTuple):
    """A flight as its blocks see it."""

    h: float
    """Sample time of the controller, s."""
    plant_step: float
    """Time step of the plant, s; the actuators run at it."""
    steps: int
    """Controller steps of the flight."""
    seed: int
    """Of everything random."""
    effectors: tuple[str, ...]
    """Names of the effectors, in their order in a row."""
    stops_rad: np.ndarray
    """Mechanical stops of each effector: least and greatest deflection about trim, shape (n, 2), rad."""
    mixing: np.ndarray
    """Effector commands from axis commands, shape (n, 3): deflection = mixing v2."""
    design: ControlDesign
    """What the controller is designed from."""
    gangs: Gangs = OWN_GANGS
    """Effectors of each axis and their weights."""
    trim_rad: np.ndarray | None = None
    """Deflection of each effector at trim, shape (n,), rad; None is 0."""
    read: np.ndarray | None = None
    """Whether the plant reads the position of each effector, shape (n,); None of none."""
    sense: np.ndarray | None = None
    """Of an angle as the aircraft counts it, per deflection of each effector, shape (n,): 1 or -1; None is 1."""
    span_m: float | None = None
    """Wing span, m; None where nothing says it."""
    servos: tuple[Mapping[str, float], ...] = ()
    """What the aircraft's own servo of each effector does, as `aircraft.effectors.SERVO` names it; empty where it moves
    none by itself, or the plant knows of none."""
    at_end: bool = False
    """Whether the plant takes a deflection as that at the end of a plant step, and not as held over it."""
    faults: tuple[Any, ...] = ()
    """Entries of the scenario's `faults`, of every kind."""
    damage: tuple[Any, ...] = ()
    """Entries of the scenario's `damage`."""

    @property
    def targets(self) -> Targets:
        """What a fault or a limit may name."""
        return targets_of(self.effectors, self.gangs)

    def faults_of(self, kind: type) -> list[tuple[int, Any]]:
        """Return the faults of one kind, each with its place in the scenario's list."""
        return [(i, fault) for i, fault in enumerate(self.faults) if isinstance(fault, kind)]

    @property
    def axes(self) -> Controlled:
        """Whether roll, pitch and yaw are controlled."""
        return self.design.axes

    @property
    def psi_0(self) -> float:
        """Heading at the start, rad."""
        return float(self.design.x1_trim[2])
