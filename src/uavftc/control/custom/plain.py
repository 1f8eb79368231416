"""A controller in plain Python: `create` and the step that it returns, tried, and then flown as a block."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from uavftc.control.custom.checks import (
    COMMAND,
    CREATE,
    STEP,
    TELEMETRY,
    THREE,
    WrongResultError,
    call,
    outputs,
    overdue,
    require,
)
from uavftc.control.custom.guard import Guard, Overdue
from uavftc.control.custom.known import Known
from uavftc.control.custom.measured import Aboard, asked, at_trim, readers
from uavftc.control.custom.own_signals import declared, sizes
from uavftc.control.custom.text import described, readable, shown
from uavftc.core.given import ControlDesign
from uavftc.core.layout import OwnSignal
from uavftc.core.signals import ROW
from uavftc.core.stage import PythonBlock, StepFailed
from uavftc.errors import InputError

TRIAL_RAD = 0.01  # commanded change of attitude of the trial: small against any limit

Given = Callable[[], tuple[ControlDesign, float, Any]]
"""Returns what `create` is given, copied each time."""

Read = Callable[..., tuple[np.ndarray, dict[str, np.ndarray]]]
"""A step whose result is read."""


class Plain(NamedTuple):
    """A controller in plain Python, ready to fly."""

    block: PythonBlock
    asked: tuple[str, ...]
    """What of `measured.MEASURED` its step takes."""
    signals: tuple[OwnSignal, ...]
    unrecorded: set[str]
    """Takes the names of telemetry that was not declared, as a message shows them."""


class _Made(NamedTuple):
    """What `create` returned."""

    step: Any
    signals: tuple[OwnSignal, ...]
    asked: tuple[str, ...]


def plain(create: Any, file: str, given: Given, aboard: Aboard, guard: Guard) -> Plain:
    """Return the controller after a trial: two samples, and one more for each kind of fault that it will be told of.

    Raises
    ------
    InputError
        If one of its functions has other arguments, or it fails the trial.
    """
    require(create, file, CREATE)
    made, unrecorded = _made(create, file, given, aboard), set[str]()
    _try(_read(made, unrecorded), made, file, given, aboard, guard)
    fresh = _made(create, file, given, aboard)  # the trial leaves no trace
    if (fresh.signals, fresh.asked) != (made.signals, made.asked):
        raise InputError(
            f"{file}, {CREATE}",
            found="other signals, or another step, at the second call than at the first",
            expected="the same at each call: it is called for the trial and again for the flight",
            remedy="keep what changes in the closure, not in globals of the module",
        )
    at_sample = _in_flight(_read(fresh, unrecorded), fresh, file, aboard, guard)
    return Plain(PythonBlock("custom", at_sample, guard.armed), fresh.asked, fresh.signals, unrecorded)


def _made(create: Any, file: str, given: Given, aboard: Aboard) -> _Made:
    """Return the step of a controller with its signals, and what it asks for."""
    signals: tuple[OwnSignal, ...] = ()
    step = call(create, given(), file, CREATE)
    what = f"what {CREATE} returned"
    if type(step) is tuple:
        if len(step) != 2:
            expected = f"{STEP}, or the step and a map of its signals"
            raise InputError(file, found=f"{what}: {shown(step)}", expected=expected, remedy="return step, {...}")
        signals = declared(step[1], file, aboard.columns)
        step = step[0]
    names = asked(step, file, aboard) if callable(step) else ()
    require(step, file, STEP, what, names)
    return _Made(step, signals, names)


def _read(made: _Made, unrecorded: set[str]) -> Read:
    """Return the step with its result read: what a result does when it is looked at, it does inside the step."""
    step, named = made.step, {**THREE, **sizes(made.signals)}
    return lambda *arguments, **more: outputs(step(*arguments, **more), named, unrecorded)


def _try(step: Read, made: _Made, file: str, given: Given, aboard: Aboard, guard: Guard) -> None:
    design, h, _ = given()
    samples: list[tuple[float, tuple[Any, ...]]] = [(0.0, ()), (h, ())]
    if "faults" in made.asked:
        samples += [(t, (record,)) for t, record in Known(aboard.given).first_of_each_kind()]
    for t, faults in samples:
        x1_c, x1, x2 = design.x1_trim + TRIAL_RAD, design.x1_trim.copy(), np.zeros(3)
        more = at_trim(made.asked, aboard)
        if "faults" in more:
            more["faults"] = faults
        v2, _ = call(step, (t, x1_c, x1, x2), file, STEP, guard, **more)
        if not np.isfinite(v2).all():
            remedy = "return v2, or (v2, {'v1': ...})"
            raise InputError(f"{file}, {STEP}", found=shown(v2), expected=COMMAND, remedy=remedy)


def _columns(field: str) -> slice:
    start = ROW.fields[field][1] // 8  # type: ignore[index]
    return slice(start, start + 3)


def _own_columns(signals: tuple[OwnSignal, ...], first: int) -> dict[str, slice]:
    """Return where in a row the numbers of each signal are."""
    found = {}
    for signal in signals:
        found[signal.name] = slice(first, first + len(signal.columns))
        first += len(signal.columns)
    return found


def _in_flight(step: Read, made: _Made, file: str, aboard: Aboard, guard: Guard) -> Callable[[np.ndarray], None]:
    x1_c, x1, x2, command = _columns("x1_c"), _columns("x1_meas"), _columns("x2_meas"), _columns("v2")
    own = _own_columns(made.signals, aboard.own)
    columns = {name: _columns(name) for name in TELEMETRY} | own
    missing = slice(aboard.own, aboard.own + sum(len(signal.columns) for signal in made.signals))
    take = readers(made.asked, aboard)
    nothing: Mapping[str, Any] = {}

    def at_sample(row: np.ndarray) -> None:
        seen = row.copy()  # the controller may keep or change what it is given; the row is the history
        more = {name: read(seen) for name, read in take} if take else nothing
        if own:
            row[missing] = np.nan
        try:
            row[command], telemetry = guard.timed(step, seen.item(0), seen[x1_c], seen[x1], seen[x2], **more)
            for name, value in telemetry.items():
                row[columns[name]] = value
            return
        except Overdue as error:
            why = overdue(error, file, guard)
        except WrongResultError as wrong:
            why = f"{file}: {STEP} returned {wrong.found}, expected {wrong.expected}"
        except BaseException as error:
            if guard.is_users(error):
                raise
            why = described(error, file)
        raise StepFailed(readable(f"the controller failed: {why}"))

    return at_sample
