"""Rotation of a rigid body with a plane of symmetry: eq. (2) and its coefficients.

    p' = (c1 r + c2 p) q            + c3 L + c4 N
    q' = c5 p r - c6 (p^2 - r^2)    + c7 M
    r' = (c8 p - c2 r) q            + c4 L + c9 N

The paper names c1..c9 without printing them; these are the standard ones (Stevens, Lewis and Johnson, Aircraft Control
and Simulation, 3rd ed., section 1.7), identical to x2' = J^-1 (M - x2 x J x2).
"""

from __future__ import annotations

import numpy as np

from uavftc.core.stage import law


def coefficients(J: np.ndarray) -> np.ndarray:
    """Return [c1, ..., c9], shape (9,), SI, from the inertia matrix J, shape (3, 3), kg m^2.

    J has the product of inertia in the off-diagonal with its matrix sign: J[0, 2] = -I_xz. J[0, 1] and J[1, 2] must
    be zero (plane of symmetry).

    Raises
    ------
    ValueError
        If J is not symmetric about the x-z plane.
    """
    if J[0, 1] or J[1, 2] or not np.array_equal(J, J.T):
        raise ValueError("eq. (2) holds for a symmetric J with J_xy = J_yz = 0")
    I_x, I_y, I_z, I_xz = J[0, 0], J[1, 1], J[2, 2], -J[0, 2]
    D = I_x * I_z - I_xz**2
    return np.array(
        [
            ((I_y - I_z) * I_z - I_xz**2) / D,
            (I_x - I_y + I_z) * I_xz / D,
            I_z / D,
            I_xz / D,
            (I_z - I_x) / I_y,
            I_xz / I_y,
            1.0 / I_y,
            (I_x * (I_x - I_y) + I_xz**2) / D,
            I_x / D,
        ]
    )


@law
def gyroscopic(c, x2):
    """Return the torque-free part of x2_dot, three values, rad/s^2, for c of `coefficients` and x2 in rad/s."""
    p, q, r = x2[0], x2[1], x2[2]
    return (
        (c[0] * r + c[1] * p) * q,
        c[4] * p * r - c[5] * (p * p - r * r),
        (c[7] * p - c[1] * r) * q,
    )
