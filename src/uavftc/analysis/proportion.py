"""How often a controller succeeds: the interval of a share, and two controllers on the same cases.

Wilson's interval for k successes in n flights (E. B. Wilson, JASA 22, 1927), z the normal quantile:

    (k + z^2/2)/(n + z^2)  -+  z/(n + z^2) sqrt(k (n - k)/n + z^2/4)

It stays inside [0, 1] and is not a point where all flights, or none, succeed. McNemar's exact test (Q. McNemar,
Psychometrika 12, 1947) looks at the cases in which one of two controllers succeeds and the other does not: if neither
were better, each of them would be a coin that falls to either.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import ndtri
from scipy.stats import binomtest

CONFIDENCE = 0.95


def wilson(successes: Any, flights: Any, confidence: float = CONFIDENCE) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the greatest share of Wilson's interval, each of the shape of the arguments.

    Parameters
    ----------
    successes, flights
        Numbers or arrays; without any flight the interval is 0 to 1.
    confidence
        Of the interval, in (0, 1).
    """
    k, n = np.asarray(successes, dtype=float), np.asarray(flights, dtype=float)
    z = float(ndtri(0.5 + 0.5 * confidence))
    middle = (k + 0.5 * z * z) / (n + z * z)
    half = z / (n + z * z) * np.sqrt(k * (n - k) / np.maximum(n, 1.0) + 0.25 * z * z)
    return np.where(k > 0.0, middle - half, 0.0), np.where(k < n, middle + half, 1.0)


def width(successes: Any, flights: Any, confidence: float = CONFIDENCE) -> np.ndarray:
    """Return how wide Wilson's interval is; arguments as those of `wilson`."""
    low, high = wilson(successes, flights, confidence)
    return high - low


def mcnemar(only_first: int, only_second: int) -> float:
    """Return the two-sided p-value of McNemar's exact test; 1 where the two never differ.

    Parameters
    ----------
    only_first, only_second
        Cases in which only the first, or only the second, succeeds.
    """
    differ = only_first + only_second
    return float(binomtest(only_first, differ, 0.5).pvalue) if differ else 1.0
