"""Mass, centre of gravity and inertia of a damaged or uncertain vehicle, as sums over pieces; SI, body axes.

Of a body of mass m with second moments S = integral of r r^T about its centre of gravity, J = tr(S) I - S. A damage
that alone changes the mass by dm, moves the centre of gravity by s and changes the inertia about it by dJ is a piece
with the mass dm, the first moment (m + dm) s and the second moment dS + (m + dm) s s^T, all about the centre of gravity
of the undamaged body, dS = tr(dJ)/2 I - dJ. Pieces add up, and so do several damages at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

POINTS = 7
"""Point masses that a piece needs."""


class Piece(NamedTuple):
    """What a damage adds; negative where it takes away."""

    mass: float
    """kg."""
    first: np.ndarray
    """First moment, shape (3,), kg m."""
    second: np.ndarray
    """Second moments, shape (3, 3), kg m^2."""


class Body(NamedTuple):
    """The mass properties of a vehicle."""

    mass: float
    """kg."""
    cg: np.ndarray
    """From the centre of gravity of the undamaged vehicle, shape (3,), m."""
    inertia: np.ndarray
    """About its own centre of gravity, shape (3, 3), kg m^2, matrix signs."""


def second_moments(J: np.ndarray) -> np.ndarray:
    """Return the second moments of a body with the inertia J, shape (3, 3) both; the other way by `inertia_of`."""
    return 0.5 * np.trace(J) * np.eye(3) - J


def inertia_of(S: np.ndarray) -> np.ndarray:
    """Return the inertia of a body with the second moments S, shape (3, 3) both."""
    return np.trace(S) * np.eye(3) - S


def piece_of(entry: Any, mass: float) -> Piece:
    """Return an entry of `damage` as a piece of a vehicle of this mass, kg."""
    return of_change(mass, entry.mass_kg, np.array(entry.cg_m), entry.inertia_kgm2.matrix())


def uncertain_piece(uncertainty: Any, mass: float, J: np.ndarray) -> Piece:
    """Return what an `uncertainty` adds to the nominal vehicle with this mass, kg, and inertia, kg m^2."""
    more = mass * (uncertainty.mass_factor - 1.0)
    return of_change(mass, more, np.array(uncertainty.cg_shift_m), uncertainty.inertia(J) - J)


def of_change(mass: float, more: float, shift: np.ndarray, dJ: np.ndarray) -> Piece:
    """Return the piece that changes mass, kg, centre of gravity, (3,), m, and inertia, (3, 3), kg m^2, by so much."""
    total = mass + more
    return Piece(more, total * shift, second_moments(dJ) + total * np.outer(shift, shift))


def damaged(mass: float, J: np.ndarray, pieces: Sequence[Piece]) -> Body:
    """Return the vehicle of this mass, kg, and inertia, kg m^2, with pieces added."""
    total = mass + sum(piece.mass for piece in pieces)
    cg = sum((piece.first for piece in pieces), np.zeros(3)) / total
    second = sum((piece.second for piece in pieces), second_moments(J)) - total * np.outer(cg, cg)
    return Body(total, cg, inertia_of(second))


def points_of(piece: Piece, d: float) -> tuple[np.ndarray, np.ndarray]:
    """Return `POINTS` point masses with the moments of a piece: masses, kg, shape (n,), and places, m, shape (n, 3).

    The second moments are L_i along their principal axes e_i. At +-d e_i the masses L_i/(2 d^2) +- f.e_i/(2 d) make
    them, and the first moment f; one in the middle makes up the mass.
    """
    along, axes = np.linalg.eigh(piece.second)
    second, first = along / (2.0 * d**2), axes.T @ piece.first / (2.0 * d)
    masses = np.concatenate([second + first, second - first, [piece.mass - 2.0 * np.sum(second)]])
    return masses, np.vstack([d * axes.T, -d * axes.T, np.zeros((1, 3))])


def at_a_time(entries: Sequence[Any]) -> list[tuple[float, list[int]]]:
    """Return which windowed entries act together, each time that changes: (since when, s, places in the list)."""
    edges = sorted({edge for entry in entries for edge in (entry.start_s, entry.end_s) if edge is not None})
    acting = [
        (t, [i for i, e in enumerate(entries) if e.start_s <= t and (e.end_s is None or t < e.end_s)]) for t in edges
    ]
    return [(t, those) for t, those in acting if those]


def impossible(mass: float, J: np.ndarray, pieces: Sequence[Piece]) -> str | None:
    """Return what no rigid body can be about a vehicle (mass, kg, J, kg m^2) with pieces added, in words, or None.

    Where the undamaged one is none either, by the triangle inequality, that is not asked of the damaged one.
    """
    total = mass + sum(piece.mass for piece in pieces)
    if not total > 1e-9 * mass:
        return f"a mass of {total:.6g} kg"
    if not np.all(np.isfinite(damaged(mass, J, pieces).inertia)):
        return "moments of inertia that are not finite"
    principal = np.linalg.eigvalsh(damaged(mass, J, pieces).inertia)
    said = f"principal moments of inertia of {', '.join(f'{value:.6g}' for value in principal)} kg m^2"
    small = 1e-9 * np.trace(J)
    if principal[0] <= small:
        return said
    if np.linalg.eigvalsh(second_moments(J))[0] >= -small and principal[2] > principal[0] + principal[1] + small:
        return f"{said}, the greatest above the sum of the others"
    return None
