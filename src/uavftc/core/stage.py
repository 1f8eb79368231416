"""Stages: laws over records, made callable by address.

A law is a module with three things: a dtype `PARAMS`, a dtype `STATE` and a function `step`. On a signal row it is
`step(p, s, row)`; on one effector `step(p, s, e, row)`, with `e` a record of `signals.EFFECTOR`, or on one engine, of
`signals.ENGINE`. It reads its parameters by name and updates its state, the row and `e` in place.
`Stage(step, PARAMS, STATE)` compiles it and hands out its address, so that any list of laws composes into one compiled
call a sample without compiling the combination (`program.py`).

A record reaches the law as a pointer, so nothing is copied or boxed between the laws. The law itself is what is
compiled and cached: numba passes a record by its address, and a law that raises returns a status other than 0
(tests/core/test_stage.py pins both).

With NUMBA_DISABLE_JIT=1 the same laws run in plain Python on views of the same memory, for coverage and debugging.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any, NamedTuple

import numba
import numpy as np
from numba import types
from numba.extending import overload

from uavftc.core.compile_cache import compile_cache, is_compiled, outside
from uavftc.core.signals import EFFECTOR, ROW

NOTHING = np.dtype([("nothing", "f8")])
"""Parameters or state of a law that has none."""

RAW = np.dtype("f8")
"""State of a law that lays out its memory itself: the law takes it by `floats`."""

COMPILED = not numba.config.DISABLE_JIT
"""Whether laws are compiled; NUMBA_DISABLE_JIT=1 runs them in plain Python."""

law = numba.njit(error_model="numpy")
"""Decorator of every compiled function. IEEE arithmetic: a division by zero gives inf, never an exception."""


class Stage:
    """A law made callable by address.

    Parameters
    ----------
    step
        `step(p, s, row)`, or `step(p, s, e, row)` of a law on one record behind the head of the row.
    params, state
        The law's record types; state `RAW` for memory that the law lays out itself.
    reads, writes
        Fields of the row, and of the effector, that it reads and writes; None for a law that does not say. A flight
        is not built if a law reads what nothing before it has written.
    on
        What `e` is: `signals.EFFECTOR` or `signals.ENGINE`.

    Compilation happens when the address is first asked for, and is cached on disk.
    """

    def __init__(
        self,
        step: Callable[..., None],
        params: np.dtype = NOTHING,
        state: np.dtype = NOTHING,
        *,
        reads: Sequence[str] | None = None,
        writes: Sequence[str] | None = None,
        on: np.dtype = EFFECTOR,
    ) -> None:
        self.step = step
        self.python: Callable[..., None] = getattr(step, "py_func", step)
        """The law as it is written, uncompiled."""
        self.params = params
        self.state = state
        self.reads = None if reads is None else frozenset(reads)
        self.writes = None if writes is None else frozenset(writes)
        self.each = on if len(inspect.signature(self.python).parameters) == 4 else None
        """Type of the records behind the head of a row that it runs on, one by one; None for a law on the row."""
        self.on_effector = self.each == EFFECTOR
        """Whether it is a law on one effector."""
        self.name = self.python.__module__.rpartition(".")[2]
        self.__doc__ = self.python.__doc__

    @functools.cached_property
    def address(self) -> int:
        """Address of the compiled law: a C function of two words of numba's, then the pointers that it is called with.

        It returns 0, or another number if the law raised.
        """
        signals = (ROW,) if self.each is None else (self.each, ROW)
        signature = types.void(*(_argument(dtype) for dtype in (self.params, self.state, *signals)))
        with compile_cache(outside(self.python)):
            compiled = numba.njit(signature, cache=True, error_model="numpy")(self.python)
        self._keep_alive = compiled
        (result,) = compiled.overloads.values()
        return int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))

    def block(
        self,
        params: np.ndarray | None = None,
        state: np.ndarray | None = None,
        *,
        name: str = "",
        first: int = ROW.itemsize,
    ) -> Block:
        """Return this stage with its memory, named `name` or as the law's module; zeros where none is given.

        On effectors, `params` and `state` hold one entry for each effector, along the first axis; on engines likewise,
        with `first`, the byte of a row at which the engines begin.
        """
        given = params if params is not None else state
        n = 1 if given is None else len(given)
        return Block(
            name or self.name,
            self,
            np.zeros(n, self.params) if params is None else params,
            np.zeros(n, self.state) if state is None else state,
            first,
        )


class Block(NamedTuple):
    """One stage with the memory it works on."""

    name: str
    """Unique in a flight; how others find it."""
    stage: Stage
    params: np.ndarray
    state: np.ndarray
    first: int = ROW.itemsize
    """Byte of a row at which the records begin that it runs on, one by one."""

    @property
    def records(self) -> int:
        """Records that it runs on, one by one; 0 where it runs on the row."""
        return 0 if self.stage.each is None else max(len(self.params), len(self.state))

    @property
    def end(self) -> int:
        """Bytes that a row must have for it."""
        return self.first + (0 if self.stage.each is None else self.records * self.stage.each.itemsize)


class PythonBlock(NamedTuple):
    """A step in plain Python: it is given the row, shape (width,), float64, and may write into it."""

    name: str
    step: Callable[[np.ndarray], None]
    around: Callable[[], AbstractContextManager[object]] = nullcontext
    """What is open around a flight of it."""


class StepFailed(Exception):  # noqa: N818 - it ends a flight, and says why
    """Raised by the step of a `PythonBlock` that cannot go on; its text becomes the reason of the flight's end."""


def params_of(dtype: np.dtype, /, **values: object) -> np.ndarray:
    """Return one parameter record of `dtype`, shape (1,), every field given by keyword.

    A single number fills a vector; a matrix is given whole.

    Raises
    ------
    TypeError
        If a field is missing or unknown.
    ValueError
        If a value has another shape than its field.
    """
    return records_of(dtype, 1, **{name: np.asarray(value)[None] for name, value in values.items()})


def records_of(dtype: np.dtype, n: int, /, **values: object) -> np.ndarray:
    """Return `n` records of `dtype`, shape (n,); each field is given by keyword, one entry a record.

    Raises
    ------
    TypeError
        If a field is missing or unknown.
    ValueError
        If there is not one entry a record, or an entry has another shape than the field (a number fills a vector).
    """
    fields: Mapping[str, Any] = dtype.fields or {}
    if set(fields) != set(values):
        raise TypeError(f"parameters {sorted(set(fields) ^ set(values))} are missing or unknown")
    records = np.zeros(n, dtype)
    for name, value in values.items():
        entries, shape = np.asarray(value), fields[name][0].shape
        if len(entries) != n or (entries.shape[1:] != shape and not (entries.ndim == 1 and len(shape) == 1)):
            raise ValueError(f"parameter {name} has the shape {entries.shape[1:]}, expected {shape}")
        records[name] = entries[:, None] if entries.ndim == 1 and shape else entries
    return records


def floats(memory: Any, n: int) -> Any:
    """Return the memory of a law with the state `RAW` as an array of `n` float64."""
    return memory[:n]


@overload(floats)
def _floats(memory, n):
    if isinstance(memory, types.CPointer):
        return lambda memory, n: numba.carray(memory, n)  # noqa: PLW0108 - numba takes a Python function
    return None


def _argument(dtype: np.dtype) -> Any:
    return types.CPointer(types.float64) if dtype == RAW else numba.from_dtype(dtype)


__all__ = [
    "COMPILED", "NOTHING", "RAW", "Block", "PythonBlock", "Stage", "StepFailed", "compile_cache", "floats",
    "is_compiled", "law", "params_of", "records_of",
]  # fmt: skip
