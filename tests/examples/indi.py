"""Incremental dynamic inversion (INDI): it measures what the surfaces do, knows B alone, and is told of no fault.

    u  = u2 + B^-1 (k (v1 - x2) - x2_dot)      deflection that turns the measured acceleration into the wanted one
    v2 = v2 before + c (u - u2)                the command moves until the surface is measured where it is wanted

u2 and x2_dot pass the same filter w / (s + w), so that they belong together.
"""

import numpy as np


def create(design, h, options):
    """Return the controller with its signals; `options` may have k_attitude, k_rate, bandwidth, 1/s, and follow."""
    k_attitude, k_rate = options.get("k_attitude", 0.5), options.get("k_rate", 4.0)
    share = 1.0 - np.exp(-options.get("bandwidth", 30.0) * h)  # of the filter, a sample
    follow = options.get("follow", 0.5)  # c, of what a surface lacks, a sample
    B_inverse, from_positions = np.linalg.pinv(design.B), np.linalg.pinv(design.mixing)
    low, high = design.limits_rad.T
    v2, u2_f, x2_f = np.zeros(3), np.zeros(3), np.zeros(3)

    def step(t, x1_c, x1, x2, *, positions):
        nonlocal v2, u2_f, x2_f
        u2 = from_positions @ (positions - design.positions_trim_rad)
        u2_f = u2_f + share * (u2 - u2_f)
        x2_dot = share * (x2 - x2_f) / h
        x2_f = x2_f + h * x2_dot
        v1 = rates_from_euler(x1) @ (k_attitude * (x1_c - x1))
        u = u2_f + B_inverse @ (k_rate * (v1 - x2) - x2_dot)
        v2 = np.clip(v2 + follow * (u - u2), low, high)
        return v2, {"v1": v1, "x2_dot": x2_dot, "lacking": u - u2}

    return step, {"x2_dot": ("rad/s^2", ("p", "q", "r")), "lacking": ("rad", ("aileron", "elevator", "rudder"))}


def rates_from_euler(x1):
    """Return g1^-1, shape (3, 3): x2 = g1^-1 x1'."""
    (phi, theta, _), s, c = x1, np.sin, np.cos
    return np.array([[1, 0, -s(theta)], [0, c(phi), s(phi) * c(theta)], [0, -s(phi), c(phi) * c(theta)]])
