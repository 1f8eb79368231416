"""What a chain of sensors shows of a motion, without a vehicle."""

from __future__ import annotations

import itertools
from types import SimpleNamespace
from typing import Any

import numpy as np

from uavftc import sensors
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.scenario.schema import Sensors


def shown(config: dict[str, Any], x1: Any = 0.0, x2: Any = 0.0, *, n: int = 0, h: float = 0.005, seed: int = 0,
          pieces: tuple[int, ...] = ()) -> np.ndarray:  # fmt: skip
    """Return the records of a motion x1, x2, shape (n, 3), rad and rad/s, at samples h s apart.

    The laws run on the rows up to each of `pieces`, in turn, and then to the end.
    """
    n = n or len(np.asarray(x1 if np.ndim(x1) == 2 else x2))
    rows = empty_rows(n)
    records = as_records(rows)
    records["t"] = np.arange(n) * h
    records["x1"], records["x2"] = x1, x2
    given = SimpleNamespace(h=h, steps=n - 1, seed=seed)
    section = Sensors.model_validate(config)
    program = Program([block for effect in sensors.CHAIN for block in effect.blocks(section, given)])
    for first, last in itertools.pairwise((0, *pieces, n)):
        assert program.run(rows, first, last) == last
    return records
