"""The 1-cosine gust of airworthiness codes (CS-23.333(c), MIL-F-8785C 3.7.1.3), with an optional hold."""

from __future__ import annotations

import numpy as np


def one_minus_cosine(t: np.ndarray, *, start: float, ramp: float, hold: float) -> np.ndarray:
    """Return the profile of a gust of unit peak at the times t, s, same shape.

    It rises as (1 - cos(pi (t - start) / ramp)) / 2 over `ramp` s, holds for `hold` s and falls as it rose.
    """
    tau = np.asarray(t, dtype=float) - start
    fall = tau - ramp - hold
    phase = np.where(tau < ramp, tau, np.where(fall < 0.0, ramp, ramp - fall)) / ramp
    return 0.5 * (1.0 - np.cos(np.pi * np.clip(phase, 0.0, 1.0)))
