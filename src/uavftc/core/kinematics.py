"""Attitude kinematics of eq. (1): Euler angles x1 = [phi, theta, psi] (3-2-1), body rates x2 = [p, q, r]."""

from __future__ import annotations

from math import cos, pi, sin, tan

from uavftc.core.stage import law


@law
def attitude_rates(x1, x2):
    """Return x1_dot = g1(x1) x2, three values, rad/s (eqs. 1 and 5); singular at theta = +-90 deg."""
    s, c = sin(x1[0]), cos(x1[0])
    turn = x2[2] * c + x2[1] * s
    return x2[0] + turn * tan(x1[1]), x2[1] * c - x2[2] * s, turn / cos(x1[1])


@law
def body_rates(x1, x1_dot):
    """Return x2 = g1(x1)^-1 x1_dot, three values, rad/s; defined at every attitude."""
    s, c = sin(x1[0]), cos(x1[0])
    ct = cos(x1[1])
    return (
        x1_dot[0] - x1_dot[2] * sin(x1[1]),
        x1_dot[1] * c + x1_dot[2] * s * ct,
        -x1_dot[1] * s + x1_dot[2] * c * ct,
    )


@law
def to_north_east_down(x1, v):
    """Return the vector v, body axes, in north-east-down axes, three values."""
    sf, cf = sin(x1[0]), cos(x1[0])
    st, ct = sin(x1[1]), cos(x1[1])
    sp, cp = sin(x1[2]), cos(x1[2])
    a = v[1] * sf + v[2] * cf  # v turned by the bank: [v0, b, a]
    b = v[1] * cf - v[2] * sf
    c = v[0] * ct + a * st  # and by the pitch: [c, b, d]
    d = a * ct - v[0] * st
    return c * cp - b * sp, c * sp + b * cp, d


@law
def wrapped(angle):
    """Return the angle moved by whole turns into [-pi, pi), rad, up to rounding at the ends."""
    return (angle + pi) % (2.0 * pi) - pi
