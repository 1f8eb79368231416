"""A custom controller, both loops in one module; docs/custom-controller.md describes it.

In plain Python the module defines ``create(design, h, options)``, which returns ``step(t, x1_c, x1, x2)`` (`plain.py`).
Compiled, it defines PARAMS, STATE, ``stage`` and ``params(design, h, options)`` as the laws of this project do. Both
are tried on a copy before they fly; what is wrong with them is reported as the user's error.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numba
import numpy as np

from uavftc.control.custom.checks import CREATE, PARAMETERS, STEP, TELEMETRY, call, require
from uavftc.control.custom.guard import Guard
from uavftc.control.custom.measured import Aboard, recalled
from uavftc.control.custom.memory import memory
from uavftc.control.custom.module import attribute, failed, load
from uavftc.control.custom.plain import TRIAL_RAD, plain
from uavftc.control.custom.text import shown
from uavftc.core.given import ControlDesign
from uavftc.core.given import Given as Flight
from uavftc.core.layout import OwnSignal
from uavftc.core.program import RAISED, STATUS_SET, Program, run_in_python
from uavftc.core.signals import ROW, as_records, empty_rows
from uavftc.core.stage import COMPILED, RAW, Block, PythonBlock, Stage, law
from uavftc.errors import InputError

TIMEOUT_S = 10.0
_WRITTEN = ("v2", *TELEMETRY)  # what of the row is a controller's
READABLE = (
    "t", "x1_c", "x1_meas", "x2_meas", "u2", "airspeed", "altitude", "alpha", "beta", "throttle", "qbar", "load_factor",
)  # fmt: skip
"""Of the row, what a compiled controller may say that it reads, beside what it writes."""


class Custom(NamedTuple):
    """A custom controller, ready to fly."""

    blocks: list[Block | PythonBlock]
    """Of the sample."""
    plant_step: list[Block]
    """Of the plant step, behind the actuators; empty unless something of the row before is asked for."""
    signals: tuple[OwnSignal, ...] = ()
    """Its own, in their order in a row."""
    unrecorded: set[str] = set()  # noqa: RUF012 - each that is filled is its own
    """Names of telemetry that it returned without declaring it, as a message shows them; filled in flight too."""

    def remarks(self) -> list[str]:
        """Return what is worth a warning about it."""
        if not self.unrecorded:
            return []
        names = ", ".join(sorted(self.unrecorded))
        return [f"the controller returned {names} without declaring it: not recorded (docs/custom-controller.md)"]


def custom_controller(
    kind: str,
    flight: Flight,
    options: Mapping[str, Any],
    *,
    aboard: Aboard | None = None,
    timeout_s: float = TIMEOUT_S,
) -> Custom:
    """Return the controller of a module, after a trial.

    Parameters
    ----------
    kind
        What `module.load` takes; a path is absolute.
    flight, options
        The design, the sample time and the user's options are given to the module, copied each time.
    aboard
        What its step may ask for; by default what a flight without air has.
    timeout_s
        How long a step in plain Python may take, s, at the trial and in flight.

    Raises
    ------
    InputError
        If the module cannot be loaded, lacks a function, or fails its trial.
    """
    module, file = load(kind)
    create, stage = attribute(module, "create", file), attribute(module, "stage", file)
    if create is not None and _is_stage(stage):
        found, remedy = "both create and stage", "keep the one that is meant to fly"
        raise InputError(file, found=found, expected="one of them: plain Python or compiled", remedy=remedy)

    def given() -> tuple[ControlDesign, float, dict[str, Any]]:
        return copy.deepcopy(flight.design), flight.h, copy.deepcopy(dict(options))

    if create is None and (stage is not None or attribute(module, "PARAMS", file) is not None):
        block = _compiled(module, file, given)
        recall, keep = _kept(flight, "u2" in (block.stage.reads or ()))
        return Custom([unknown.block(name="unknown"), *recall, block, untouched.block(name="untouched")], keep)
    if create is None:
        found = "neither create nor PARAMS, STATE, stage and params"
        expected = f"the function {CREATE}, which returns {STEP}"
        raise InputError(
            file, found=found, expected=expected, remedy="see docs/custom-controller.md, or pid, for a template"
        )
    made = plain(create, file, given, aboard or Aboard.of(flight), Guard(timeout_s))
    recall, keep = _kept(flight, recalled(made.asked))
    return Custom([unknown.block(name="unknown"), *recall, made.block], keep, made.signals, made.unrecorded)


def _kept(flight: Flight, is_asked: bool) -> tuple[list[Block], list[Block]]:
    """Return the blocks that keep what belongs to the row before, of the sample and of the plant step."""
    if not is_asked:
        return [], []
    both = memory(flight)
    return [both.recall], [both.keep]


def positive_options(options: Mapping[str, Any], **defaults: float) -> dict[str, float]:
    """Return the options of a controller whose options are all numbers above 0, with defaults for those not given.

    Raises
    ------
    InputError
        If an option is unknown, or is not a finite number above 0.
    """
    for name, value in options.items():
        key = f"key controller.options.{name}"
        if name not in defaults:
            names = ", ".join(defaults)
            raise InputError(key, found=f"the unknown option {name}", expected=f"one of {names}", remedy="remove it")
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < float("inf"):
            raise InputError(
                key, found=shown(value), expected="a number above 0", remedy=f"for example {defaults[name]:g}"
            )
    return {name: float(options.get(name, value)) for name, value in defaults.items()}


@law
def _write_nan(p, s, row):
    """Write nan into the fields that a controller may fill: what it does not report is missing, not zero."""
    for i in range(3):
        row.d1_hat[i] = np.nan
        row.v1[i] = np.nan
        row.f_hat[i] = np.nan


@law
def _end_if_status(p, s, row):
    """End the flight where a law from outside has set the status of the row: it says how a vehicle is lost."""
    if row.status != 0.0:
        row.status = STATUS_SET


unknown = Stage(_write_nan, reads=[], writes=["d1_hat", "v1", "f_hat"])
untouched = Stage(_end_if_status, reads=["status"], writes=["status"])


def _is_stage(value: object) -> bool:
    return issubclass(type(value), Stage)


# --- compiled --------------------------------------------------------------------------------------------------------


def _compiled(module: Any, file: str, given: Callable[[], tuple[ControlDesign, float, Any]]) -> Block:
    stage, dtypes = attribute(module, "stage", file), []
    for name in ("PARAMS", "STATE"):
        dtype = attribute(module, name, file)
        if not issubclass(type(dtype), np.dtype):
            found = f"no dtype {name}" if dtype is None else f"{name}: {shown(dtype)}"
            raise InputError(file, found=found, expected=f"{name}, a numpy.dtype", remedy=f"define {name}")
        dtypes.append(dtype)
    if not _is_stage(stage) or [stage.params, stage.state] != dtypes:
        raise InputError(
            file,
            found="no stage" if stage is None else f"stage: {shown(stage)}",
            expected="stage, a uavftc.core.stage.Stage of PARAMS and STATE",
            remedy="define stage = Stage(step, PARAMS, STATE)",
        )
    if others := sorted((stage.reads or frozenset()) - {*READABLE, *_WRITTEN}):
        raise InputError(
            f"{file}, stage",
            found=f"reads: {', '.join(others)}",
            expected=f"of {', '.join(READABLE)} what the law reads",
            remedy="read what is measured; the rest is the truth of the simulation, or belongs to the row before",
        )
    params, state = attribute(module, "params", file), attribute(module, "state", file)
    require(params, file, PARAMETERS)
    guard = Guard()
    try:
        with guard.armed():
            assert not COMPILED or stage.address
    except BaseException as error:
        if guard.is_users(error):
            raise
        raise _not_compiled(error, file) from None

    def fresh() -> Block:
        memory = [_record(call(params, given(), file, PARAMETERS), stage.params, file, PARAMETERS)]
        if state is not None:
            name = PARAMETERS.replace("params", "state")
            require(state, file, name)
            memory.append(_record(call(state, given(), file, name), stage.state, file, name))
        block: Block = call(lambda: stage.block(*memory, name="custom"), (), file, "PARAMS, STATE")
        return block

    _try_compiled(fresh, file, given)
    return fresh()


def _try_compiled(fresh: Callable[[], Block], file: str, given: Callable[[], tuple[ControlDesign, float, Any]]) -> None:
    """Run a compiled law for two samples.

    Raises
    ------
    InputError
        If it raises, commands what is not finite, or writes other fields of the row.
    """
    rows = empty_rows(2)
    trial, (design, h, _) = as_records(rows), given()
    trial["t"] = 0.0, h
    trial["x1_c"], trial["x1"], trial["x1_meas"] = design.x1_trim + TRIAL_RAD, design.x1_trim, design.x1_trim
    before = trial.copy()
    blocks = [fresh(), untouched.block(name="untouched")]
    ended = call(lambda: Program(blocks).run(rows, 0, 2), (), file, "stage")
    if ended < 2 and trial["status"][ended] <= RAISED:
        trial[:] = before
        raise _raised(fresh(), rows, file)
    for name in ROW.names or ():
        if name not in _WRITTEN and trial[name].tobytes() != before[name].tobytes():
            raise InputError(
                f"{file}, stage",
                found=f"a law that writes row.{name}",
                expected=f"a law that writes {', '.join(_WRITTEN)} of the row, and nothing else of it",
                remedy=f"read row.{name} only; what the law remembers belongs into its STATE",
            )
    for v2 in trial["v2"]:
        if not np.isfinite(v2).all():
            raise InputError(
                f"{file}, stage",
                found=shown(v2),
                expected="a finite command row.v2, rad",
                remedy="give a number on every axis",
            )


def _raised(block: Block, rows: np.ndarray, file: str) -> InputError:
    """Return what a compiled law raises: that has no text, so the law is run again as it is written."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            for row in rows:
                run_in_python(block, row)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return failed(f"{file}, stage", error, file, "a law that raises no exception")
    return InputError(
        f"{file}, stage",
        found="an exception in the compiled law",
        expected="a law that raises no exception",
        remedy="run it with NUMBA_DISABLE_JIT=1 to see where",
    )


def _record(value: Any, dtype: np.dtype, file: str, function: str) -> np.ndarray:
    if type(value) in (np.ndarray, np.recarray) and value.dtype == dtype and (value.shape == (1,) or dtype == RAW):
        return np.ascontiguousarray(value)
    raise InputError(
        f"{file}, {function}",
        found=shown(value),
        expected="one record, an array of shape (1,) of the module's dtype",
        remedy="return uavftc.core.stage.params_of(PARAMS, name=value, ...)",
    )


def _not_compiled(error: BaseException, file: str) -> InputError:
    if not isinstance(error, numba.core.errors.NumbaError):
        return failed(f"{file}, stage", error, file, "a law that numba can compile")
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    what = next((line for line in lines if not line.startswith(("Failed in", "During:"))), "no reason given")
    at = [line for line in lines if line.startswith("File ")]
    found = f"{what[:300]}{f'; {at[-1]}' if at else ''}"
    remedy = "write it in the Python that numba compiles, or as create(design, h, options)"
    return InputError(f"{file}, stage", found=found, expected="a law that numba can compile", remedy=remedy)
