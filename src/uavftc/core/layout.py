"""The effectors of an aircraft: their order in a row, how they serve the axes, and what is published of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from uavftc.core.signals import AXES, COLUMNS, MORE_COLUMNS, SURFACES, Column, Shape

Gangs = Mapping[str, Mapping[str, float]]
"""The effectors of each axis, by the name of its surface, and the weight of each."""

Targets = Mapping[str, Mapping[int, float]]
"""What a fault or a limit may name: an effector or a gang, with the places of its effectors and the weight of each."""

OWN_GANGS: Gangs = {name: {name: 1.0} for name in SURFACES}
"""One surface an axis."""


class OwnSignal(NamedTuple):
    """A signal of a custom controller's own: a number or several, which are drawn together."""

    name: str
    unit: str
    """As declared: rad/s; 1 where there is none."""
    columns: tuple[str, ...]
    """Of the history, one for each number."""
    labels: tuple[str, ...] = ()
    """Of each number; empty of a single one."""


class Layout(NamedTuple):
    """Effectors, in their order in a row, n of them, SI and radians; and what else a flight publishes of its own."""

    names: tuple[str, ...] = SURFACES
    mixing: np.ndarray = np.eye(3)
    """Deflection of each effector per rad of axis command, shape (n, 3)."""
    gangs: Gangs = OWN_GANGS
    trim_rad: np.ndarray = np.zeros(3)
    """Deflection at trim, shape (n,)."""
    position_sign: np.ndarray = np.ones(3)
    """Of the position that the aircraft reports, per deflection, shape (n,); 0 where it reports none."""
    read: np.ndarray = np.zeros(3, dtype=bool)
    """Whether the plant reads the position in flight; else it is trim + deflection, shape (n,)."""
    sense: np.ndarray = np.ones(3)
    """Of an angle as the aircraft counts it, per deflection, shape (n,): 1 or -1, on every plant."""
    engines: tuple[str, ...] = ()
    """Names of the engines, in their order in a row."""
    servos: tuple[str, ...] = ()
    """Effectors to which the scenario gives a servo that takes time; where it is, is published."""
    signals: tuple[OwnSignal, ...] = ()
    """Of a custom controller, in their order in a row."""
    moments: np.ndarray | None = None
    """J B_m of the linear model: moment about body x, y, z, N m, per rad of aileron, elevator, rudder, shape (3, 3)."""

    @property
    def targets(self) -> Targets:
        """What a fault or a limit may name."""
        return targets_of(self.names, self.gangs)

    @property
    def shape(self) -> Shape:
        """What a row has behind its head."""
        return Shape(len(self.names), len(self.engines), sum(len(signal.columns) for signal in self.signals))

    @property
    def shown_sign(self) -> np.ndarray:
        """Of the position that is published, per that of the row, shape (n,): 1 or -1."""
        return np.where(self.position_sign == 0.0, 1.0, self.position_sign)

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the history: common ones and those of the effectors, more of the vehicle, a controller's own.

        Of an effector that has the name of an axis' surface, the position is published where it reports one; of any
        other its command and its position, trim included, counted as the aircraft counts them. A servo is counted as
        `<effector>_rad` is. The moments are those of the linear model about the trim, asked by v2 and given by u2.
        """
        own = []
        for j, name in enumerate(self.names):
            sign = float(self.shown_sign[j])
            if name not in SURFACES:
                own.append(Column(f"{name}_cmd_rad", "command", None, j, sign, float(self.trim_rad[j])))
                own.append(Column(f"{name}_rad", "position", None, j, sign))
            elif self.position_sign[j]:
                own.append(Column(f"{name}_position_rad", "position", None, j, sign))
            if name in self.servos:
                about = (1.0, 0.0) if name in SURFACES else (sign, float(self.trim_rad[j]))
                own.append(Column(f"{name}_servo_rad", "servo", None, j, *about))
        names = [name for signal in self.signals for name in signal.columns]
        signals = [Column(name, "signals", i) for i, name in enumerate(names)]
        return (*COLUMNS, *own, *MORE_COLUMNS, *self._moments(), *self._engines(), *signals)

    def _moments(self) -> Iterator[Column]:
        if self.moments is not None:
            for kind, field in (("asked", "v2"), ("given", "u2")):
                for axis, (a, e, r) in zip(AXES, self.moments.tolist(), strict=True):
                    yield Column(f"{axis}_moment_{kind}_nm", field, None, weights=(a, e, r))

    def _engines(self) -> Iterator[Column]:
        for j, name in enumerate(self.engines):
            yield Column(f"{name}_throttle", "throttle", None, engine=j)
            yield Column(f"{name}_thrust_n", "thrust", None, engine=j)


def targets_of(names: Sequence[str], gangs: Gangs) -> Targets:
    """Return what a fault or a limit may name; a gang goes before an effector of the same name."""
    own = {name: {j: 1.0} for j, name in enumerate(names)}
    return own | {gang: {names.index(name): w for name, w in members.items()} for gang, members in gangs.items()}


def shares(mixing: np.ndarray) -> np.ndarray:
    """Return what each axis gets per deflection of each effector, shape (n, 3): the transposed pseudo-inverse.

    Exact where no effector serves two axes, and where what they give to one cancels in the other.
    """
    gram = mixing.T @ mixing
    size = np.diag(gram)
    if np.array_equal(gram, np.diag(size)):
        return np.divide(mixing, size, out=np.zeros_like(mixing, dtype=float), where=size > 0.0)
    return np.linalg.pinv(mixing).T
