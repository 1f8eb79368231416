"""The history of a flight: NumPy arrays by column name, and whole as a table of another library."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from uavftc.api.tables import table
from uavftc.errors import InputError


class History(Mapping[str, np.ndarray]):
    """Every recorded signal of a flight, name to shape (N + 1,), float64, NaN where there is none (docs/history.md)."""

    def __init__(self, columns: Mapping[str, np.ndarray]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self._columns[name]
        except KeyError:
            near = difflib.get_close_matches(str(name), self._columns, n=1)
            raise KeyError(f"no column {name}" + (f"; did you mean {near[0]}?" if near else "")) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to_pandas(self) -> Any:
        """Return a `pandas.DataFrame`, a row a sample, `time_s` as its index.

        Raises
        ------
        InputError
            If pandas is not installed.
        """
        return to_pandas(self._columns, "History.to_pandas").set_index("time_s")

    def to_arrow(self) -> Any:
        """Return a `pyarrow.Table`."""
        import pyarrow as pa  # noqa: PLC0415 - 0.1 s

        return pa.table(self._columns)

    def __repr__(self) -> str:
        rows = len(next(iter(self._columns.values()), ()))
        return f"History: {rows} samples of {len(self)} columns: {', '.join(list(self)[:6])}, ..."

    def _repr_html_(self) -> str:
        rows = [(name, float(y[0]), float(np.nanmin(y)), float(np.nanmax(y)), float(y[-1]))
                for name, y in self._columns.items() if np.isfinite(y).any()]  # fmt: skip
        return table(["column", "first", "least", "greatest", "last"], rows, repr(self).partition(":")[0])


def to_pandas(columns: Mapping[str, Any], where: str) -> Any:
    """Return columns as a `pandas.DataFrame`.

    Raises
    ------
    InputError
        If pandas is not installed; `where` was asked for it.
    """
    try:
        pandas: Any = importlib.import_module("pandas")  # an extra
    except ImportError:
        raise InputError(
            where,
            found="no pandas in this environment",
            expected="pandas, which uavftc does not need for itself",
            remedy="pip install pandas",
        ) from None
    return pandas.DataFrame(columns)
