"""`history.parquet`: the published columns of a flight, streamed while it flies or written at once, and read back."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from uavftc.core import signals
from uavftc.errors import InputError
from uavftc.flight.recorder import published

METADATA_PREFIX = "uavftc."


class ParquetRecorder:
    """Streams the published columns to a Parquet file, one row group a chunk, so memory does not grow with the flight.

    Columns are float64; NaN is written as null. Two identical flights give identical bytes.

    Parameters
    ----------
    path
        File to write; an existing one is overwritten. Or an output stream of pyarrow, which is closed at the end.
    metadata
        Text kept in the file's metadata, each key with `uavftc.` before it (scenario, versions, seed).
    columns
        What is published: `Flight.columns`, or those of every flight.
    """

    def __init__(
        self, path: Path | Any, metadata: Mapping[str, str], columns: Sequence[signals.Column] = signals.COLUMNS
    ) -> None:
        import pyarrow as pa  # noqa: PLC0415  (0.1 s that a flight without --out need not pay)
        import pyarrow.parquet as pq  # noqa: PLC0415

        self._columns = columns
        self._array = pa.array
        self._batch = pa.record_batch
        self._schema = pa.schema(
            [pa.field(c.name, pa.float64()) for c in columns],
            metadata={METADATA_PREFIX + key: metadata[key] for key in sorted(metadata)},
        )
        # Byte planes of neighbouring doubles are alike: a third smaller and three times faster than a dictionary.
        # as bytes: a path need not be text
        self._file = pa.OSFile(os.fsencode(path), mode="wb") if isinstance(path, os.PathLike) else path
        self._writer = pq.ParquetWriter(
            self._file, self._schema, compression="zstd", use_dictionary=False, use_byte_stream_split=True
        )

    def take(self, records: np.ndarray) -> None:
        """Append the next rows, shape (n,), dtype `signals.ROW`, as one row group."""
        self.take_columns(published(records, self._columns))

    def take_columns(self, columns: Mapping[str, np.ndarray]) -> None:
        """Append the next rows, published columns of shape (n,) each, as one row group."""
        if len(columns["time_s"]):
            arrays = [self._array(columns[name], from_pandas=True) for name in self._schema.names]
            self._writer.write_batch(self._batch(arrays, schema=self._schema))

    def close(self) -> None:
        """Write the footer; without it the file cannot be read. A second call does nothing."""
        try:
            self._writer.close()
        finally:
            self._file.close()

    def __enter__(self) -> ParquetRecorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def write_history(
    path: Path | Any, columns: Mapping[str, np.ndarray], metadata: Mapping[str, str], *, chunk: int
) -> None:
    """Write a whole history, to the byte as `ParquetRecorder` streams it from a flight in chunks.

    Parameters
    ----------
    path, metadata
        As `ParquetRecorder` takes them.
    columns
        Published columns, name to shape (N + 1,).
    chunk
        Rows of a row group.
    """
    with ParquetRecorder(path, metadata, [signals.Column(name, "", None) for name in columns]) as parquet:
        for start in range(0, len(columns["time_s"]), chunk):
            parquet.take_columns({name: values[start : start + chunk] for name, values in columns.items()})


def read_history(path: Path, columns: Iterable[str] | None = None) -> dict[str, np.ndarray]:
    """Return columns of a history file, name to shape (n,) float64, null as NaN.

    Parameters
    ----------
    path
        A `history.parquet`.
    columns
        Names, in the order of the result; all of the file's when None.

    Raises
    ------
    InputError
        If the file is missing, is not Parquet, or lacks one of the columns.
    """
    file = _open(path)
    with file:
        present = file.schema_arrow.names
        names = list(present if columns is None else columns)
        missing = [name for name in names if name not in present]
        if missing:
            raise InputError(
                str(path),
                found=f"no column {', '.join(missing)}",
                expected="a history written by uavftc-fly with these columns",
                remedy="fly the scenario again with this version, or ask for columns the file has",
            )
        table = file.read(columns=names)
    return {name: np.array(table.column(name).to_numpy(), dtype=float) for name in names}


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
        return pq.ParquetFile(pa.OSFile(os.fsencode(path)))
    except (pa.ArrowInvalid, OSError) as error:
        raise InputError(
            str(path),
            found=str(error).splitlines()[0],
            expected="a history.parquet written by uavftc-fly",
            remedy="check the path; fly the scenario again if the file is damaged",
        ) from error
