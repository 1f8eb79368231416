"""The smooth stand-in for the saturation: eqs. (20) to (24).

    h(v)  = u_max tanh(v / u_max)        for v >= 0
            |u_min| tanh(v / |u_min|)    for v < 0
    h*    = h(v) / v, the slope of the mean value theorem (22), in (0, 1], 1 at v = 0
    e_h   = sat(v) - h(v),   so that   sat(v) = h* v + e_h

Limits are u_min < 0 < u_max, rad, and need not balance. e_h has the sign of v: for v >= 0 it rises from 0 to
u_max (1 - tanh 1) at v = u_max and falls towards 0 beyond; for v < 0 it falls to u_min (1 - tanh 1) at v = u_min. The
paper writes the second as u_min (tanh 1 - 1), its magnitude.

This is the device of the analysis. Flights are limited by the hard saturation (`actuators/saturation.py`); nothing
that flies uses this module. An infinite limit is no limit: h(v) = v there.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def saturated(v: Any, u_min: float, u_max: float) -> np.ndarray:
    """Return sat(v), eq. (20), same shape as v, rad."""
    _check(u_min, u_max)
    return np.clip(np.asarray(v, float), u_min, u_max)


def smooth(v: Any, u_min: float, u_max: float) -> np.ndarray:
    """Return h(v), eq. (21), same shape as v, rad."""
    return slope(v, u_min, u_max) * np.asarray(v, float)


def slope(v: Any, u_min: float, u_max: float) -> np.ndarray:
    """Return h* = h(v)/v, eq. (23), same shape as v; 1 at v = 0."""
    _check(u_min, u_max)
    v = np.asarray(v, float)
    z = np.abs(v) / np.where(v >= 0.0, u_max, -u_min)
    return np.divide(np.tanh(z), z, out=np.ones_like(z), where=z > 0.0)


def smoothing_error(v: Any, u_min: float, u_max: float) -> np.ndarray:
    """Return e_h = sat(v) - h(v), eq. (24), same shape as v, rad; it has the sign of v."""
    return saturated(v, u_min, u_max) - smooth(v, u_min, u_max)


def smoothing_error_bound(u_min: float, u_max: float) -> float:
    """Return the bound of |e_h|, rad: the larger of u_max (1 - tanh 1) and |u_min| (1 - tanh 1), below eq. (24)."""
    _check(u_min, u_max)
    return float(max(u_max, -u_min) * (1.0 - np.tanh(1.0)))


def _check(u_min: float, u_max: float) -> None:
    if not u_min < 0.0 < u_max:
        raise ValueError(f"limits must satisfy u_min < 0 < u_max, not {u_min} and {u_max}")
