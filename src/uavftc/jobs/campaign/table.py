"""The table of a campaign: its columns, the parts it is written in as flights end, and the sorted whole.

A part is a Parquet file that appears under its name when it is complete; pages carry checksums. What is torn, or does
not have these columns, is no part: its flights are flown again. The whole is put together a range of cases at a time.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from uavftc.config.values import is_number
from uavftc.errors import InputError
from uavftc.jobs.campaign.evaluate import METRIC_COLUMNS
from uavftc.jobs.campaign.variants import Variant
from uavftc.scenario.campaign import Campaign, Vary

PARTS = "parts"
HISTORIES = "histories"
TABLE = "flights.parquet"
MERGED_CASES = 4096  # put in order at a time
VARIANT = ("controller", "plant", "aircraft")

_TORN = (OSError, ValueError, KeyError, pa.ArrowException)


def schema_of(campaign: Campaign) -> pa.Schema:
    """Return the columns of a campaign's table; `plant` and `aircraft` are there where the file lists them."""
    fields = [pa.field("case", pa.int64()), pa.field("controller", pa.string())]
    if campaign.plants is not None:
        fields.append(pa.field("plant", pa.string()))
    if campaign.aircraft is not None:
        fields.append(pa.field("aircraft", pa.string()))
    fields += [pa.field(key, _type(vary)) for key, vary in campaign.vary.items()]
    fields += [
        pa.field("outcome", pa.string()),
        pa.field("success", pa.bool_()),
        pa.field("margin", pa.float64()),
        pa.field("limiting", pa.string()),
        *(pa.field(name, pa.float64()) for name in METRIC_COLUMNS),
        pa.field("ended_at_s", pa.float64()),
        pa.field("reason", pa.string()),
        pa.field("wall_s", pa.float64()),
        pa.field("wall_loop_s", pa.float64()),
    ]
    return pa.schema(fields)


def _type(vary: Vary) -> pa.DataType:
    if vary.kind in ("uniform", "normal", "log-uniform"):
        return pa.float64()
    if vary.kind == "integer" or all(isinstance(v, int) and not isinstance(v, bool) for v in vary.given):
        return pa.int64()
    return pa.float64() if all(map(is_number, vary.given)) else pa.string()


def as_cell(value: Any, kind: pa.DataType) -> Any:
    """Return a value as its column holds it: what is no text in a column of texts as JSON."""
    if kind == pa.string() and value is not None and not isinstance(value, str):
        return json.dumps(value)
    return float(value) if kind == pa.float64() and value is not None else value


class Part(NamedTuple):
    """One part on disk."""

    path: Path
    first: int
    """Its smallest case."""
    last: int
    """Its greatest."""


class Table:
    """The table in the making, in a folder.

    Parameters
    ----------
    folder
        Of the campaign.
    schema
        From `schema_of`.
    variants
        In the order of the rows of a case.
    """

    def __init__(self, folder: Path, schema: pa.Schema, variants: Sequence[Variant]) -> None:
        self._folder, self._schema = folder, schema
        self._place = {variant[:3]: place for place, variant in enumerate(variants)}
        self._only = variants[0]
        self._rows: list[dict[str, Any]] = []
        self._parts: list[Part] = []
        self._number = 0

    def read_parts(self, done: np.ndarray) -> int:
        """Take in the parts that are there, mark their flights in `done`, shape (cases, variants), and count torn ones.

        A torn part, and one that repeats a flight, is removed.
        """
        torn = 0
        for path in sorted((self._folder / PARTS).glob("part-*.parquet")):
            self._number = max(self._number, int(path.stem.rpartition("-")[2]))
            try:
                table = _read(path, self._schema)
                cases, places = self._keys(table)
                repeated = done[cases, places].any() or len(set(zip(cases, places, strict=True))) < len(cases)
            except (*_TORN, IndexError):
                repeated = True
            if repeated:
                path.unlink()
                torn += 1
                continue
            done[cases, places] = True
            self._parts.append(Part(path, int(cases.min()), int(cases.max())))
        for left in (self._folder / PARTS).glob(".part-*"):
            left.unlink()
        return torn

    def outcomes(self) -> Iterator[tuple[str, str, bool | None, float | None, int, int]]:
        """Yield controller, outcome, success, margin, case and place of the variant of every flight in the parts."""
        names = ["controller", "outcome", "success", "margin", "case"]
        for part in self._parts:
            table = _read(part.path, self._schema)
            columns = table.select(names).to_pydict()
            places = map(int, self._keys(table)[1])
            yield from zip(*(columns[name] for name in names), places, strict=True)

    def add(self, row: Mapping[str, Any]) -> None:
        """Take a row; it is on disk after the next `flush`."""
        self._rows.append({field.name: as_cell(row.get(field.name), field.type) for field in self._schema})

    @property
    def waiting(self) -> int:
        """Rows that are not on disk yet."""
        return len(self._rows)

    def flush(self) -> None:
        """Write what is waiting as a part.

        Raises
        ------
        OSError
            If there is no room; nothing appears then, and the rows wait on.
        """
        if not self._rows:
            return
        table = pa.Table.from_pylist(self._rows, schema=self._schema)
        path = self._folder / PARTS / f"part-{self._number + 1:06d}.parquet"
        write(path, [table], self._schema)
        cases = [row["case"] for row in self._rows]
        self._parts.append(Part(path, min(cases), max(cases)))
        self._number += 1
        self._rows.clear()

    def merge(self, cases: int) -> None:
        """Write the whole, sorted by case, controller, plant and aircraft."""
        write(self._folder / TABLE, self._sorted(cases), self._schema)

    def _sorted(self, cases: int) -> Iterator[pa.Table]:
        for first in range(0, cases, MERGED_CASES):
            last = min(first + MERGED_CASES, cases) - 1
            here = [part for part in self._parts if part.first <= last and part.last >= first]
            pieces = []
            for part in here:
                piece = _read(part.path, self._schema)
                column = piece["case"]
                pieces.append(piece.filter(pc.and_(pc.greater_equal(column, first), pc.less_equal(column, last))))
            if pieces:
                table = pa.concat_tables(pieces)
                in_case, places = self._keys(table)
                yield table.take(np.lexsort((places, in_case)))

    def _keys(self, table: pa.Table) -> tuple[np.ndarray, np.ndarray]:
        """Return the case and the place of the variant of each row."""
        names = [
            table[name].to_pylist() if name in table.schema.names else [getattr(self._only, name)] * len(table)
            for name in VARIANT
        ]
        return table["case"].to_numpy(), np.array([self._place[key] for key in zip(*names, strict=True)], dtype=int)


def content(folder: Path) -> pa.Table:
    """Return the table of a campaign without its wall-clock times: what two runs of it have in common."""
    table = pq.read_table(folder / TABLE)
    return table.select([name for name in table.column_names if not name.startswith("wall_")])


def clear_parts(folder: Path) -> None:
    """Remove the parts in a campaign's folder, once the whole is there."""
    for pattern in ("part-*.parquet", ".part-*"):
        for path in (folder / PARTS).glob(pattern):
            path.unlink()
    with suppress(OSError):  # not there, or something else in it
        (folder / PARTS).rmdir()


def _read(path: Path, schema: pa.Schema) -> pa.Table:
    table = pq.read_table(path, page_checksum_verification=True)
    if not table.schema.equals(schema) or not len(table):
        raise ValueError("other columns")
    return table


def read_table(path: Path, where: str) -> dict[str, list[Any]]:
    """Return the columns of a table of flights, None where there is no value.

    Raises
    ------
    InputError
        If it cannot be read; `where` names what was asked for.
    """
    try:
        found: dict[str, list[Any]] = pq.read_table(path, page_checksum_verification=True).to_pydict()
    except _TORN as error:
        raise InputError(
            where,
            found=f"{path.name} cannot be read: {str(error).splitlines()[0]}",
            expected="a table of flights as uavftc sweep writes it",
            remedy="fly the campaign again",
        ) from None
    return found


def write(path: Path, tables: Iterator[pa.Table] | Sequence[pa.Table], schema: pa.Schema) -> None:
    """Write a Parquet file that is under its name when it is complete, and on the disk.

    Raises
    ------
    OSError
        If there is no room; nothing is left then.
    """
    with whole(path) as stream, pq.ParquetWriter(stream, schema, write_page_checksum=True) as writer:
        for table in tables:
            writer.write_table(table)


@contextmanager
def whole(path: Path) -> Iterator[BinaryIO]:
    """Give a file to be written that is under its name when it is complete and on the disk, or not at all.

    Raises
    ------
    OSError
        If there is no room; nothing is left then.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}")
    try:
        with partial.open("wb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
