"""A custom controller, both loops in one module; docs/custom-controller.md describes it.

In plain Python the module defines ``create(design, h, options)``, which returns ``step(t, x1_c, x1, x2)``. Compiled, it
defines PARAMS, STATE, ``stage`` and ``params(design, h, options)`` as the laws of this project do. Both are tried on a
copy before they fly; what is wrong with them is reported as the user's error.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numba
import numpy as np

from uavftc.control.custom.checks import CREATE, PARAMETERS, STEP, call, require, shown, three_numbers
from uavftc.control.custom.module import described, failed, load
from uavftc.core.given import ControlDesign
from uavftc.core.program import Program
from uavftc.core.signals import ROW, as_records, empty_rows
from uavftc.core.stage import COMPILED, RAW, Block, PythonBlock, Stage, StepFailed, law
from uavftc.errors import InputError

TELEMETRY = ("v1", "d1_hat", "f_hat")
_TRIAL_RAD = 0.01  # commanded change of attitude of the trial: small against any limit


def custom_blocks(kind: str, design: ControlDesign, h: float, options: Mapping[str, Any]) -> list[Block | PythonBlock]:
    """Return the controller of a module as blocks, after a trial.

    Parameters
    ----------
    kind
        What `module.load` takes; a path is absolute.
    design, h, options
        Given to the module, copied each time: the design, the sample time, s, and the user's options.

    Raises
    ------
    InputError
        If the module cannot be loaded, lacks a function, or fails its trial.
    """
    module, file = load(kind)
    create, stage = getattr(module, "create", None), getattr(module, "stage", None)
    if create is not None and isinstance(stage, Stage):
        found, remedy = "both create and stage", "keep the one that is meant to fly"
        raise InputError(file, found=found, expected="one of them: plain Python or compiled", remedy=remedy)

    def given() -> tuple[ControlDesign, float, dict[str, Any]]:
        return copy.deepcopy(design), h, copy.deepcopy(dict(options))

    if create is None and (stage is not None or hasattr(module, "PARAMS")):
        return [unknown.block(name="unknown"), _compiled(module, file, given)]
    if create is None:
        found = "neither create nor PARAMS, STATE, stage and params"
        expected = f"the function {CREATE}, which returns {STEP}"
        raise InputError(
            file, found=found, expected=expected, remedy="see docs/custom-controller.md, or pid, for a template"
        )
    return [unknown.block(name="unknown"), _python(create, file, given)]


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


unknown = Stage(_write_nan, reads=[], writes=["d1_hat", "v1", "f_hat"])


# --- plain Python ----------------------------------------------------------------------------------------------------


def _python(create: Any, file: str, given: Callable[[], tuple[ControlDesign, float, Any]]) -> PythonBlock:
    require(create, file, CREATE)
    require(call(create, given(), file, CREATE), file, STEP, f"what {CREATE} returned")
    step = call(create, given(), file, CREATE)
    design, h, _ = given()
    for k in range(2):
        x1_c, x1, x2 = design.x1_trim + _TRIAL_RAD, design.x1_trim.copy(), np.zeros(3)
        result = call(step, (k * h, x1_c, x1, x2), file, STEP)
        v2, telemetry = _parts(result)
        three_numbers(v2, file, STEP, "v2: three numbers, rad: aileron, elevator, rudder about trim")
        for name in TELEMETRY:
            if name in telemetry:
                three_numbers(telemetry[name], file, STEP, f"three numbers as {name}", finite=False)
    return PythonBlock(
        "custom", _in_flight(call(create, given(), file, CREATE), file)
    )  # a fresh one: the trial left no trace


def _parts(result: Any) -> tuple[Any, dict[str, Any]]:
    """Return v2 and the telemetry of what a step returned."""
    if type(result) is tuple and len(result) == 2 and isinstance(result[1], dict):
        return result
    return result, {}


def _columns(field: str) -> slice:
    start = ROW.fields[field][1] // 8  # type: ignore[index]
    return slice(start, start + 3)


def _in_flight(step: Callable[..., Any], file: str) -> Callable[[np.ndarray], None]:
    x1_c, x1, x2 = _columns("x1_c"), _columns("x1_meas"), _columns("x2_meas")
    aileron = _columns("v2").start
    elevator, rudder = aileron + 1, aileron + 2
    columns = {name: _columns(name) for name in TELEMETRY}

    def at_sample(row: np.ndarray) -> None:
        seen = row.copy()  # the controller may keep or change what it is given; the row is the history
        try:
            result = step(seen.item(0), seen[x1_c], seen[x1], seen[x2])
        except (Exception, SystemExit) as error:
            raise StepFailed(f"the controller failed: {described(error, file)}") from None
        try:
            if type(result) is tuple and len(result) == 2:
                result, telemetry = result
                for name in telemetry:
                    if name in columns:
                        row[columns[name]] = telemetry[name]
            row[aileron], row[elevator], row[rudder] = result
        except (TypeError, ValueError):
            found = f"{STEP} returned {shown(result)}, expected three numbers"
            raise StepFailed(f"the controller failed: {file}: {found}") from None

    return at_sample


# --- compiled --------------------------------------------------------------------------------------------------------


def _compiled(module: Any, file: str, given: Callable[[], tuple[ControlDesign, float, Any]]) -> Block:
    stage = getattr(module, "stage", None)
    for name in ("PARAMS", "STATE"):
        if not isinstance(getattr(module, name, None), np.dtype):
            found = f"no dtype {name}" if not hasattr(module, name) else f"{name}: {shown(getattr(module, name))}"
            raise InputError(file, found=found, expected=f"{name}, a numpy.dtype", remedy=f"define {name}")
    if not isinstance(stage, Stage) or (stage.params, stage.state) != (module.PARAMS, module.STATE):
        raise InputError(
            file,
            found="no stage" if stage is None else f"stage: {shown(stage)}",
            expected="stage, a uavftc.core.stage.Stage of PARAMS and STATE",
            remedy="define stage = Stage(step, PARAMS, STATE)",
        )
    require(getattr(module, "params", None), file, PARAMETERS)
    try:
        assert not COMPILED or stage.address
    except Exception as error:
        raise _not_compiled(error, file) from None

    def fresh() -> Block:
        params = _record(call(module.params, given(), file, PARAMETERS), module.PARAMS, file, PARAMETERS)
        if not hasattr(module, "state"):
            return stage.block(params, name="custom")
        name = PARAMETERS.replace("params", "state")
        require(module.state, file, name)
        return stage.block(
            params, _record(call(module.state, given(), file, name), module.STATE, file, name), name="custom"
        )

    rows = empty_rows(2)
    trial, (design, h, _) = as_records(rows), given()
    trial["t"] = 0.0, h
    trial["x1_c"], trial["x1"], trial["x1_meas"] = design.x1_trim + _TRIAL_RAD, design.x1_trim, design.x1_trim
    Program([fresh()]).run(rows, 0, 2)
    for v2 in trial["v2"]:
        three_numbers(v2, file, "stage", "a finite command row.v2, rad")
    return fresh()


def _record(value: Any, dtype: np.dtype, file: str, function: str) -> np.ndarray:
    if isinstance(value, np.ndarray) and value.dtype == dtype and (value.shape == (1,) or dtype == RAW):
        return np.ascontiguousarray(value)
    raise InputError(
        f"{file}, {function}",
        found=shown(value),
        expected="one record, an array of shape (1,) of the module's dtype",
        remedy="return uavftc.core.stage.params_of(PARAMS, name=value, ...)",
    )


def _not_compiled(error: Exception, file: str) -> InputError:
    if not isinstance(error, numba.core.errors.NumbaError):
        return failed(f"{file}, stage", error, file, "a law that numba can compile")
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    what = next((line for line in lines if not line.startswith(("Failed in", "During:"))), "no reason given")
    at = [line for line in lines if line.startswith("File ")]
    found = f"{what[:300]}{f'; {at[-1]}' if at else ''}"
    remedy = "write it in the Python that numba compiles, or as create(design, h, options)"
    return InputError(f"{file}, stage", found=found, expected="a law that numba can compile", remedy=remedy)
