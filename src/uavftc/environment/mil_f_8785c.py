"""Continuous turbulence by severity, MIL-F-8785C 3.7.2 and 3.7.3: intensity and scale length by height.

Height h above ground. With W20 the wind at 20 ft (6.1 m), below 1000 ft, h in ft (figures 10 and 11):

    L_w = h                                     sigma_w = 0.1 W20
    L_u = L_v = h / (0.177 + 0.000823 h)^1.2    sigma_u = sigma_v = sigma_w / (0.177 + 0.000823 h)^0.4

above 2000 ft, L_u = L_v = L_w = 1750 ft (Dryden) or 2500 ft (von Karman), and sigma_u = sigma_v = sigma_w from figure
7, by altitude and probability of exceedance; between 1000 and 2000 ft, linear between those two. Heights below 10 ft
count as 10 ft. The velocities are those in body axes at every height.

The severities light, moderate and severe are probabilities of 1e-2, 1e-3 and 1e-5 there, and W20 of 15, 30 and 45 kt.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.stage import law

FT_M = 0.3048
"""One foot in metres (international foot, exact)."""

KT_MPS = 1852.0 / 3600.0
"""One knot in m/s (exact)."""

ALTITUDE_M = FT_M * np.array(
    [500.0, 1750.0, 3750.0, 7500.0, 15000.0, 25000.0, 35000.0, 45000.0, 55000.0, 65000.0, 75000.0, 80000.0]
)
"""Altitudes of the table, m: points of MIL-F-8785C figure 7, ft."""

SIGMA_MPS = {
    "light": FT_M * np.array([6.6, 6.9, 7.4, 6.7, 4.6, 2.7, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0]),
    "moderate": FT_M * np.array([8.6, 9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7, 0.0, 0.0, 0.0]),
    "severe": FT_M * np.array([15.6, 17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1]),
}
"""Intensity there, m/s: MIL-F-8785C figure 7, ft/s, read off at a probability of exceedance of 1e-2, 1e-3 and 1e-5."""

WIND_20_FT_MPS = {"light": 15.0 * KT_MPS, "moderate": 30.0 * KT_MPS, "severe": 45.0 * KT_MPS}
"""W20, m/s: MIL-F-8785C, 15, 30 and 45 kt."""

LENGTH_M = {"dryden": 1750.0 * FT_M, "von-karman": 2500.0 * FT_M}
"""Scale length above 2000 ft, m: MIL-F-8785C 3.7.2.1, 1750 and 2500 ft."""

LEAST_M = 10.0 * FT_M  # height to which the formulas of low altitude hold
LOW_M = 1000.0 * FT_M  # up to here those of low altitude
HIGH_M = 2000.0 * FT_M  # from here on those of medium and high altitude


@law
def low(height, wind_20_ft):
    """Return sigma_u = sigma_v, sigma_w, m/s, L_u = L_v and L_w, m, of low altitude; height and W20 in m and m/s."""
    h = min(max(height, LEAST_M), LOW_M) / FT_M
    base = 0.177 + 0.000823 * h
    sigma_w = 0.1 * wind_20_ft
    return sigma_w / base**0.4, sigma_w, h / base**1.2 * FT_M, h * FT_M


@law
def high(height, curve):
    """Return sigma, m/s, at a height, m: linear along a curve at `ALTITUDE_M`, constant beyond its ends."""
    last = len(curve) - 1
    for i in range(1, last + 1):
        if height < ALTITUDE_M[i]:
            part = max(0.0, (height - ALTITUDE_M[i - 1]) / (ALTITUDE_M[i] - ALTITUDE_M[i - 1]))
            return curve[i - 1] + part * (curve[i] - curve[i - 1])
    return curve[last]


@law
def scales(height, wind_20_ft, curve, length):
    """Return sigma_u = sigma_v, sigma_w, m/s, L_u = L_v and L_w, m, at a height above ground, m.

    wind_20_ft: W20, m/s. curve: sigma at `ALTITUDE_M`, m/s. length: that of medium and high altitude, m.
    """
    if height >= HIGH_M:
        sigma = high(height, curve)
        return sigma, sigma, length, length
    sigma_v, sigma_w, L_v, L_w = low(height, wind_20_ft)
    if height <= LOW_M:
        return sigma_v, sigma_w, L_v, L_w
    part, sigma = (height - LOW_M) / (HIGH_M - LOW_M), high(HIGH_M, curve)
    return (
        sigma_v + part * (sigma - sigma_v),
        sigma_w + part * (sigma - sigma_w),
        L_v + part * (length - L_v),
        L_w + part * (length - L_w),
    )
