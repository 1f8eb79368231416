"""Cascaded attitude autopilot, P on the attitude and PI with damping on the rates: the baseline everyone asks for.

    v1 = g1(x1)^-1 omega_a (x1_c - x1)                      attitude loop: commanded body rates
    e  = v1 - x2
    z' = omega_r^2 e + omega_r B (v2 - v)                   integral term, rad/s^2, with anti-windup
    v  = B^-1 ( 2 omega_r e + z - A x2 )                    rate loop: commanded angular acceleration to deflections
    v2 = v within the limits

The gains follow from the linear pair x2' = A x2 + B v2. B^-1 decouples the axes, -A x2 takes
the place of the aircraft's damping, and what is left on each axis, e' = -2 omega_r e - z, has both poles at -omega_r.
While a surface is at its limit, the last term of z' draws the integral back at the rate omega_r.

Fewer axes: B^-1 is that of the controlled ones (docs/theory.md, "Fewer axes"); without a rudder q and p are commanded
given the measured r, without ailerons q and r alone, and v1 of the missing axis is the measured rate.

Options, rad/s: `attitude_bandwidth` omega_a, 0.5, the bandwidth of the paper's outer loop; `rate_bandwidth` omega_r, 3,
six times faster, so that the two loops do not meet.

Written in plain Python, as an example of `create(design, h, options)`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import cos, remainder, sin, tau
from typing import Any

import numpy as np

from uavftc.control.custom.controller import positive_options
from uavftc.core.axes import embedded, masked, reduced
from uavftc.core.given import ControlDesign
from uavftc.core.statespace import StateSpace

Step = Callable[[float, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, dict[str, np.ndarray]]]


def create(design: ControlDesign, h: float, options: Mapping[str, Any]) -> Step:
    """Return the controller for a sample time h, s."""
    chosen = positive_options(options, attitude_bandwidth=0.5, rate_bandwidth=3.0)
    omega_a, omega_r = chosen["attitude_bandwidth"], chosen["rate_bandwidth"]
    A, axes = design.A, design.axes
    B_inverse = embedded(np.linalg.inv(reduced(design.B, axes)), axes)
    B = design.B if all(axes) else masked(design.B, axes)
    v_min, v_max = design.limits_rad.T
    z = np.zeros(3)  # rad/s^2

    def step(t: float, x1_c: np.ndarray, x1: np.ndarray, x2: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the deflections about trim, rad, and the commanded body rates, rad/s, for the history."""
        nonlocal z
        error = x1_c - x1
        error[2] = remainder(error[2], tau)  # the short way round
        x1_dot = omega_a * error
        if not axes[2]:  # the heading is the airframe's
            x1_dot[2] = (x2[2] + x1_dot[1] * sin(x1[0])) / (cos(x1[0]) * cos(x1[1]))
        v1 = rates_from_euler(x1) @ x1_dot
        if not all(axes):
            v1 = np.where(axes, v1, x2)
        e = v1 - x2
        v = B_inverse @ (2.0 * omega_r * e + z - A @ x2)
        v2 = np.minimum(np.maximum(v, v_min), v_max)
        z = z + h * (omega_r**2 * e + omega_r * (B @ (v2 - v)))
        return v2, {"v1": v1}

    return step


def linear(design: ControlDesign, h: float, options: Mapping[str, Any]) -> StateSpace:
    """Return the law about the trim and without limits: sampled, from [x1, x2], shape (6,), to v2; its state is z."""
    chosen = positive_options(options, attitude_bandwidth=0.5, rate_bandwidth=3.0)
    omega_a, omega_r = chosen["attitude_bandwidth"], chosen["rate_bandwidth"]
    B_inverse = np.linalg.inv(design.B)
    e = np.hstack([-omega_a * rates_from_euler(design.x1_trim), -np.eye(3)])
    return StateSpace(
        np.eye(3),
        h * omega_r**2 * e,
        B_inverse,
        B_inverse @ (2.0 * omega_r * e - np.hstack([np.zeros((3, 3)), design.A])),
    )


def rates_from_euler(x1: np.ndarray) -> np.ndarray:
    """Return g1(x1)^-1, shape (3, 3): x2 = g1^-1 x1' with x1 = [phi, theta, psi], rad."""
    phi, theta = x1[0], x1[1]
    return np.array(
        [
            [1.0, 0.0, -sin(theta)],
            [0.0, cos(phi), sin(phi) * cos(theta)],
            [0.0, -sin(phi), cos(phi) * cos(theta)],
        ]
    )
