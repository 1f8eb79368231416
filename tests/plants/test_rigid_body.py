"""Eq. (2) in the coefficients c1..c9 against the vector form J^-1 (M - x2 x J x2)."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.plants.rigid_body import coefficients, gyroscopic

HALE_J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])


def random_cases(seed, n):
    """Yield J of physical bodies (any aspect, I_xz of both signs), rates and moments of many sizes."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        spread = 10.0 ** rng.uniform(-1.0, 3.0) * rng.uniform(0.05, 1.0, 3)  # second moments along three axes
        I_x, I_y, I_z = spread.sum() - spread
        I_xz = rng.uniform(-0.95, 0.95) * np.sqrt(spread[0] * spread[2])
        J = np.array([[I_x, 0.0, -I_xz], [0.0, I_y, 0.0], [-I_xz, 0.0, I_z]])
        yield J, rng.normal(size=3) * 10.0 ** rng.uniform(-2, 1), rng.normal(size=3) * 10.0 ** rng.uniform(-2, 4)


def eq2(J, x2, moment):
    """Return x2_dot of eq. (2): the law's torque-free part and the moment terms c3 L + c4 N, c7 M, c4 L + c9 N."""
    c = dict(enumerate(coefficients(J), start=1))
    L, M, N = moment
    driven = np.array([c[3] * L + c[4] * N, c[7] * M, c[4] * L + c[9] * N])
    return driven + gyroscopic(coefficients(J), x2)


def test_eq2_is_the_vector_equation():
    # Given 500 random bodies, the nine coefficients and Euler's vector equation give the same x2_dot to rounding.
    signs = set()
    for J, x2, moment in random_cases(1, 500):
        torque = moment - np.cross(x2, J @ x2)
        expected = np.linalg.solve(J, torque)
        parts = np.abs(np.linalg.inv(J)) @ (np.abs(moment) + np.linalg.norm(J, 2) * (x2 @ x2))  # before cancellation
        np.testing.assert_array_less(np.abs(eq2(J, x2, moment) - expected), 1e-12 * parts)
        signs.add(np.sign(J[0, 2]))
    assert signs == {-1.0, 1.0}


def test_moment_terms_are_the_inverse_of_the_inertia():
    # c3, c4, c7, c9 form J^-1: a rolling moment acts by J^-1, not by 1/I_x.
    columns = np.stack([eq2(HALE_J, np.zeros(3), m) for m in np.eye(3)], axis=1)
    np.testing.assert_allclose(columns, np.linalg.inv(HALE_J), rtol=1e-13)
    assert columns[2, 0] > 0.0  # I_xz = +8435: a positive rolling moment also yaws to the right


def test_free_rotation_does_no_work():
    # The gyroscopic part conserves energy and the size of the momentum: x2 . J x2' = 0 and J x2 . J x2' = 0.
    for J, x2, _ in random_cases(2, 200):
        momentum, rate = J @ x2, J @ np.array(gyroscopic(coefficients(J), x2))
        scale = np.linalg.norm(J, 2) * (x2 @ x2) * np.linalg.cond(J)
        assert abs(x2 @ rate) < 1e-13 * scale * np.linalg.norm(x2)
        assert abs(momentum @ rate) < 1e-13 * scale * np.linalg.norm(momentum)


def test_printed_inertia_gives_the_textbook_coefficients():
    # Hand computation for hale: D = I_x I_z - I_xz^2, c5 = 6048/6314, c6 = 8435/6314.
    D = 52723 * 58771 - 8435**2
    c = coefficients(HALE_J)
    expected = [
        ((6314 - 58771) * 58771 - 8435**2) / D, (52723 - 6314 + 58771) * 8435 / D, 58771 / D, 8435 / D,
        6048 / 6314, 8435 / 6314, 1 / 6314, (52723 * (52723 - 6314) + 8435**2) / D, 52723 / D,
    ]  # fmt: skip
    np.testing.assert_allclose(c, expected, rtol=1e-14)


@pytest.mark.parametrize("change", [(0, 1, 3.0, 3.0), (1, 2, -5.0, -5.0), (0, 2, -8435.0, 8435.0)])
def test_inertia_without_plane_of_symmetry_is_refused(change):
    # Eq. (2) has no place for I_xy or I_yz, and a matrix that is not symmetric is not an inertia: both are refused.
    i, j, upper, lower = change
    J = HALE_J.copy()
    J[i, j], J[j, i] = upper, lower
    with pytest.raises(ValueError, match="symmetric J"):
        coefficients(J)
