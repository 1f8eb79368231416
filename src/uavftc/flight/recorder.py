"""What takes the rows of a flight: the interface, the columns that are published, and a recorder in memory.

A flight hands out its rows as successive chunks, each row once and in order. Chunks share no memory, so a
recorder may keep them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from uavftc.core import signals


class Recorder(Protocol):
    """Anything that takes the chunks of a flight."""

    def take(self, records: np.ndarray) -> None:
        """Take the next rows, shape (n,), dtype `signals.ROW`; nobody changes them any more."""


def published(records: np.ndarray, columns: Sequence[signals.Column] = signals.COLUMNS) -> dict[str, np.ndarray]:
    """Return columns of `records` (dtype `signals.row_type`), name to shape (n,) float64; NaN is missing."""
    return {c.name: signals.column(records, c) for c in columns}


class MemoryRecorder:
    """Keeps the whole flight in memory, every field of the row included (about 0.5 kB a row)."""

    def __init__(self) -> None:
        self._chunks: list[np.ndarray] = []

    def take(self, records: np.ndarray) -> None:
        """Keep the next rows, shape (n,), dtype `signals.ROW`."""
        self._chunks.append(records)

    def records(self) -> np.ndarray:
        """Return all rows so far, shape (N,), dtype `signals.ROW`."""
        if len(self._chunks) != 1:
            self._chunks = [np.concatenate(self._chunks) if self._chunks else np.empty(0, signals.ROW)]
        return self._chunks[0]
