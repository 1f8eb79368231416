"""Sinks for the history of a flight: in memory, or streamed to `history.parquet`; and the way back.

A flight hands out its rows as successive chunks, each row once and in order, and each chunk in memory of its own: a
recorder may keep it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Protocol

import numpy as np

from uavftc.core import signals
from uavftc.errors import InputError

METADATA_PREFIX = "uavftc."


class Recorder(Protocol):
    """Anything that takes the chunks of a flight."""

    def take(self, records: np.ndarray) -> None:
        """Take the next rows, shape (n,), dtype `signals.ROW`; nobody changes them any more."""


def published(records: np.ndarray) -> dict[str, np.ndarray]:
    """Return every published column of `records` (dtype `signals.ROW`), name to shape (n,) float64; NaN is missing."""
    return {c.name: signals.column(records, c.name) for c in signals.COLUMNS}


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


class ParquetRecorder:
    """Streams the published columns to a Parquet file, one row group a chunk, so memory does not grow with the flight.

    Columns are `signals.COLUMNS` as float64; NaN is written as null. Two identical flights give identical bytes.

    Parameters
    ----------
    path
        File to write; an existing one is overwritten.
    metadata
        Text kept in the file's metadata, each key with `uavftc.` before it (scenario, versions, seed).
    """

    def __init__(self, path: Path, metadata: Mapping[str, str]) -> None:
        import pyarrow as pa  # noqa: PLC0415  (0.1 s that a flight without --out need not pay)
        import pyarrow.parquet as pq  # noqa: PLC0415

        self._array = pa.array
        self._batch = pa.record_batch
        self._schema = pa.schema(
            [pa.field(c.name, pa.float64()) for c in signals.COLUMNS],
            metadata={METADATA_PREFIX + key: metadata[key] for key in sorted(metadata)},
        )
        # Byte planes of neighbouring doubles are alike: a third smaller and three times faster than a dictionary.
        self._writer = pq.ParquetWriter(
            path, self._schema, compression="zstd", use_dictionary=False, use_byte_stream_split=True
        )

    def take(self, records: np.ndarray) -> None:
        """Append the next rows, shape (n,), dtype `signals.ROW`, as one row group."""
        if len(records):
            columns = [self._array(values, from_pandas=True) for values in published(records).values()]
            self._writer.write_batch(self._batch(columns, schema=self._schema))

    def close(self) -> None:
        """Write the footer; without it the file cannot be read. A second call does nothing."""
        self._writer.close()

    def __enter__(self) -> ParquetRecorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def read_history(path: Path, columns: Iterable[str] | None = None) -> dict[str, np.ndarray]:
    """Return columns of a history file, name to shape (n,) float64, null as NaN.

    Parameters
    ----------
    path
        A `history.parquet`.
    columns
        Names wanted, in the order wanted; all of the file's when None.

    Raises
    ------
    InputError
        If the file is missing, is not Parquet, or lacks one of the columns.
    """
    file = _open(path)
    with file:
        present = file.schema_arrow.names
        wanted = list(present if columns is None else columns)
        missing = [name for name in wanted if name not in present]
        if missing:
            raise InputError(
                str(path),
                found=f"no column {', '.join(missing)}",
                expected="a history written by uavftc-fly with these columns",
                remedy="fly the scenario again with this version, or ask for columns the file has",
            )
        table = file.read(columns=wanted)
    return {name: np.array(table.column(name).to_numpy(), dtype=float) for name in wanted}


def read_metadata(path: Path) -> dict[str, str]:
    """Return the text kept in a history file's metadata, keys without the `uavftc.` prefix.

    Raises
    ------
    InputError
        If the file is missing or is not Parquet.
    """
    with _open(path) as file:
        raw = file.schema_arrow.metadata or {}
    text = {key.decode(): value.decode() for key, value in raw.items()}
    return {k.removeprefix(METADATA_PREFIX): v for k, v in text.items() if k.startswith(METADATA_PREFIX)}


def _open(path: Path):  # type: ignore[no-untyped-def]  # a pyarrow type, and pyarrow is imported late
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    try:
        return pq.ParquetFile(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise InputError(
            str(path),
            found=str(error).splitlines()[0],
            expected="a history.parquet written by uavftc-fly",
            remedy="check the path; fly the scenario again if the file is damaged",
        ) from error
