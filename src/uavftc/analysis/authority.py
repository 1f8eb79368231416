"""Can these surfaces fly that step? Authority of each axis against what the controller will demand, at a trim.

The largest demand is the sum of two parts, each taken at its worst:

- the first moment of the step: the inner loop asks for x2_dot = -A_m r with r = D (step), so u = B^-1 A_m r;
- the steady state of bank at constant heading: gravity drives a sideslip until the side force balances it, and the
  surfaces must hold its moments, u = -B^-1 N beta.

An axis that no surface acts on is left to the airframe, and B is that of the others. Without a rudder the heading is
free, and the steady state of bank is a turn: sideslip, r and the deflections that balance side force and moments.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavftc.core.axes import ALL, Controlled, indices, reduced
from uavftc.core.signals import AXES, SURFACES

RESPONSE_MIN = 1e-3  # rad/s^2 at full deflection: below this a surface does not respond
NONLINEAR_MAX = 0.3  # relative difference of the response between two small steps
COUPLING_MAX = 100.0  # condition number of B with each surface scaled to its axis
RATIO_MIN = 1.0  # available over demanded


class Authority(NamedTuple):
    """Demand and supply, shape (3,) each: aileron, elevator, rudder; rad, nan where the axis is not controlled."""

    first: np.ndarray
    """Largest deflection of the step's first moment."""
    steady: np.ndarray
    """Deflection that holds the banked steady state."""
    available: np.ndarray
    """Deflection to the nearer limit."""
    beta: float
    """Sideslip of the banked steady state, rad."""

    @property
    def ratio(self) -> np.ndarray:
        """Available over demanded, (3,); nan where the axis is not controlled."""
        return self.available / np.maximum(np.abs(self.first) + np.abs(self.steady), 1e-12)


def authority(
    A: np.ndarray,
    B: np.ndarray,
    limits: np.ndarray,
    *,
    A_m: np.ndarray,
    bandwidth: np.ndarray,
    step: np.ndarray,
    axes: Controlled = ALL,
) -> Authority:
    """Return the authority for a step of the attitude.

    Parameters
    ----------
    A
        Linear model over [V, alpha, q, theta, beta, p, r, phi], shape (8, 8).
    B
        Change of u, v, w, p, q, r rates of change with the three deflections, shape (6, 3).
    limits
        Least and greatest deflection about trim, shape (3, 2), rad.
    A_m, bandwidth, step
        Reference model (3, 3), 1/s; D of eq. (9), (3,), 1/s; largest step of [phi, theta, psi], (3,), rad.
    axes
        Which axes are controlled; no step is asked of another.
    """
    own, step = indices(axes), np.where(axes, step, 0.0)
    B_own, asked = reduced(B[3:], axes), reduced(A_m * (bandwidth * step), axes)
    first, steady, available = np.full((3, 3), np.nan)
    first[own] = np.max(np.abs(np.linalg.solve(B_own, asked)), axis=1)
    if axes[2]:
        # 0 = Y_beta beta + Y_phi phi; the side force of the surfaces is left out, it is small
        beta = -A[4, 7] * step[0] / A[4, 4] if abs(A[4, 4]) > 1e-6 else 0.0
        moments = np.array([A[5, 4], A[2, 4], A[6, 4]])[own] * beta
        steady[own] = -np.linalg.solve(B_own, moments)
    else:
        beta, steady[own] = _turn(A, B[3:, own], step[0])
    available[own] = np.maximum(np.minimum(-limits[own, 0], limits[own, 1]), 0.0)
    return Authority(first, steady, available, float(beta))


def _turn(A: np.ndarray, B: np.ndarray, phi: float) -> tuple[float, np.ndarray]:
    """Return sideslip, rad, and deflections, rad, of the steady turn at a bank phi, rad, with a free heading.

    B: (3, n) over the rates and the controlled axes. p = -r tan(theta) keeps the bank; the side force of the surfaces
    is left out.
    """
    turning = A[:, 6] - A[7, 6] * A[:, 5]  # of r, with the p that goes with it
    M = np.zeros((4, 2 + B.shape[1]))
    M[:, 0], M[:, 1] = A[[4, 5, 2, 6], 4], turning[[4, 5, 2, 6]]
    M[1:, 2:] = B
    solution = np.linalg.lstsq(M, np.array([-A[4, 7] * phi, 0.0, 0.0, 0.0]), rcond=None)[0]
    return float(solution[0]), solution[2:]


def response(B: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Return what each axis answers to its surface at full deflection, or at 1 rad of one without a stop, rad/s^2."""
    reach = np.max(np.abs(limits), axis=1)
    return np.abs(np.diag(B)) * np.where(np.isinf(reach), 1.0, reach)


def controlled_axes(B: np.ndarray, limits: np.ndarray) -> Controlled:
    """Return whether roll, pitch and yaw answer to a surface by `RESPONSE_MIN` at least.

    B: rotational control matrix (3, 3), 1/s^2 per rad; limits (3, 2), rad. What is no number counts as an answer, for
    `obstacles` to refuse.
    """
    roll, pitch, yaw = (not answer < RESPONSE_MIN for answer in response(B, limits))
    return roll, pitch, yaw


def can_be_held(axes: Controlled) -> bool:
    """Whether an attitude can be held with these axes: pitch, and roll or yaw.

    Without pitch nothing holds the angle of attack, and with it the airspeed; with pitch alone nothing stops a bank
    that grows. Without ailerons the dihedral levels the wings, without a rudder the fin takes the sideslip out.
    """
    roll, pitch, yaw = axes
    return pitch and (roll or yaw)


def obstacles(B: np.ndarray, limits: np.ndarray, nonlinearity: np.ndarray, ratio: np.ndarray | None) -> list[str]:
    """Return why an aircraft cannot be flown by the controller; empty if it can.

    B: rotational control matrix (3, 3), 1/s^2 per rad; limits (3, 2), rad; nonlinearity, ratio: (3,). An axis that is
    not controlled is no obstacle while the others can hold an attitude.
    """
    found = []
    axes, answers = controlled_axes(B, limits), response(B, limits)
    own = indices(axes)
    for j, name in enumerate(SURFACES):
        if not np.isfinite(answers[j]) or (not axes[j] and not can_be_held(axes)):
            found.append(f"no small-signal {name} response: {answers[j]:.2g} rad/s^2 at full deflection")
        elif axes[j] and not nonlinearity[j] < NONLINEAR_MAX:
            found.append(
                f"the {name} response is not linear in the small: {100 * nonlinearity[j]:.0f} % apart between steps "
                "of 0.2 and 1 % of its range"
            )
    if found:
        return found
    part = reduced(B, axes)
    coupling = float(np.linalg.cond(part / np.diag(part)))
    if not coupling < COUPLING_MAX:
        found.append(f"B is ill-conditioned: condition number {coupling:.0f}, each surface scaled to its axis")
    elif ratio is not None:
        found += [
            f"too little {SURFACES[j]} for the reference: {AXES[j]} has {ratio[j]:.2f} times the deflection it needs"
            for j in own
            if not ratio[j] >= RATIO_MIN
        ]
    return found
