"""The closed form of torque-free rotation is checked before it judges anything else."""

from __future__ import annotations

import numpy as np
import pytest
from closed_form import FreeRotation, angle_between, from_euler, legendre_pi
from scipy.integrate import quad

HALE_J = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])
STARTS = [  # rad/s; about the largest axis, about the smallest, signs mixed, middle rate not zero
    (0.1, 0.2, 0.3),
    (0.05, 0.5, -0.02),
    (-0.3, -0.1, 0.2),
    (0.2, -0.4, -0.1),
]


@pytest.mark.parametrize("w0", STARTS)
class TestFreeRotation:
    def test_starts_at_the_given_state(self, w0):
        # Given rates at t = 0 and an attitude, the closed form gives them back; a wrong phase or sign shows here.
        C0 = from_euler(np.array([0.4, -0.3, 2.0]))[0]
        motion = FreeRotation(HALE_J, np.array(w0), C0)
        np.testing.assert_allclose(motion.rates(0.0)[0], w0, atol=1e-13)
        np.testing.assert_allclose(motion.attitude(0.0)[0], C0, atol=1e-13)

    def test_conserves_energy_and_angular_momentum(self, w0):
        # The kinetic energy and the momentum vector in the frame at rest are constants of the motion over 60 s.
        t = np.linspace(0.0, 60.0, 2001)
        motion = FreeRotation(HALE_J, np.array(w0))
        w, C = motion.rates(t), motion.attitude(t)
        energy = np.einsum("ni,ij,nj->n", w, HALE_J, w)
        momentum = np.einsum("nij,jk,nk->ni", C, HALE_J, w)
        np.testing.assert_allclose(energy, energy[0], rtol=1e-12)
        np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-11 * 3e4)

    def test_satisfies_eulers_equations(self, w0):
        # J w' + w x J w = 0 with w' by sixth-order central differences: no integrator is involved.
        t, h = np.linspace(0.1, 60.0, 500), 0.02
        motion = FreeRotation(HALE_J, np.array(w0))
        w_dot = _difference(motion.rates, t, h)
        w = motion.rates(t)
        residual = w_dot @ HALE_J + np.cross(w, w @ HALE_J)
        assert np.max(np.abs(np.linalg.solve(HALE_J, residual.T))) < 1e-9

    def test_attitude_follows_the_rates(self, w0):
        # C' = C [w]x by the same differences: this is what the integral of the third kind must deliver.
        t, h = np.linspace(0.1, 60.0, 500), 0.02
        motion = FreeRotation(HALE_J, np.array(w0))
        C, w = motion.attitude(t), motion.rates(t)
        spin = np.zeros_like(C)
        spin[:, 0, 1], spin[:, 0, 2], spin[:, 1, 2] = -w[:, 2], w[:, 1], -w[:, 0]
        spin -= np.swapaxes(spin, 1, 2)
        assert np.max(np.abs(_difference(motion.attitude, t, h) - C @ spin)) < 1e-9


def test_integral_of_the_third_kind_equals_quadrature():
    # Beyond pi/2 the Carlson forms must be continued by whole periods; quadrature knows nothing of periods.
    n, m = -3.7, 0.4
    for phase in (-4.0, 0.3, 1.5, 1.6, 7.0, 20.0):
        by_quadrature = quad(
            lambda x: 1.0 / ((1.0 - n * np.sin(x) ** 2) * np.sqrt(1.0 - m * np.sin(x) ** 2)), 0.0, phase, limit=400
        )[0]
        assert legendre_pi(phase, n, m) == pytest.approx(by_quadrature, rel=1e-10)


def test_angle_between_reads_a_known_turn():
    # Given a turn of 1e-7 rad about a skew axis, the measure reads 1e-7, where an arc cosine of the trace reads noise.
    C = from_euler(np.array([[0.2, 0.3, 0.4]]))
    D = from_euler(np.array([[0.2 + 1e-7, 0.3, 0.4]]))
    assert angle_between(C, D)[0] == pytest.approx(1e-7, rel=1e-6)


def _difference(f, t, h):
    return (45.0 * (f(t + h) - f(t - h)) - 9.0 * (f(t + 2 * h) - f(t - 2 * h)) + (f(t + 3 * h) - f(t - 3 * h))) / (
        60.0 * h
    )
