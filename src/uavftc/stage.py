"""Names for compiled custom controllers written for an earlier version; see `core.stage`.

In that version the entry of a law was written out, and `Stage` decorated it:

    @Stage(PARAMS, STATE)
    def stage(p, s, row):
        step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])

Such a law still flies: this entry is compiled, and `carray` of a record is the record. New laws are written as
`stage = Stage(step, PARAMS, STATE)`, with `Stage` from `uavftc.core.stage`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import overload

from uavftc.core import stage
from uavftc.core.program import Program
from uavftc.core.stage import NOTHING, RAW, law, params_of

__all__ = ["NOTHING", "RAW", "Program", "Stage", "carray", "law", "params_of"]


def Stage(params: np.dtype, state: np.dtype) -> Callable[[Callable[..., None]], stage.Stage]:
    """Return the decorator that makes a stage of an entry."""
    return lambda entry: stage.Stage(entry, params, state)


def carray(memory: Any, shape: Any) -> Any:
    """Return the records or numbers at a pointer: a record itself, or memory that the law lays out."""
    return memory.reshape(-1)[: int(np.prod(shape))].reshape(shape) if isinstance(memory, np.ndarray) else (memory,)


@overload(carray)
def _carray(memory, shape):
    if isinstance(memory, types.Record):
        return lambda memory, shape: (memory,)
    if isinstance(memory, types.CPointer):
        return lambda memory, shape: numba.carray(memory, shape)  # noqa: PLW0108 - numba takes a Python function
    return None
