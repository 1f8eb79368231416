"""Stages: compiled laws over records, chained over the rows of a flight.

A law is a module with three things: a dtype `PARAMS`, a dtype `STATE` and a function `step(p, s, row)` that reads its
parameters by name, updates its state in place and reads and writes the signal row (`signals.ROW`). `Stage` makes it
callable by address, so that any list of laws composes into one compiled call a sample without compiling the
combination: a `Program` holds the addresses, one C function call a law (about 10 ns).

A record reaches the law as a pointer, so nothing is copied or boxed between the laws.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
import platformdirs
from llvmlite import ir
from numba import carray, types
from numba.extending import intrinsic

from uavftc.signals import ROW

NOTHING = np.dtype([("nothing", "f8")])
"""Parameters or state of a law that has none."""

RAW = np.dtype("f8")
"""State of a law that lays out its own memory: the law gets a pointer to float64."""

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
        with compile_cache():
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


class Program:
    """Blocks run in order on every row: one compiled call for any number of rows."""

    def __init__(self, blocks: Sequence[Block]) -> None:
        self.blocks = tuple(blocks)  # keeps the memory alive that the table points to
        self._table = np.array(
            [(b.stage.address, b.params.ctypes.data, b.state.ctypes.data) for b in self.blocks], dtype=np.int64
        ).reshape(-1, 3)
        with compile_cache():
            self._run = _compiled_run_rows()

    def run(self, rows: np.ndarray, first: int, last: int) -> int:
        """Run all blocks on rows `first` to `last - 1` of `rows`, shape (n, ROW_WIDTH).

        Returns the index of the row at which a block set `status`, or `last`.
        """
        return self._run(self._table, rows, first, last)


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


# --- the cache of compiled laws --------------------------------------------------------------------------------------

_COMPILED = (
    "stage.py",
    "signals.py",
    "kinematics.py",
    "linear3.py",
    "envelope.py",
    "control",
    "sensors",
    "actuators",
    "plants",
)
"""Where compiled code lives. numba notices a change in the file of an entry only; the hash of all of them covers
what the entries call."""


@functools.cache
def compile_cache_dir() -> Path:
    """Return the folder of compiled laws for exactly this source, made if needed.

    It lies in the user's cache (or under NUMBA_CACHE_DIR), never beside the source: an installed package may be
    read-only. Where no such folder can be written, a private temporary one serves for this user.
    """
    here = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    for part in _COMPILED:
        path = here / part
        for file in [path] if path.is_file() else sorted(path.rglob("*.py")):
            digest.update(file.relative_to(here).as_posix().encode() + b"\0" + file.read_bytes())
    name = digest.hexdigest()[:16]
    override = os.environ.get("NUMBA_CACHE_DIR")
    user = Path(override) if override else platformdirs.user_cache_path("uavftc")
    for base in (user, Path(tempfile.gettempdir()) / f"uavftc-{os.getuid() if hasattr(os, 'getuid') else 'user'}"):
        folder = base / name
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if os.access(folder, os.W_OK) and _is_ours(base) and _is_ours(folder):
                return folder
    return Path(tempfile.mkdtemp(prefix="uavftc-"))


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can write there: what lies in the cache is run."""
    if not hasattr(os, "getuid"):
        return True
    status = folder.stat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


def is_compiled() -> bool:
    """Whether an earlier flight has left compiled laws for this source."""
    return any(compile_cache_dir().rglob("*.nbi"))


@contextlib.contextmanager
def compile_cache() -> Iterator[None]:
    """Point numba's cache at our folder while a law is compiled; other users of numba keep theirs."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(compile_cache_dir())
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


__all__ = ["NOTHING", "RAW", "Block", "Program", "Stage", "carray", "compile_cache", "is_compiled", "law", "params_of"]
