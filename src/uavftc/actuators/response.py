"""How a servo moves while its command u is held: first or second order, within limits of rate and position.

First order, w its bandwidth, R its limit of rate:

    y' = w (u - y), at most R in size

    |u - y| > R/w:  y moves at R for (|u - y| - R/w)/R;    then y = u + (y_1 - u) exp(-w t)

Second order, w its natural frequency, zeta its damping, v its rate:

    y' = v,    v' = w^2 (u - y) - 2 zeta w v,    |v| <= R

The rate is held at R as long as v' would have it beyond, as that of a limited integrator. At a limit of its position
a servo stands, its rate lost, until it is commanded back. All of this is exact for a command that is held: the ends of
each phase are found, none is stepped over. Second order is a Taylor series over parts of a step in which it converges
to rounding.
"""

from __future__ import annotations

from math import expm1, inf, isnan, log

from uavftc.core.stage import law

TERMS = 14  # of the series; with w t, 2 zeta w t <= LONGEST its error is below 1e-16
LONGEST = 0.3  # of w t and 2 zeta w t, in one series
HALVINGS = 60
SAME = 1e-12  # relative; times and rates nearer than this are one


@law
def approach(y, u, w, R, t):
    """Return where a servo of first order is after a time t, s, and the integral of its position over it."""
    way = u - y
    far = abs(way) - R / w
    area = 0.0
    if far > 0.0:
        ramp = min(far / R, t)
        moved = y + (R * ramp if way > 0.0 else -R * ramp)
        area, y, t = 0.5 * (y + moved) * ramp, moved, t - ramp
    if t > 0.0:
        if w == inf:
            return (way if isnan(way) else u), area + u * t
        gone = -(y - u) * expm1(-w * t)
        return y - gone, area + u * t + gone / w
    return y, area


@law
def rate_of(y, u, w, R, low, high):
    """Return the rate of a servo of first order at a position, towards u."""
    way = u - y
    if way == 0.0 or (y >= high and way > 0.0) or (y <= low and way < 0.0):
        return 0.0
    rate = min(w * abs(way), R)
    return rate if way > 0.0 else -rate


@law
def first_order(y, u, w, R, low, high, T):
    """Return the position after a step of T, s, and its mean over the step."""
    end, area = approach(y, u, w, R, T)
    if not (end > high or end < low):
        return end, area / T
    stop = high if end > high else low  # it gets there on its way, which does not turn
    t = 0.0
    way = abs(stop - y)
    left = abs(u - stop)
    if way > 0.0:
        first = max(abs(u - y) - R / w, 0.0)  # of the way, at the limit of the rate
        t = min(first, way) / R
        if way > first and w != inf:
            t += log((abs(u - y) - first) / left) / w
    _, area = approach(y, u, w, R, t)
    return stop, (area + stop * (T - t)) / T


@law
def series(y, v, u, w, zeta, t):
    """Return position, rate and integral of the position of a free servo of second order after a time t, s."""
    a, b = y - u, v * t  # two terms that follow each other, of z = y - u
    z, rate, area = a + b, v, (a + 0.5 * b) * t
    first, second = w * w * t * t, 2.0 * zeta * w * t
    for k in range(2, TERMS + 2):
        a, b = b, -(first * a / (k - 1.0) + second * b) / k
        z += b
        rate += k * b / t
        area += b * t / (k + 1.0)
    return u + z, rate, area + u * t


@law
def turn(y, v, u, w, zeta, t, of_rate):
    """Return when a free servo, within a time t, has an acceleration of zero, or a rate of zero; t if it never has."""
    y_t, v_t, _ = series(y, v, u, w, zeta, t)
    before = w * (w * (u - y) - 2.0 * zeta * v) if of_rate else v
    after = w * (w * (u - y_t) - 2.0 * zeta * v_t) if of_rate else v_t
    if not before * after < 0.0:
        return t
    low, high = 0.0, t
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        y_m, v_m, _ = series(y, v, u, w, zeta, middle)
        now = w * (w * (u - y_m) - 2.0 * zeta * v_m) if of_rate else v_m
        if now * before > 0.0:
            low = middle
        else:
            high = middle
    return high


@law
def beyond(y, v, R, low, high):
    """Whether a position or a rate is outside the limits."""
    return abs(v) > R * (1.0 + SAME) or y > high or y < low


@law
def second_order(y, v, u, w, zeta, R, low, high, T, part):
    """Return position and rate after a step of T, s, and the mean of the position; a series takes at most `part`, s."""
    v = v if isnan(v) else min(max(v, -R), R)
    left, area = T, 0.0
    while left > SAME * T:
        a = w * (w * (u - y) - 2.0 * zeta * v)
        if (y >= high and v >= 0.0 and a >= 0.0) or (y <= low and v <= 0.0 and a <= 0.0):
            v = 0.0  # it stands, and will till the end of the step
            if (y >= high and u >= y) or (y <= low and u <= y):
                return y, v, (area + y * left) / T
        if abs(v) >= R and v * a > 0.0:
            t = min(abs(u - y) / R - 2.0 * zeta / w, left)
            to_stop = (high - y if v > 0.0 else y - low) / R
            if t > SAME * T and to_stop > 0.0:
                t = min(t, to_stop)
                y_t = y + v * t
                if t == to_stop:
                    y_t, v = (high, 0.0) if v > 0.0 else (low, 0.0)
                area += 0.5 * (y + y_t) * t
                y, left = y_t, left - t
                continue
        t = min(left, part)
        y_t, v_t, moved = series(y, v, u, w, zeta, t)
        if inf != R or low != -inf or high != inf:
            if (abs(v) + abs(a) * t > R or abs(v_t) > R) and turn(y, v, u, w, zeta, t, True) < t:
                t = turn(y, v, u, w, zeta, t, True)  # rate and position have their extremes at the ends
            t = turn(y, v, u, w, zeta, t, False)
            y_t, v_t, moved = series(y, v, u, w, zeta, t)
            if beyond(y_t, v_t, R, low, high):
                inside, outside = 0.0, t
                for _ in range(HALVINGS):
                    middle = 0.5 * (inside + outside)
                    y_m, v_m, _ = series(y, v, u, w, zeta, middle)
                    if beyond(y_m, v_m, R, low, high):
                        outside = middle
                    else:
                        inside = middle
                t = outside
                y_t, v_t, moved = series(y, v, u, w, zeta, t)
                v_t = min(max(v_t, -R), R)
                if y_t > high or y_t < low:
                    y_t, v_t = min(max(y_t, low), high), 0.0
        y, v, area, left = y_t, v_t, area + moved, left - t
    return y, v, area / T
