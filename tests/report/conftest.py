"""Synthetic flights: first-order responses to a step of 5 deg, with the faults of the paper's third scenario."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from uavftc.core import signals
from uavftc.flight.recorder import published

RATE_HZ = 200.0
BANDWIDTH = 0.5  # rad/s


def synthetic_records(rows: int) -> np.ndarray:
    """Return `rows` rows of a flight at 200 Hz, dtype `signals.ROW`."""
    records = signals.as_records(signals.empty_rows(rows))
    t = np.arange(rows) / RATE_HZ
    step = np.deg2rad(5.0)
    decay = np.exp(-BANDWIDTH * t)[:, None]
    records["t"] = t
    records["x1_c"] = step
    records["x1"] = step * (1.0 - decay)
    records["x2"] = records["v1"] = step * BANDWIDTH * decay
    records["v2"] = 0.05 * decay
    records["effectiveness"] = 1.0
    records["effectiveness"][t < 8.0, :2] = 0.5, 0.7
    mixed = (t >= 8.0) & (t < 12.0)
    records["effectiveness"][mixed] = np.stack([0.8 + 0 * t, 0.3 + 0 * t, 0.2 * t], axis=1)[mixed]
    records["bias"][mixed] = np.deg2rad(np.stack([0.1 + 0.5 * np.sin(t), 0.5 - 0.1 * t, 3 * np.cos(0.1 * t)], axis=1))[
        mixed
    ]
    records["u2"] = records["effectiveness"] * np.clip(records["v2"], -0.05, 0.1) + records["bias"]
    records["d2"] = np.deg2rad(np.stack([np.sin(t), np.sin(2 * t), np.sin(3 * t)], axis=1))
    records["f_hat"] = records["d2"]
    records["airspeed"], records["altitude"] = 30.0, 1000.0
    return records


@pytest.fixture
def make_history() -> Callable[[int], dict[str, np.ndarray]]:
    return lambda rows: published(synthetic_records(rows))
