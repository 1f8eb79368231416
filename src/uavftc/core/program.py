"""Programs: blocks run in order on every row of a flight, in one compiled call.

    on each row                      observe, sensors, controller, ... and then, once for each step of the plant,
    on each plant step of the row    actuators, plant

The blocks of a plant step run on the row itself at its first plant step, so the row keeps what holds from t_k on; at
the others they run on a copy. A block on effectors, or on engines, runs once for each of them.

Between compiled blocks a `PythonBlock` may stand, a step in plain Python; what lies between two of them stays one
compiled call.
"""

from __future__ import annotations

import functools
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from uavftc.core.compile_cache import compile_cache
from uavftc.core.signals import ROW, ROW_WIDTH
from uavftc.core.stage import COMPILED, RAW, Block, PythonBlock, StepFailed

STEP_FAILED = -1.0
"""Status of a row at which a step in plain Python failed."""

STOPPED = -2.0
"""Status of a row that was not flown, or not to its end, because the user wants the flight to end."""

STATUS_SET = -3.0
"""Status of a row at which a law from outside set one, which is not its to set."""

RAISED = -10.0
"""Status of a row at which a compiled law raised: this less the place of its block in the program."""

_STATUS = ROW.fields["status"][1] // 8  # type: ignore[index]

Run = Callable[[int, int], int]
"""run(first, last): run all blocks on rows `first` to `last - 1`.

Returns the index of the row at which a block set `status`, or `last`.
"""


class Program:
    """Blocks run in order on every row.

    Parameters
    ----------
    blocks
        Run once on each row.
    plant_step
        Run after them, `substeps` times on each row: the actuators and, where it is compiled, the plant.
    substeps
        Plant steps a row that the program takes by itself; 1 where the plant drives them, by `again`.

    Raises
    ------
    ValueError
        If two blocks have one name.
    """

    def __init__(
        self, blocks: Sequence[Block | PythonBlock], plant_step: Sequence[Block] = (), *, substeps: int = 1
    ) -> None:
        self.blocks = (*blocks, *plant_step)  # keeps the memory alive that the tables point to
        self.names = tuple(block.name for block in self.blocks)
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"two blocks of one name among {', '.join(self.names)}")
        self.failure: str | None = None
        """Why a step failed, once one has."""
        self.stop: Callable[[], bool] | None = None
        """Asked before each row at which a step in plain Python stands whether the user wants the flight to end."""
        self._substeps = substeps
        self._rows: np.ndarray | None = None
        self._bound: Run = lambda first, last: last
        runs: list[list[tuple[int, Block]]] = [[]]
        self._python: list[PythonBlock] = []
        for i, block in enumerate(self.blocks):
            if isinstance(block, PythonBlock):
                self._python.append(block)
                runs.append([])
            else:
                runs[-1].append((i, block))
        self._tables = [_Table(run) for run in runs]
        self._again = _Table([*enumerate(self.blocks)][len(blocks) :])  # type: ignore[arg-type]  # all are compiled
        self._repeated = len(plant_step)

    def __getitem__(self, name: str) -> Block:
        """Return the compiled block of this name.

        Raises
        ------
        KeyError
            If there is none.
        """
        for block in self.blocks:
            if block.name == name and isinstance(block, Block):
                return block
        raise KeyError(f"no compiled block {name} among {', '.join(self.names)}")

    def split(self, name: str) -> tuple[Program, Program]:
        """Return the program in two, on the same memory: what runs on a row before the block named, and the rest.

        Raises
        ------
        KeyError
            If none of the blocks before a plant step has this name.
        """
        once = len(self.blocks) - self._repeated
        if name not in self.names[:once]:
            raise KeyError(f"no block {name} before a plant step among {', '.join(self.names)}")
        at = self.names.index(name)
        rest = self.blocks[once:]
        return Program(self.blocks[:at]), Program(self.blocks[at:once], rest, substeps=self._substeps)  # type: ignore[arg-type]

    def on(self, rows: np.ndarray) -> Run:
        """Return the program bound to the rows of one chunk, shape (n, width): what is called every sample."""
        if self._rows is not rows:
            self._rows, self._bound = rows, self._bind(rows)
        return self._bound

    def _bind(self, rows: np.ndarray) -> Run:
        *before, last = self._tables
        final = last.on(rows, repeated=self._repeated, substeps=self._substeps)
        if not before:
            return final
        pairs = [(table.on(rows), block.step) for table, block in zip(before, self._python, strict=True)]

        def run(first: int, end: int) -> int:
            stop = self.stop
            for k in range(first, end):
                if stop is not None and stop():
                    rows[k, _STATUS] = STOPPED
                    return k
                for compiled, step in pairs:
                    compiled(k, k + 1)
                    try:
                        step(rows[k])
                    except StepFailed as failure:  # what comes after it in the row has nothing to act on
                        self.failure = str(failure)
                        rows[k, _STATUS] = STEP_FAILED
                        return k
                    except KeyboardInterrupt:  # a second Ctrl-C, in a step that the first one waits for
                        if stop is None or not stop():
                            raise
                        rows[k, _STATUS] = STOPPED
                        return k
                if final(k, k + 1) == k:
                    return k
            return end

        return run

    @property
    def in_python(self) -> bool:
        """Whether a step in plain Python is among the blocks."""
        return bool(self._python)

    @contextmanager
    def around(self) -> Iterator[None]:
        """Open what its steps in plain Python want open around a flight."""
        with ExitStack() as stack:
            for block in self._python:
                stack.enter_context(block.around())
            yield

    def run(self, rows: np.ndarray, first: int, last: int) -> int:
        """Run all blocks on rows `first` to `last - 1`; return the row at which one set `status`, or `last`."""
        return self.on(rows)(first, last)

    def again(self, rows: np.ndarray) -> Callable[[int], bool]:
        """Return step(k), which runs the blocks of a plant step on a copy of row k; False if one set its status."""
        copy = np.zeros((1, rows.shape[1]))
        run = self._again.on(copy)

        def step(k: int) -> bool:
            copy[0] = rows[k]
            if run(0, 1) == 1:
                return True
            rows[k, _STATUS] = copy[0, _STATUS]
            return False

        return step

    def why(self, status: float) -> str | None:
        """Return which step failed at a row of this status and why, or None if none did."""
        if status <= RAISED:
            error = next((table.error for table in (*self._tables, self._again) if table.error), None)
            law = f"the law {self.names[round(RAISED - status)]} raised"
            return f"{law} an exception" if error is None else f"{law} {error}"
        if status == STATUS_SET:
            return "the controller set row.status, which says how a vehicle is lost and is not for a law to set"
        return self.failure if status == STEP_FAILED else None


class _Table:
    """Compiled blocks with their places in the program, as the kernel runs them."""

    def __init__(self, blocks: Sequence[tuple[int, Block]]) -> None:
        self._blocks = blocks
        self.error: str | None = None
        """What a law raised, where the laws run in plain Python and one did."""
        if COMPILED:
            entries = [_entry(place, block) for place, block in blocks]
            self._table = np.array(entries, dtype=np.int64).reshape(-1, _COLUMNS)
            with compile_cache():
                self._kernel = _compiled_kernel()

    def on(self, rows: np.ndarray, *, repeated: int = 0, substeps: int = 1) -> Run:
        """Return the blocks bound to rows; the last `repeated` of them run `substeps` times on each row."""
        for _, block in self._blocks:
            if block.end > (width := rows.shape[1] * 8):
                raise ValueError(f"{block.name} acts on more records than a row of {width} bytes has")
        copy = np.zeros((1, rows.shape[1]))
        if not COMPILED:
            return functools.partial(self._in_python, repeated, substeps, copy, rows)
        n = len(self._blocks)
        bound = np.array(
            [
                *(array.ctypes.data for array in (self._table, copy, rows)),
                *(n, n - repeated, substeps, rows.shape[1], rows.strides[0]),
            ]
        )
        run = functools.partial(self._kernel, bound.ctypes.data)
        self._kept = (self._table, copy, rows, bound)  # addresses keep nothing alive
        return run

    def _in_python(
        self, repeated: int, substeps: int, copy: np.ndarray, rows: np.ndarray, first: int, last: int
    ) -> int:
        """Run as the kernel does, law by law in plain Python."""
        n = len(self._blocks)
        for k in range(first, last):
            raised = self._blocks_in_python(0, rows[k])
            for _ in range(1, substeps):
                copy[0] = rows[k]
                raised = min(raised, self._blocks_in_python(n - repeated, copy[0]))
            if raised != 0.0:
                rows[k, _STATUS] = raised
            if rows[k, _STATUS] != 0.0:
                return k
        return last

    def _blocks_in_python(self, first: int, row: np.ndarray) -> float:
        for place, block in self._blocks[first:]:
            try:
                run_in_python(block, row)
            except KeyboardInterrupt:
                raise
            except BaseException as error:  # as a compiled law that raises, whatever it is
                line = traceback.extract_tb(error.__traceback__)[-1]
                self.error = f"{type(error).__name__}: {error}; {line.filename}, line {line.lineno}"
                return RAISED - place
        return 0.0


_ADDRESS, _PARAMS, _PARAMS_STRIDE, _STATE, _STATE_STRIDE, _COUNT, _PLACE, _FIRST, _SIZE, _COLUMNS = range(10)


def _entry(place: int, block: Block) -> tuple[int, ...]:
    """Return what the kernel knows of a block.

    Its address, its memory, how many records it runs on (0: it runs on the row), its place, where those begin and their
    size.
    """
    params, state, each = block.params, block.state, block.stage.each
    strides = [array.strides[0] if len(array) > 1 or array.ndim > 1 else 0 for array in (params, state)]
    memory = params.ctypes.data, strides[0], state.ctypes.data, strides[1]
    return block.stage.address, *memory, block.records, place, block.first, 0 if each is None else each.itemsize


def run_in_python(block: Block, row: np.ndarray) -> None:
    """Run the law of a block in plain Python, on the row or on each of its effectors or engines."""
    signals = _records(row[:ROW_WIDTH].view(ROW))[0]
    step, params, state, each = block.stage.python, _records(block.params), _records(block.state), block.stage.each
    if each is None:
        step(params[0], block.state if block.stage.state == RAW else state[0], signals)
        return
    records = _records(row[block.first // 8 : block.end // 8].view(each))
    for i in range(block.records):
        step(params[i if len(params) > 1 else 0], state[i if len(state) > 1 else 0], records[i], signals)


def _records(array: np.ndarray) -> np.ndarray:
    return array if array.dtype == RAW else array.view(np.recarray)


@intrinsic
def _call(_context, function, a, b, c, d):
    """Call the compiled law at an address with four addresses, of which a law on a row takes three; return its status.

    numba passes two words before them: where a result and where an exception would be put.
    """
    signature = types.int32(*[types.int64] * 5)

    def generate(_context, builder, _signature, args):
        address = ir.IntType(8).as_pointer()
        words = [cgutils.alloca_once(builder, address) for _ in range(2)]
        kind = ir.FunctionType(ir.IntType(32), [address.as_pointer()] * 2 + [address] * 4)
        target = builder.inttoptr(args[0], kind.as_pointer())
        return builder.call(target, [*words, *(builder.inttoptr(arg, address) for arg in args[1:])])

    return signature, generate


@intrinsic
def _at(_context, address, like):
    """Return an address as a pointer to elements of the type of `like`."""
    kind = types.CPointer(like)

    def generate(context, builder, _signature, args):
        return builder.inttoptr(args[0], context.get_value_type(kind))

    return kind(address, like), generate


@numba.njit
def _blocks(table, first, last, row):
    """Run blocks on the row at an address; return 0, or RAISED less the place of one that raised."""
    for i in range(first, last):
        function, p, s = table[i, _ADDRESS], table[i, _PARAMS], table[i, _STATE]
        count = table[i, _COUNT]
        raised = 0
        if count == 0:
            raised = _call(function, p, s, row, 0)
        for j in range(count):
            e = row + table[i, _FIRST] + j * table[i, _SIZE]
            raised |= _call(function, p + j * table[i, _PARAMS_STRIDE], s + j * table[i, _STATE_STRIDE], e, row)
        if raised != 0:
            return RAISED - table[i, _PLACE]
    return 0.0


def _run_rows(bound, first, last):
    given = numba.carray(_at(bound, 0), 8)
    table_at, copy, base, n, repeated_from = given[0], given[1], given[2], given[3], given[4]
    substeps, width, stride = given[5], given[6], given[7]
    table = numba.carray(_at(table_at, 0), (n, _COLUMNS))
    for k in range(first, last):
        row = base + k * stride
        signals = numba.carray(_at(row, 0.0), width)
        raised = _blocks(table, 0, n, row)
        for _ in range(1, substeps):
            again = numba.carray(_at(copy, 0.0), width)
            again[:] = signals
            raised = min(raised, _blocks(table, repeated_from, n, copy))
        if raised != 0.0:
            signals[_STATUS] = raised
        if signals[_STATUS] != 0.0:
            return k
    return last


@functools.cache
def _compiled_kernel() -> Callable[[int, int, int], int]:
    """Return the kernel as numba's wrapper of it, without the dispatch on the types of its arguments (0.3 us)."""
    compiled = numba.njit(types.int64(*[types.int64] * 3), cache=True)(_run_rows)
    (result,) = compiled.overloads.values()
    return result.entry_point
