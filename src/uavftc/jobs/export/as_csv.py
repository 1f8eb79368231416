"""A history as CSV: a line of names, a line a sample, each number as its shortest text that reads back the same."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np


def write_csv(path: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write columns, name to shape (n,), as UTF-8 text with commas; what is not a number is an empty cell.

    Raises
    ------
    OSError
        If there is no room for it.
    """
    import pyarrow as pa  # noqa: PLC0415 - 0.1 s
    from pyarrow import csv  # noqa: PLC0415

    table = pa.table({name: pa.array(values, pa.float64(), from_pandas=True) for name, values in columns.items()})
    options = csv.WriteOptions(quoting_style="none", quoting_header="none")
    with path.open("wb") as stream:
        csv.write_csv(table, stream, options)
