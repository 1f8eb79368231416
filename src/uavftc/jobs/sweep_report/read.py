"""The folder of a campaign, read a column at a time: a million cases take the memory of the columns looked at.

A campaign that is not finished has its flights in parts; those cases count of which every flight is there, so that
controllers are still compared on the same cases. They are put together into one temporary file first: a part is written
every five seconds, and to open thousands of them for each column would take an hour.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from pydantic import ValidationError

from uavftc.errors import InputError
from uavftc.jobs.campaign.identity import FILE
from uavftc.jobs.campaign.scenarios import FOLDER
from uavftc.jobs.campaign.table import PARTS, TABLE, VARIANT, as_cell
from uavftc.jobs.campaign.variants import names_of
from uavftc.results import manifest
from uavftc.scenario.campaign import Campaign

EXPECTED = "the folder of a campaign"


class Flown:
    """The flights of a campaign, as a table of cases by variants.

    Parameters
    ----------
    folder
        That `uavftc sweep` wrote to.

    Raises
    ------
    InputError
        If there is no campaign in it, nothing was flown yet, or something cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.document = _document(folder)
        self.campaign = _campaign(folder, self.document)
        self.summary = manifest.read_summary(folder)
        self.variants = [tuple(key.split(" ", 2)) for key in self.document["variants"]]
        """Controller, plant and aircraft of each."""
        self.names = names_of(self.variants)
        self.torn = 0
        self._file = self._table()
        self._order: np.ndarray | None = None
        self.cases = self._cases()
        """Numbers of the cases that are there whole, ascending, shape (n,)."""
        if not len(self.cases):
            raise _error(folder, "no case of which every flight has ended", "go on with it (uavftc sweep --resume)")

    @property
    def finished(self) -> bool:
        """Whether the campaign has ended."""
        return self.summary is not None

    @property
    def shape(self) -> tuple[int, int]:
        """Cases and variants."""
        return len(self.cases), len(self.variants)

    def numbers(self, column: str) -> np.ndarray:
        """Return a column of numbers, shape (cases, variants); NaN where there is none."""
        return self._numbers(column).reshape(self.shape)

    def texts(self, column: str) -> tuple[np.ndarray, list[str]]:
        """Return a column of texts as places in a list, shape (cases, variants), -1 where there is none, and that."""
        places, words = self._texts(column)
        return places.reshape(self.shape), words

    def input(self, key: str) -> tuple[np.ndarray, list[str] | None]:
        """Return what a varied key took, shape (cases,), and the words that the numbers stand for where it is a text.

        Words are in the order of the file.
        """
        if not self._is_text(key):
            return self._numbers(key).reshape(self.shape)[:, 0], None
        places, words = self.texts(key)
        given = [as_cell(value, pa.string()) for value in self.campaign.vary[key].given]
        known = [word for word in dict.fromkeys(given) if word in words]
        back = np.array([known.index(word) for word in words])
        return back[places[:, 0]].astype(float), known

    def value(self, key: str, number: float, words: Sequence[str] | None) -> Any:
        """Return a value as the campaign's file has it, from what `input` gives."""
        if words is not None:
            word = words[int(number)]
            return next(v for v in self.campaign.vary[key].given if as_cell(v, pa.string()) == word)
        whole = pa.types.is_integer(self._schema.field(key).type)
        return int(number) if whole else float(number)

    def scenario(self, place: int) -> Path | None:
        """Return the file of a variant's scenario; None in the folder of an earlier version."""
        path = self.folder / FOLDER / f"{self.names[place]}.yaml"
        return path if path.is_file() else None

    def _table(self) -> Path:
        """Return the file of the table, and set its columns."""
        if self.finished:
            try:
                self._schema = pq.read_schema(self.folder / TABLE)
            except (OSError, pa.ArrowException) as error:
                raise self._unreadable(error) from None
            return self.folder / TABLE
        temporary = tempfile.mkdtemp(prefix="uavftc-")
        weakref.finalize(self, shutil.rmtree, temporary, ignore_errors=True)
        path = Path(temporary) / TABLE
        writer: pq.ParquetWriter | None = None
        for part in sorted((self.folder / PARTS).glob("part-*.parquet")):
            try:
                piece = pq.read_table(part, page_checksum_verification=True)
                writer = writer or pq.ParquetWriter(path, piece.schema)
                writer.write_table(piece)
            except (OSError, ValueError, pa.ArrowException):
                self.torn += 1
        if writer is None:
            remedy = "fly it (uavftc sweep --resume), then ask for the report"
            raise _error(self.folder, "a campaign of which nothing was flown yet", remedy)
        writer.close()
        self._schema = pq.read_schema(path)
        return path

    def _unreadable(self, error: Exception) -> InputError:
        said = " ".join(str(error).split())[:200]
        return _error(self.folder / TABLE, f"a table that cannot be read: {said}", "fly the campaign again")

    def _is_text(self, column: str) -> bool:
        return bool(pa.types.is_string(self._schema.field(column).type))

    def _read(self, column: str) -> pa.ChunkedArray:
        try:
            return pq.read_table(self._file, columns=[column])[column]
        except (OSError, KeyError, pa.ArrowException) as error:
            raise self._unreadable(error) from None

    def _ordered(self, values: np.ndarray) -> np.ndarray:
        return values if self._order is None else values[self._order]

    def _numbers(self, column: str) -> np.ndarray:
        read = self._read(column)
        if pa.types.is_boolean(read.type):
            read = read.cast(pa.int8())
        return self._ordered(np.asarray(read.cast(pa.float64()).to_numpy(), dtype=float))

    def _texts(self, column: str) -> tuple[np.ndarray, list[str]]:
        read = self._read(column).dictionary_encode().combine_chunks()
        places = pc.fill_null(read.indices, -1).to_numpy()
        return self._ordered(places), read.dictionary.to_pylist()

    def _cases(self) -> np.ndarray:
        """Return the whole cases, and set the order of the rows where it is not that of the table."""
        cases = self._read("case").to_numpy()
        places = self._places(len(cases))
        many = len(self.variants)
        if len(cases) % many == 0 and (places == np.tile(np.arange(many), len(cases) // many)).all():
            first = cases[::many]
            if (cases == np.repeat(first, many)).all() and (np.diff(first) > 0).all():
                return np.asarray(first)
        order = np.lexsort((places, cases))
        numbers, counts = np.unique(cases, return_counts=True)
        there = numbers[counts == many]
        self._order = order[np.isin(cases[order], there)]
        return np.asarray(there)

    def _places(self, rows: int) -> np.ndarray:
        """Return the place of the variant of each row."""
        names = [(i, name) for i, name in enumerate(VARIANT) if name in self._schema.names]
        key = np.zeros(rows, dtype=np.int64)
        known = np.zeros(len(self.variants), dtype=np.int64)
        for i, name in names:
            places, words = self._texts(name)
            key = key * (len(words) + 1) + places
            known = known * (len(words) + 1) + np.array([_index(words, variant[i]) for variant in self.variants])
        sorted_known = np.argsort(known)
        found = np.searchsorted(known[sorted_known], key)
        return np.asarray(sorted_known[np.minimum(found, len(known) - 1)])


def _index(words: Sequence[str], word: str) -> int:
    return words.index(word) if word in words else len(words)


def _document(folder: Path) -> dict[str, Any]:
    if not folder.is_dir():
        raise _error(folder, "a file" if folder.exists() else "no such folder", "check the path")
    try:
        document = json.loads((folder / FILE).read_text(encoding="utf-8"))
        if isinstance(document, dict) and isinstance(document["variants"], dict) and document["campaign"]["vary"] != 0:
            return document
    except FileNotFoundError:
        remedy = "name the folder that uavftc sweep wrote to, such as results/sweep-paper-faults"
        raise _error(folder, f"no {FILE} in it", remedy) from None
    except (OSError, ValueError, KeyError, TypeError):
        pass
    raise _error(folder / FILE, "something else than uavftc sweep writes there", "fly the campaign again")


def _campaign(folder: Path, document: Mapping[str, Any]) -> Campaign:
    try:
        said = dict(document["campaign"])
        said["vary"] = {one["key"]: {k: v for k, v in one.items() if k != "key"} for one in said["vary"]}
        return Campaign.model_validate(said)
    except (ValidationError, KeyError, TypeError):
        raise _error(folder / FILE, "a campaign that this version cannot read", "fly it again") from None


def _error(where: Path, found: str, remedy: str) -> InputError:
    return InputError(str(where), found=found, expected=EXPECTED, remedy=remedy)
