"""Numbers as they are drawn, on paper and on a page: thinned curves, the span of an axis, what is off scale.

It imports no library that draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

BINS = 2_000  # two points each; a panel is some 700 pixels wide
_LARGEST = 1e9  # beyond it, the end of a diverged flight is not drawn: it would overflow the axes
_BRIEF = 0.005  # share of the samples on either side that may be a spike
_FAR = 4.0  # a spike makes the span of the values at least so many times that of the others
_WOUND_UP_DEG = 30.0  # how far beyond the deflection a command is drawn where there is no limit


def column(history: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return a column to draw, shape (n,): NaN where it is absent or has diverged."""
    values = history.get(name, np.full(len(history["time_s"]), np.nan))
    return np.where(np.abs(values) < _LARGEST, values, np.nan)


def deg(history: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """Return a column in rad as deg, or in rad/s as deg/s; see `column`."""
    return np.rad2deg(column(history, name))


def finite(values: Sequence[np.ndarray]) -> np.ndarray:
    """Return the finite numbers among several arrays, shape (n,)."""
    drawn = np.concatenate([np.ravel(v) for v in values]) if values else np.empty(0)
    found: np.ndarray = drawn[np.isfinite(drawn)]
    return found


def ends(t: np.ndarray) -> tuple[float, float]:
    """Return the first and the last finite time, s; 0 where there is none."""
    found = finite([t])
    return (float(found[0]), float(found[-1])) if found.size else (0.0, 0.0)


def envelope(t: np.ndarray, y: np.ndarray, bins: int = BINS) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples of `extremes`, shape (about 2 bins,), of a curve of shape (n,)."""
    kept = extremes(y, bins)
    return t[kept], y[kept]


def extremes(y: np.ndarray, bins: int = BINS) -> np.ndarray:
    """Return the places of the least and the greatest sample of each of about `bins` stretches, in their order.

    Shape (n,) in, about (2 bins,) out; a spike of a single sample survives, and so do the first and the last sample.
    NaN is passed over, unless the whole stretch is NaN.
    """
    width = -(-len(y) // bins)
    missing = -len(y) % width
    block = np.concatenate([y, np.full(missing, np.nan)]).reshape(-1, width)
    low = np.where(np.isnan(block), np.inf, block).argmin(axis=1)
    high = np.where(np.isnan(block), -np.inf, block).argmax(axis=1)
    start = np.arange(len(block)) * width
    pick = np.stack([np.minimum(low, high), np.maximum(low, high)], axis=1) + start[:, None]
    kept: np.ndarray = np.concatenate([[0], pick.ravel(), [len(y) - 1]])
    return kept


def wound_up(command: np.ndarray, deflection: Sequence[np.ndarray], limits: Sequence[float]) -> list[np.ndarray]:
    """Return what the y-axis is to show of a command, deg: of one far beyond what is deflected or allowed a part.

    That part reaches a span of the limits beyond them, or 30 deg beyond the deflection where there are not two.
    """
    kept, values = finite([*deflection, np.asarray(limits, dtype=float)]), finite([command])
    if not kept.size or not values.size:
        return [command]
    low, high = float(kept.min()), float(kept.max())
    reach = high - low if len(limits) == 2 else max(_WOUND_UP_DEG, high - low)
    return [np.clip(values, low - reach, high + reach)]


def signed(value: float) -> str:
    """Return a number with its sign and three digits that count: +1390."""
    return f"{float(f'{value:.3g}'):+g}"


def span(values: Sequence[np.ndarray], least: float, keep: Sequence[np.ndarray] = ()) -> tuple[float, float]:
    """Return the ends of a y-axis: the finite `values` and `keep`, at least `least` long; a spike of `values` is cut.

    A spike is what at most one per cent of the values do, if it makes their span more than four times as large.
    """
    drawn, kept = finite(values), finite(keep)
    low, high = (float(drawn.min()), float(drawn.max())) if drawn.size else (0.0, 0.0)
    if drawn.size:
        core = [float(v) for v in np.quantile(drawn, (_BRIEF, 1.0 - _BRIEF))]
        length = max(core[1] - core[0], least)
        if high - low > _FAR * length:
            low, high = max(low, core[0] - 0.5 * length), min(high, core[1] + 0.5 * length)
    if kept.size:
        low, high = min(low, float(kept.min())), max(high, float(kept.max()))
    short = max(least - (high - low), 0.0) / 2
    low, high = low - short, high + short
    margin = 0.06 * (high - low)
    return low - margin, high + margin
