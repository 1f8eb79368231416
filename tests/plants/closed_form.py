"""Torque-free rotation of a rigid body in closed form (Landau and Lifshitz, Mechanics, 3rd ed., sections 36 and 37).

Two principal axes, called a and c here, hold the extreme moments of inertia, b the middle one. The rates are Jacobi
elliptic functions, w_a ~ cn, w_b ~ sn, w_c ~ dn, with c the extreme axis on the side of which the motion lies. Measured
from the fixed direction of the angular momentum, two Euler angles follow from the rates; the third, the precession, is
an incomplete elliptic integral of the third kind, here by Carlson's symmetric forms.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ellipj, ellipkinc, elliprf, elliprj


def legendre_pi(phase, n, m):
    """Return the incomplete elliptic integral of the third kind at any amplitude, in the convention 1 - n sin^2."""
    turns = np.round(phase / np.pi)
    s, c = np.sin(phase - np.pi * turns), np.cos(phase - np.pi * turns)
    return _pi_within(s, c, n, m) + 2.0 * turns * _pi_within(1.0, 0.0, n, m)


def _pi_within(s, c, n, m):
    """Return it at amplitudes within +-pi/2, given by sine and cosine (DLMF 19.25.14)."""
    x, y, p = c * c, 1.0 - m * s * s, 1.0 - n * s * s
    return s * elliprf(x, y, 1.0) + n / 3.0 * s**3 * elliprj(x, y, 1.0, p)


class FreeRotation:
    """Rates and attitude of a free rigid body at any time.

    Parameters
    ----------
    J
        Inertia matrix, shape (3, 3), with three different principal moments.
    w0
        Body rates at t = 0, shape (3,), rad/s; no rotation about a principal axis alone.
    C0
        Attitude at t = 0, shape (3, 3): body to a frame at rest.
    """

    def __init__(self, J, w0, C0=None):
        moments, axes = np.linalg.eigh(J)  # ascending
        w = axes.T @ w0
        energy2 = moments @ w**2
        momentum = np.sqrt(moments**2 @ w**2)
        if momentum**2 < energy2 * moments[1]:  # the motion lies about the axis of the smallest moment
            moments, axes = moments[::-1], axes[:, ::-1]
        if np.linalg.det(axes) < 0.0:
            axes = axes * np.array([1.0, -1.0, 1.0])
        w = axes.T @ w0
        self._axes, self._C0 = axes, np.eye(3) if C0 is None else C0
        self._moments, self._momentum = moments, momentum
        a, b, c = moments
        low = (energy2 * c - momentum**2) / (c - a)
        self._amplitudes = np.array(
            [
                np.sqrt(low / a),
                np.sign((c - a) * w[2]) * np.sqrt((energy2 * c - momentum**2) / (b * (c - b))),
                np.sign(w[2]) * np.sqrt((momentum**2 - energy2 * a) / (c * (c - a))),
            ]
        )
        self._frequency = np.sqrt((c - b) * (momentum**2 - energy2 * a) / (a * b * c))
        self._m = (b - a) * (energy2 * c - momentum**2) / ((c - b) * (momentum**2 - energy2 * a))
        self._u0 = ellipkinc(np.arctan2(w[1] / self._amplitudes[1], w[0] / self._amplitudes[0]), self._m)

    def _principal(self, t):
        """Return rates in principal axes, shape (n, 3), and the amplitude, shape (n,)."""
        sn, cn, dn, phase = ellipj(self._u0 + self._frequency * np.atleast_1d(t), self._m)
        return np.stack([cn, sn, dn], axis=-1) * self._amplitudes, phase

    def rates(self, t):
        """Return the body rates at the times t, shape (n, 3)."""
        return self._principal(t)[0] @ self._axes.T

    def attitude(self, t):
        """Return the matrices body to rest at the times t, shape (n, 3, 3)."""
        start = self._to_momentum_frame(np.zeros(1))[0]
        to_rest = self._C0 @ start.T
        return to_rest @ self._to_momentum_frame(np.atleast_1d(t))

    def _to_momentum_frame(self, t):
        """Return body to the frame whose z axis is the angular momentum, up to a fixed turn about it."""
        a, b, c = self._moments
        w, phase = self._principal(t)
        n = -c * (b - a) / (a * (c - b))
        # precession rate M (a wa^2 + b wb^2) / (a^2 wa^2 + b^2 wb^2) = M / c + M (1/a - 1/c) / (1 - n sn^2)
        turn = (1.0 / a - 1.0 / c) * legendre_pi(phase, n, self._m) / self._frequency
        precession = self._momentum * (t / c + turn)
        nutation = np.arccos(np.clip(c * w[:, 2] / self._momentum, -1.0, 1.0))
        spin = np.arctan2(a * w[:, 0], b * w[:, 1])
        return _z(precession) @ _x(nutation) @ _z(spin) @ self._axes.T


def _z(angle):
    s, c, o, i = np.sin(angle), np.cos(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[c, -s, o], [s, c, o], [o, o, i]]), -1, 0)


def _x(angle):
    s, c, o, i = np.sin(angle), np.cos(angle), np.zeros_like(angle), np.ones_like(angle)
    return np.moveaxis(np.array([[i, o, o], [o, c, -s], [o, s, c]]), -1, 0)


def from_euler(x1):
    """Return the matrices body to rest, shape (n, 3, 3), of 3-2-1 Euler angles, shape (n, 3), rad."""
    x1 = np.atleast_2d(x1)
    (sp, st, ss), (cp, ct, cs) = np.sin(x1).T, np.cos(x1).T
    return np.moveaxis(
        np.array(
            [
                [ct * cs, sp * st * cs - cp * ss, cp * st * cs + sp * ss],
                [ct * ss, sp * st * ss + cp * cs, cp * st * ss - sp * cs],
                [-st, sp * ct, cp * ct],
            ]
        ),
        -1,
        0,
    )


def angle_between(C, D):
    """Return the angle of the rotation from C to D, shape (n,), rad; exact for small angles too."""
    return 2.0 * np.arcsin(np.clip(np.linalg.norm(C - D, axis=(1, 2)) / np.sqrt(8.0), 0.0, 1.0))
