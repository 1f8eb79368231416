"""Can these surfaces fly that step? Authority of each axis against what the controller will demand, at a trim.

The largest demand is the sum of two parts, each taken at its worst:

- the first moment of the step: the inner loop asks for x2_dot = -A_m r with r = D (step), so u = B^-1 A_m r;
- the steady state of bank at constant heading: gravity drives a sideslip until the side force balances it, and the
  surfaces must hold its moments, u = -B^-1 N beta.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavftc.core.signals import AXES, SURFACES

RESPONSE_MIN = 1e-3  # rad/s^2 at full deflection: below this a surface does not respond
NONLINEAR_MAX = 0.3  # relative difference of the response between two small steps
COUPLING_MAX = 100.0  # condition number of B with each surface scaled to its axis
RATIO_MIN = 1.0  # available over demanded


class Authority(NamedTuple):
    """Demand and supply, shape (3,) each: aileron, elevator, rudder; rad."""

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
        """Available over demanded, (3,)."""
        return self.available / np.maximum(np.abs(self.first) + np.abs(self.steady), 1e-12)


def authority(
    A: np.ndarray, B: np.ndarray, limits: np.ndarray, *, A_m: np.ndarray, bandwidth: np.ndarray, step: np.ndarray
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
    """
    B_rates = B[3:]
    first = np.max(np.abs(np.linalg.solve(B_rates, A_m * (bandwidth * step))), axis=1)
    # 0 = Y_beta beta + Y_phi phi; the side force of the surfaces is left out, it is small
    beta = -A[4, 7] * step[0] / A[4, 4] if abs(A[4, 4]) > 1e-6 else 0.0
    moments = np.array([A[5, 4], A[2, 4], A[6, 4]]) * beta
    steady = -np.linalg.solve(B_rates, moments)
    available = np.maximum(np.minimum(-limits[:, 0], limits[:, 1]), 0.0)
    return Authority(first, steady, available, float(beta))


def obstacles(B: np.ndarray, limits: np.ndarray, nonlinearity: np.ndarray, ratio: np.ndarray | None) -> list[str]:
    """Return why an aircraft cannot be flown by the controller; empty if it can.

    B: rotational control matrix (3, 3), 1/s^2 per rad; limits (3, 2), rad; nonlinearity, ratio: (3,).
    """
    found = []
    reach = np.max(np.abs(limits), axis=1)
    for j, name in enumerate(SURFACES):
        response = abs(B[j, j]) * reach[j]
        if not response > RESPONSE_MIN:
            found.append(f"no small-signal {name} response: {response:.2g} rad/s^2 at full deflection")
        elif not nonlinearity[j] < NONLINEAR_MAX:
            found.append(
                f"the {name} response is not linear in the small: {100 * nonlinearity[j]:.0f} % apart between steps "
                "of 0.2 and 1 % of its range"
            )
    if found:
        return found
    coupling = float(np.linalg.cond(B / np.diag(B)))
    if not coupling < COUPLING_MAX:
        found.append(f"B is ill-conditioned: condition number {coupling:.0f}, each surface scaled to its axis")
    elif ratio is not None:
        found += [
            f"too little {SURFACES[j]} for the reference: {AXES[j]} has {ratio[j]:.2f} times the deflection it needs"
            for j in range(3)
            if not ratio[j] >= RATIO_MIN
        ]
    return found
