"""What an aircraft is moved by: its surfaces as roughly measured, the gangs in which they serve the axes, throttles.

Gangs are found by symmetry of the measured effect: two surfaces that mirror each other serve pitch together, and roll
or yaw against each other. Where that leaves more than one gang an axis, all surfaces share each axis instead, by the
weighted pseudo-inverse M = W B^T (B W B^T)^-1, each surface counted against its own reach. For each axis W is weighted
again by what each surface is used, until the sum of the 8th powers of the used shares is least: no surface is at its
end long before the others. Columns are scaled so that 1 rad of an axis moves its most moved surface by 1 rad.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import Surface, mixing_of
from uavftc.analysis.authority import COUPLING_MAX, RESPONSE_MIN
from uavftc.core.signals import SURFACES

MIRROR = 0.1  # relative difference of effect between two surfaces that count as a mirrored pair
WEAK = 0.5  # share of the strongest of an axis below which a mode does not serve it
SHOWN = 0.2  # weight from which a surface counts as a member of a gang
NORM = 8  # of the used shares, see the module; 2 is the plain pseudo-inverse
DAMPED = 1.0 / (NORM - 1)  # part of a new weight that is taken: with more the iteration does not settle
REWEIGHTED = 80  # times
LEAST_USED = 0.02  # share below which a surface counts as used so much
ROLL, PITCH, YAW = range(3)


class Rig(NamedTuple):
    """Surfaces, throttles and how they are moved; n surfaces."""

    surfaces: dict[str, Surface]
    throttles: tuple[str, ...]
    scale: np.ndarray
    """(n,) deflection, rad, per unit of command; nominal where the aircraft reports none."""
    ranges: np.ndarray
    """(n, 2) least and greatest command."""
    backlash: np.ndarray
    """(n,) in units of the command."""
    B: np.ndarray
    """(6, n) change of accelerations per rad of deflection, rough."""
    mixing: np.ndarray
    """(n, 3) deflection per rad of axis command."""
    gangs: dict[str, dict[str, float]]
    axes: tuple[bool, bool, bool]
    way: str = "running"
    """How the engines are started; see `engines.WAYS`."""
    frame_s: float = 5e-3
    """Longest frame that the engines allow."""

    def commands(self, axes: np.ndarray) -> dict[str, float]:
        """Return the command property of each surface for deflections of the axes, shape (3,), rad, about neutral."""
        deflections = self.mixing @ np.asarray(axes)
        return {
            s.command: float(u / k) for s, u, k in zip(self.surfaces.values(), deflections, self.scale, strict=True)
        }

    def slack(self) -> dict[str, float]:
        """Return the backlash by command property."""
        return {s.command: float(b) for s, b in zip(self.surfaces.values(), self.backlash, strict=True)}


class Bench(NamedTuple):
    """An aircraft with what is known of it before any trim."""

    aircraft: Aircraft
    altitude: float
    rig: Rig
    stall: float
    """Of the wing loading, m/s."""
    powered: bool
    """Whether a throttle moves the thrust."""
    engines: int


def axis_limits(limits: np.ndarray, mixing: np.ndarray) -> np.ndarray:
    """Return the deflection that each axis, moved alone, has until its first surface is at a limit, (3, 2), rad."""
    found = np.zeros((3, 2))
    for i in range(3):
        moved = np.abs(mixing[:, i]) > 1e-12
        if np.any(moved):
            ends = np.sort(limits[moved] / mixing[moved, i : i + 1], axis=1)
            found[i] = np.max(ends[:, 0]), np.min(ends[:, 1])
    return found


def arrange(
    names: tuple[str, ...], B: np.ndarray, reach: np.ndarray, declared: Mapping[str, Mapping[str, float]]
) -> tuple[np.ndarray, dict[str, dict[str, float]]]:
    """Return mixing (n, 3) and gangs for surfaces of the effect B, (6, n) per rad, and the reach, (n,), rad."""
    if declared:
        gangs = {axis: dict(members) for axis, members in declared.items()}
        return mixing_of(names, gangs), gangs
    if set(names) <= set(SURFACES):
        gangs = {name: {name: 1.0} for name in names}
        return mixing_of(names, gangs), gangs
    modes = _modes(B[3:], reach)
    chosen = _one_an_axis(modes, B[3:] * reach)
    if chosen is None:
        mixing = shared(B[3:], reach, _axes_of(modes, B[3:] * reach))
    else:
        mixing = np.zeros((len(names), 3))
        for axis, mode in chosen.items():
            mixing[:, axis] = mode * (1.0 if float(B[3 + axis] @ mode) >= 0.0 else -1.0)
    gangs = {
        axis: {n: float(w) for n, w in zip(names, mixing[:, i], strict=True) if abs(w) >= SHOWN}
        for i, axis in enumerate(SURFACES)
        if np.any(mixing[:, i])
    }
    return mixing, gangs


def axes_of(names: tuple[str, ...], B: np.ndarray, reach: np.ndarray, mixing: np.ndarray) -> tuple[bool, bool, bool]:
    """Return whether roll, pitch and yaw can be held by surfaces of the effect B, (6, n) per rad."""
    if set(names) <= set(SURFACES):
        full = np.abs(B[3:] * reach)
        roll, pitch, yaw = (
            s in names and bool(full[i, names.index(s)] >= RESPONSE_MIN) for i, s in enumerate(SURFACES)
        )
        return roll, pitch, yaw
    own = _axes_of(_modes(B[3:], reach), B[3:] * reach)
    held = [i in own and bool(np.any(mixing[:, i])) for i in range(3)]
    return held[ROLL], held[PITCH], held[YAW]


def shared(B: np.ndarray, reach: np.ndarray, axes: list[int]) -> np.ndarray:
    """Return the weighted pseudo-inverse of B, (3, n) 1/s^2 per rad, for the controlled axes; see the module."""
    own, M = B[axes], np.zeros((B.shape[1], 3))
    for row, axis in enumerate(axes):
        share = np.ones(B.shape[1])
        for _ in range(REWEIGHTED):
            W = np.diag(reach**2 / share)
            u = W @ own.T @ np.linalg.solve(own @ W @ own.T, np.eye(len(axes))[row])
            used = np.abs(u) / reach
            asked = np.maximum(used / used.max(), LEAST_USED) ** (NORM - 2)
            share = share ** (1.0 - DAMPED) * asked**DAMPED
        M[:, axis] = u / np.max(np.abs(u))
    return M


def _modes(B: np.ndarray, reach: np.ndarray) -> list[tuple[np.ndarray, bool]]:
    """Return (deflections (n,), symmetric) of each pair's two modes, and of each surface that has no mirror."""
    n, left = B.shape[1], list(range(B.shape[1]))
    full = B * reach
    modes = []
    while left:
        j = left.pop(0)
        partner, sign = None, 1.0
        for k in left:
            for s in (1.0, -1.0):
                mirrored = full[:, k] * np.array([-s, s, -s])
                apart = float(np.linalg.norm(full[:, j] - mirrored)) / max(float(np.linalg.norm(full[:, j])), 1e-12)
                # nothing tells the sign of two surfaces without pitch: the same way up is the same deflection
                lateral = max(abs(full[ROLL, j]), abs(full[YAW, j]))
                if apart < MIRROR and lateral > MIRROR * abs(full[PITCH, j]) and partner is None:
                    partner, sign = k, s
        mode = np.zeros(n)
        mode[j] = 1.0
        if partner is None:
            modes.append((mode, abs(full[PITCH, j]) > max(abs(full[ROLL, j]), abs(full[YAW, j]))))
            continue
        left.remove(partner)
        for symmetric in (True, False):
            both = mode.copy()
            both[partner] = sign if symmetric else -sign
            modes.append((both, symmetric))
    return modes


def _axes_of(modes: list[tuple[np.ndarray, bool]], full: np.ndarray) -> list[int]:
    """Return which axes the surfaces can hold apart from each other; full: (3, n) at full deflection."""
    axes = [PITCH] if np.max(np.abs(full[PITCH]), initial=0.0) > RESPONSE_MIN else []
    lateral = full[[ROLL, YAW]]
    size = np.max(np.abs(lateral), axis=1, initial=0.0)
    if np.all(size > RESPONSE_MIN):
        values = np.linalg.svd(lateral / size[:, None], compute_uv=False)
        if len(values) > 1 and values[1] > values[0] / COUPLING_MAX:
            return sorted([ROLL, *axes, YAW])
    if np.max(size) > RESPONSE_MIN:
        axes.append(ROLL if size[0] >= size[1] else YAW)
    return sorted(axes)


def _one_an_axis(modes: list[tuple[np.ndarray, bool]], full: np.ndarray) -> dict[int, np.ndarray] | None:
    """Return the one mode that serves each axis, or None where more than one would."""
    axes = _axes_of(modes, full)
    effect = [full @ mode for mode, _ in modes]
    chosen: dict[int, np.ndarray] = {}
    taken = set()
    strongest: dict[int, float] = {axis: float(np.max(np.abs([e[axis] for e in effect]))) for axis in axes}
    for axis in axes:
        share = [
            float(abs(e[axis]) / strongest[axis] / sum(abs(e[a]) / strongest[a] for a in axes)) if np.any(e) else 0.0
            for e in effect
        ]
        own = [
            i for i, e in enumerate(effect)
            if modes[i][1] == (axis == PITCH) and abs(e[axis]) > WEAK * strongest[axis]
            and (axis == PITCH or share[i] >= 0.5 or len(axes) < 3)
        ]  # fmt: skip
        if len(own) != 1 or own[0] in taken:
            return None
        taken.add(own[0])
        chosen[axis] = modes[own[0]][0]
    return chosen
