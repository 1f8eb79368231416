"""What each fault did by itself: the flight less the same flight without faults, from one event to the next.

The deviation is the difference of the attitude, x1 - x1_twin, the heading's within half a turn. After each onset and
each removal of a fault or a damage, up to the next event or the end of the flight:

    peak        the largest |deviation|, deg, and when
    recovered   how long after the event the deviation stays within `BAND_DEG` until then; None where it does not
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

BAND_DEG = 0.1
"""Recovered is within it, deg: five times the paper's band of convergence, and an attitude sensor's accuracy."""
ANGLES = {"roll": "phi_rad", "pitch": "theta_rad", "yaw": "psi_rad"}


class Window(NamedTuple):
    """A fault or a damage, and when it acts, s; without an end, to that of the flight."""

    key: str
    start_s: float
    end_s: float | None


def deviation_deg(history: Mapping[str, np.ndarray], twin: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the difference of the attitudes over the rows that both have, shape (m, 3), deg."""
    m = min(len(history["time_s"]), len(twin["time_s"]))
    apart = np.column_stack([history[name][:m] - twin[name][:m] for name in ANGLES.values()])
    return np.degrees((apart + np.pi) % (2.0 * np.pi) - np.pi)


def isolated(
    history: Mapping[str, np.ndarray], twin: Mapping[str, np.ndarray], windows: Sequence[Window]
) -> list[dict[str, Any]]:
    """Return, for each window, its `key` and what followed its `onset` and its `removal`; None where it has none.

    Parameters
    ----------
    history, twin
        Published columns of the flight and of its twin, shape (n,) each.
    windows
        Faults and damage.
    """
    apart = deviation_deg(history, twin)
    t = history["time_s"][: len(apart)]
    edges = sorted({edge for w in windows for edge in (w.start_s, w.end_s) if edge is not None})

    def after(event: float | None) -> dict[str, Any] | None:
        if event is None or not len(t) or event > t[-1]:
            return None
        until = next((edge for edge in edges if edge > event), np.inf)
        rows = slice(int(np.searchsorted(t, event - 1e-9)), int(np.searchsorted(t, until - 1e-9)))
        piece, times = np.abs(apart[rows]), t[rows]
        if not len(times):
            return None
        return {axis: _of(piece[:, i], times, event) for i, axis in enumerate(ANGLES)}

    return [{"key": w.key, "onset": after(w.start_s), "removal": after(w.end_s)} for w in windows]


def _of(size: np.ndarray, t: np.ndarray, event: float) -> dict[str, float | None]:
    k = int(np.argmax(size))
    outside = np.flatnonzero(~(size <= BAND_DEG))
    after = int(outside[-1]) + 1 if len(outside) else 0
    return {
        "peak_deg": float(size[k]),
        "peak_at_s": float(t[k]),
        "recovered_after_s": float(t[after] - event) if after < len(t) else None,
    }
