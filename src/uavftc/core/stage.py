"""Stages: compiled laws over records, chained over the rows of a flight.

A law is a module with three things: a dtype `PARAMS`, a dtype `STATE` and a function `step(p, s, row)` that reads its
parameters by name, updates its state in place and reads and writes the signal row (`signals.ROW`). `Stage` makes it
callable by address, so that any list of laws composes into one compiled call a sample without compiling the
combination: a `Program` holds the addresses, one C function call a law (about 10 ns).

A record reaches the law as a pointer, so nothing is copied or boxed between the laws.

Between compiled blocks a `PythonBlock` may stand, a step in plain Python; the blocks between two of them stay one
compiled call, and a program without any is one.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.extending import intrinsic

from uavftc.core.compile_cache import compile_cache, is_compiled, outside
from uavftc.core.signals import ROW

NOTHING = np.dtype([("nothing", "f8")])
"""Parameters or state of a law that has none."""

RAW = np.dtype("f8")
"""State of a law that lays out its own memory: the law gets a pointer to float64."""

STEP_FAILED = -1.0
"""Status of a row at which a step in plain Python failed; what it said is `Program.failure`."""

_STATUS = ROW.fields["status"][1] // 8  # type: ignore[index]

law = numba.njit(error_model="numpy")
"""Decorator of every compiled function. IEEE arithmetic: a division by zero gives inf, never an exception."""


class Stage:
    """A law made callable by address.

    Parameters
    ----------
    params, state
        The law's record types; `RAW` for memory that the law lays out itself.

    Use as a decorator on the three-line entry that turns pointers into records::

        @Stage(PARAMS, STATE)
        def stage(p, s, row):
            step(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])

    Compilation happens when the address is first asked for, and is cached on disk.
    """

    def __init__(self, params: np.dtype, state: np.dtype) -> None:
        self.params = params
        self.state = state
        self._entry: Callable[..., None] | None = None

    def __call__(self, entry: Callable[..., None]) -> Stage:
        """Take the entry function; return the stage itself."""
        self._entry = entry
        self.__doc__ = entry.__doc__
        return self

    @functools.cached_property
    def address(self) -> int:
        """Address of the compiled entry, a C function `void (params*, state*, row*)`."""
        pointers = [_pointer(dtype) for dtype in (self.params, self.state, ROW)]
        assert self._entry is not None
        with compile_cache(outside(self._entry)):
            compiled = numba.cfunc(types.void(*pointers), cache=True, error_model="numpy")(self._entry)
        self._keep_alive = compiled
        return int(compiled.address)

    def block(self, params: np.ndarray | None = None, state: np.ndarray | None = None) -> Block:
        """Return this stage with its memory; zeros where none is given."""
        return Block(
            self,
            np.zeros(1, self.params) if params is None else params,
            np.zeros(1, self.state) if state is None else state,
        )


class Block(NamedTuple):
    """One stage with the memory it works on."""

    stage: Stage
    params: np.ndarray
    state: np.ndarray


def params_of(dtype: np.dtype, **values: object) -> np.ndarray:
    """Return one parameter record of `dtype`, shape (1,), every field given by keyword.

    Raises
    ------
    TypeError
        If a field is missing or unknown.
    """
    names = set(dtype.names or ())
    if names != set(values):
        raise TypeError(f"parameters {sorted(names ^ set(values))} are missing or unknown")
    record = np.zeros(1, dtype)
    for name, value in values.items():
        record[name] = value
    return record


class StepFailed(Exception):  # noqa: N818 - it ends a flight, and says why
    """Raised by the step of a `PythonBlock` that cannot go on; its text becomes the reason of the flight's end."""


class PythonBlock(NamedTuple):
    """A step in plain Python: it is given the row, shape (ROW_WIDTH,), float64, and may write into it."""

    step: Callable[[np.ndarray], None]


class Program:
    """Blocks run in order on every row: one compiled call for any number of rows, if all of them are compiled."""

    def __init__(self, blocks: Sequence[Block | PythonBlock]) -> None:
        self.blocks = tuple(blocks)  # keeps the memory alive that the tables point to
        self.failure: str | None = None
        """Why a Python step failed, once one has."""
        parts: list[list[Block] | PythonBlock] = [[]]
        for block in self.blocks:
            if isinstance(block, PythonBlock):
                parts += [block, []]
            else:
                parts[-1].append(block)  # type: ignore[union-attr]  # always a list
        self._table = _table(parts[0])  # type: ignore[arg-type]
        # the steps in order, of one row each; empty where all blocks are compiled
        self._parts = [part.step if isinstance(part, PythonBlock) else _table(part) for part in parts if part]
        if len(parts) == 1:
            self._parts = []
        with compile_cache():
            self._run = _compiled_run_rows()
        self.run: Callable[[np.ndarray, int, int], int] = (
            self._run_in_parts if self._parts else functools.partial(self._run, self._table)
        )
        """run(rows, first, last): run all blocks on rows `first` to `last - 1`, shape (n, ROW_WIDTH).

        Returns the index of the row at which a block set `status`, or `last`. Bound once: it is called every sample.
        """

    def _run_in_parts(self, rows: np.ndarray, first: int, last: int) -> int:
        run = self._run
        for k in range(first, last):
            for part in self._parts:
                if isinstance(part, np.ndarray):
                    run(part, rows, k, k + 1)
                    continue
                try:
                    part(rows[k])
                except StepFailed as failure:  # what comes after it in the row has nothing to act on
                    self.failure = str(failure)
                    rows[k, _STATUS] = STEP_FAILED
                    return k
            if rows[k, _STATUS] != 0.0:
                return k
        return last


def _table(blocks: Sequence[Block]) -> np.ndarray:
    """Return the addresses of compiled blocks, shape (n, 3), as the kernel runs them."""
    return np.array(
        [(b.stage.address, b.params.ctypes.data, b.state.ctypes.data) for b in blocks], dtype=np.int64
    ).reshape(-1, 3)


def _pointer(dtype: np.dtype) -> Any:
    return types.CPointer(types.float64 if dtype == RAW else numba.from_dtype(dtype))


@intrinsic
def _call(_context, function, params, state, row):
    """Call the C function at an address with three addresses."""
    signature = types.void(types.int64, types.int64, types.int64, types.int64)

    def generate(context, builder, _signature, args):
        address = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [address] * 3)
        target = builder.inttoptr(args[0], kind.as_pointer())
        builder.call(target, [builder.inttoptr(arg, address) for arg in args[1:]])
        return context.get_dummy_value()

    return signature, generate


def _run_rows(table, rows, first, last):
    base = rows.ctypes.data
    for k in range(first, last):
        row = base + k * rows.strides[0]
        for i in range(table.shape[0]):
            _call(table[i, 0], table[i, 1], table[i, 2], row)
        if rows[k, _STATUS] != 0.0:
            return k
    return last


@functools.cache
def _compiled_run_rows() -> Callable[..., int]:
    signature = types.int64(types.int64[:, ::1], types.float64[:, ::1], types.int64, types.int64)
    return numba.njit(signature, cache=True)(_run_rows)


__all__ = [
    "NOTHING", "RAW", "STEP_FAILED", "Block", "Program", "PythonBlock", "Stage", "StepFailed", "carray",
    "compile_cache", "is_compiled", "law", "params_of",
]  # fmt: skip
