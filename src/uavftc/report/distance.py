"""How far two flights of the same scenario are apart: attitude and body rates, sample by sample."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from uavftc.core.signals import ANGLES, AXES, RATES

History = Mapping[str, np.ndarray]

_LARGEST = 1e9  # deg; beyond it a flight has diverged, and its square would overflow


def attitude_difference(a: History, b: History, angle: str) -> np.ndarray:
    """Return a - b of one attitude angle (phi, theta, psi), deg in (-180, 180], shape (n,).

    Each angle is counted from its own reference, which is the trim attitude plus the commanded change, so two plants
    that trim at different attitudes do not differ for that. n is the number of rows that both have; what has diverged
    is NaN.
    """
    n = rows_in_common(a, b)
    one, other = (np.degrees(h[f"{angle}_rad"][:n] - h[f"{angle}_ref_rad"][:n]) for h in (a, b))
    return 180.0 - np.mod(180.0 - _bounded(one - other), 360.0)


def rate_difference(a: History, b: History, rate: str) -> np.ndarray:
    """Return a - b of one body rate (p, q, r), deg/s, shape (n,); see `attitude_difference`."""
    n = rows_in_common(a, b)
    return _bounded(np.degrees(a[f"{rate}_radps"][:n] - b[f"{rate}_radps"][:n]))


def rows_in_common(a: History, b: History) -> int:
    """Return how many rows both flights have; both are sampled at the same times."""
    return min(len(a["time_s"]), len(b["time_s"]))


def distance(a: History, b: History) -> dict[str, Any]:
    """Return the distance between two flights as `summary.json` of a comparison holds it.

    Returns
    -------
    `rows` compared, and under `attitude_deg` and `rates_degps`, for roll, pitch, yaw and `all` three, `rms` (over the
    rows; `all`: over rows and axes) and `largest` absolute difference; None where there is nothing to compare.
    """
    attitude = [attitude_difference(a, b, angle) for angle in ANGLES]
    rates = [rate_difference(a, b, rate) for rate in RATES]
    return {"rows": rows_in_common(a, b), "attitude_deg": _sizes(attitude), "rates_degps": _sizes(rates)}


def _sizes(differences: list[np.ndarray]) -> dict[str, dict[str, float | None]]:
    sizes: dict[str, dict[str, float | None]] = {}
    for axis, values in zip([*AXES, "all"], [*differences, np.concatenate(differences)], strict=True):
        finite = values[np.isfinite(values)]
        sizes[axis] = {
            "rms": float(np.sqrt(np.mean(finite**2))) if finite.size else None,
            "largest": float(np.abs(finite).max()) if finite.size else None,
        }
    return sizes


def _bounded(values: np.ndarray) -> np.ndarray:
    return np.where(np.abs(values) < _LARGEST, values, np.nan)
