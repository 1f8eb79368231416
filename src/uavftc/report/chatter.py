"""Curves that chatter: drawn as a band with its mean, so that they hide neither each other nor what is behind them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from uavftc.report.panels import MAX_POINTS, curve

_REACH = 6  # samples to either side
_MEAN = np.array([0.5, *[1.0] * (2 * _REACH - 1), 0.5]) / (2 * _REACH)  # none left of periods 2, 3, 4, 6 and 12


def chattering(y: np.ndarray) -> np.ndarray:
    """Return where y, shape (n,), goes up and down within a few samples, shape (n,), bool.

    That is where its way over 13 samples is more than three times their range: one and a half oscillations or more,
    and more than 1 % of the whole range, about the width of a line.
    Nowhere, unless it is so for more than 2 % of the flight: the ringing after a step is drawn as it is.
    """
    finite = y[np.isfinite(y)]
    if len(y) < 2 or not finite.size:
        return np.zeros(len(y), dtype=bool)
    near = _window(y)
    span = np.ptp(near, axis=1)
    way = np.abs(np.diff(near, axis=1)).sum(axis=1)
    with np.errstate(invalid="ignore"):
        busy = (way > 3.0 * span) & (span > 0.01 * np.ptp(finite))
    busy = np.asarray(_window(busy).any(axis=1))
    return busy if busy.mean() > 0.02 else np.zeros(len(y), dtype=bool)


def chatter(ax: Axes, t: np.ndarray, y: np.ndarray, **look: Any) -> np.ndarray:
    """Draw y over t as `curve` does, but where it chatters its running mean over a band from least to greatest.

    A line that turns back at every sample would be a solid block that hides what is behind it. `look` names a colour.
    Returns the values that the drawing spans.
    """
    busy = chattering(y) if len(t) <= MAX_POINTS else np.zeros(len(t), dtype=bool)
    if not busy.any():
        return curve(ax, t, y, **look)
    near = _window(y)
    even = np.convolve(np.pad(y, _REACH, mode="edge"), _MEAN, mode="valid")
    curve(ax, t, np.where(busy, even, y), **look)
    band: Any = {"linewidth": 0.4, "zorder": 1.5}
    ax.fill_between(t, near.min(axis=1), near.max(axis=1), where=busy.tolist(), color=look["color"], alpha=0.3, **band)
    ax.fill_between([], [], [], color="#888888", alpha=0.4, label="range of chatter", **band)
    return y


def _window(y: np.ndarray) -> np.ndarray:
    """Return each sample with its neighbours, shape (n, 2 _REACH + 1); the ends are repeated."""
    return np.lib.stride_tricks.sliding_window_view(np.pad(y, _REACH, mode="edge"), 2 * _REACH + 1)
