"""The trace of a search: a row a flight, in the order in which the search asked for them.

It is small next to a campaign's table, so it is held whole, and written whole now and then: under its name it is
complete at any moment. A search that is gone on with is told what stands there, and flies on from where that ends.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from uavftc.jobs.campaign.evaluate import PLACE
from uavftc.jobs.campaign.table import VARIANT, as_cell, schema_of, write
from uavftc.jobs.campaign.variants import Variant
from uavftc.results.hold import Hold
from uavftc.scenario.campaign import Campaign

FILE = "search.parquet"
EVERY_S = 5.0
"""Time after which what came in is written: what a killed search loses."""
SPARED = 20.0
"""Times as long as a write took, at least, until the next."""
FLIGHT, STAGE, DISTANCE = "flight", "stage", "distance"

Row = dict[str, Any]


def columns_of(campaign: Campaign) -> pa.Schema:
    """Return the columns: those of a campaign's table, with the number of the flight, its stage and its distance."""
    fields = []
    for field in schema_of(campaign):
        if field.name == "case":
            fields += [field.with_name(FLIGHT), pa.field(STAGE, pa.string())]
        elif field.name == "outcome":
            fields += [pa.field(DISTANCE, pa.float64()), field]
        elif field.name != "success":
            fields.append(field)
    return pa.schema(fields)


class Trace:
    """The rows of all searches of a campaign, by the place of the variant and the number of the flight.

    Parameters
    ----------
    folder
        Where it is written.
    campaign
        What is searched.
    variants
        In the order of the rows.
    """

    def __init__(self, folder: Path, campaign: Campaign, variants: Sequence[Variant]) -> None:
        self._path, self._schema = folder / FILE, columns_of(campaign)
        self._keys = tuple(campaign.vary)
        self._only = variants[0]
        self._place = {variant[:3]: place for place, variant in enumerate(variants)}
        self._rows: dict[tuple[int, int], Row] = {}
        self._written, self._took, self._waiting = time.monotonic(), 0.0, 0

    def read(self) -> None:
        """Take in what is there; what is torn, or has other columns, is no trace."""
        try:
            table = pq.read_table(self._path, page_checksum_verification=True)
            rows = table.to_pylist() if table.schema.equals(self._schema) else []
        except (OSError, ValueError, pa.ArrowException):
            rows = []
        for row in rows:
            controller, plant, aircraft = (row.get(name, getattr(self._only, name)) for name in VARIANT)
            self._rows[self._place[controller, plant, aircraft], row[FLIGHT]] = row

    def known(self, place: int, flight: int, values: Mapping[str, Any]) -> Row | None:
        """Return the row of a flight if it is there, and was flown with these values."""
        row = self._rows.get((place, flight))
        if row is None or any(row[key] != as_cell(values[key], self._schema.field(key).type) for key in self._keys):
            return None
        return row

    def add(self, row: Mapping[str, Any], stage: str, distance: float) -> Row:
        """Take the row of a flight, as an engine gives it; its case is the number of the flight."""
        whole = {**row, FLIGHT: row["case"], STAGE: stage, DISTANCE: distance}
        made = {field.name: as_cell(whole.get(field.name), field.type) for field in self._schema}
        self._rows[row[PLACE], row["case"]] = made
        self._waiting += 1
        return made

    def flush(self, now: bool = False) -> None:
        """Write all rows if something is waiting, and for long enough, or `now`.

        Raises
        ------
        OSError
            If there is no room; what was written before stays.
        """
        began = time.monotonic()
        if not self._waiting or not (now or began - self._written > max(EVERY_S, SPARED * self._took)):
            return
        with Hold():
            write(self._path, [pa.Table.from_pylist(self.rows(), schema=self._schema)], self._schema)
        self._waiting, self._written = 0, time.monotonic()
        self._took = self._written - began

    def rows(self, place: int | None = None) -> list[Row]:
        """Return the rows of one variant, or of all, in order."""
        return [row for (of, _), row in sorted(self._rows.items()) if place in (None, of)]
