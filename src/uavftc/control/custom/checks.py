"""Checks of a custom controller: anything wrong with it becomes an `InputError` that names the user's code.

What a step returns is read in one place, at the trial as in flight: what is refused there is refused here.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from uavftc.control.custom.guard import Guard, Overdue
from uavftc.control.custom.module import failed
from uavftc.control.custom.text import described, readable, shown
from uavftc.errors import InputError

CREATE, STEP, PARAMETERS = "create(design, h, options)", "step(t, x1_c, x1, x2)", "params(design, h, options)"
"""The functions of a controller, as messages show them."""

TELEMETRY = ("v1", "d1_hat", "f_hat")
"""What a step may return beside its command and without declaring it."""

THREE: Mapping[str, int] = dict.fromkeys(TELEMETRY, 3)
"""How many numbers of each; 0 of one that is a number and no list."""

_MANY_NAMES = 10  # of telemetry that is not recorded, which a warning lists
_WORDS = {0: "a number", 3: "three numbers"}

COMMAND = "three numbers as v2, rad: aileron, elevator, rudder about trim"
"""The command of a step, as an error says what was expected."""
_NOTHING = object()


class WrongResultError(Exception):
    """A step returned what is no command, or telemetry that is no three numbers."""

    def __init__(self, found: str, expected: str) -> None:
        super().__init__(found, expected)
        self.found, self.expected = found, expected


def require(function: Any, file: str, expected: str, what: str | None = None, named: Sequence[str] = ()) -> None:
    """Refuse what is not a function of the arguments in `expected`, and of those `named`."""
    name, _, rest = expected.partition("(")
    what = what or name
    remedy = f"define {expected}" if what == name else f"return a function {expected}"
    if not callable(function):
        found = f"no function {name}" if function is None and what == name else f"{what}: {shown(function)}"
        raise InputError(file, found=found, expected=f"the function {expected}", remedy=remedy)
    guard = Guard()
    try:
        with guard.armed():
            signature = inspect.signature(function)
            written = str(signature)
    except BaseException as error:  # a builtin, or an object that does not say; the trial shows
        if guard.is_users(error):
            raise
        return
    try:
        signature.bind(*rest.rstrip(")").split(", "), **dict.fromkeys(named))
    except TypeError as error:
        raise InputError(
            f"{file}, {name}", found=readable(f"{name}{written}: {error}"), expected=expected, remedy=remedy
        ) from None


def call(
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    file: str,
    name: str,
    guard: Guard | None = None,
    **named: Any,
) -> Any:
    """Return what the user's function returns; what it raises is reported with its line in the user's file.

    With a guard, its time is limited.

    Raises
    ------
    InputError
        If it raises, or takes longer than the guard allows.
    """
    watch = guard or Guard()
    try:
        with watch.armed():
            if guard is None:
                return function(*arguments, **named)
            return guard.timed(function, *arguments, **named)
    except Overdue as error:
        raise InputError(
            f"{file}, {name}",
            found=overdue(error, file, watch),
            expected=f"a step within controller.timeout_s, {watch.timeout_s:g} s",
            remedy="make the step faster, prepare in create what takes long, or raise controller.timeout_s",
        ) from None
    except WrongResultError as wrong:
        remedy = "return v2, or (v2, {'v1': ...})"
        raise InputError(f"{file}, {name}", found=wrong.found, expected=wrong.expected, remedy=remedy) from None
    except BaseException as error:
        if watch.is_users(error):
            raise
        if isinstance(error, InputError) and _is_plain(error):
            raise
        raise failed(f"{file}, {name}", error, file, f"{name.partition('(')[0]} to return") from None


def _is_plain(error: InputError) -> bool:
    """Tell whether an error that the user's code made itself can be shown: its fields are texts."""
    return type(error) is InputError and all(type(value) is str for value in vars(error).values())


def overdue(error: Overdue, file: str, guard: Guard) -> str:
    """Return in words that a step took too long, and where it was interrupted."""
    _, _, at = described(error, file).partition("; ")
    return f"{STEP} took longer than controller.timeout_s, {guard.timeout_s:g} s{f'; {at}' if at else ''}"


def outputs(
    result: Any, sizes: Mapping[str, int] = THREE, unrecorded: set[str] | None = None
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return v2, shape (3,), and by its name the telemetry of what a step returned, shape (n,) each, float64.

    Parameters
    ----------
    result
        What the step returned.
    sizes
        How many numbers each name has in the telemetry; 0 of one that is a number and no list.
    unrecorded
        Takes the names that are not among them.

    Raises
    ------
    WrongResultError
        If one of them is not so many real numbers; they may be infinite or nan.
    """
    telemetry: dict[str, Any] = {}
    if type(result) is tuple and len(result) == 2 and isinstance(result[1], dict):
        result, telemetry = result
    v2 = _numbers(result, 3, COMMAND)
    found = {}
    if telemetry:
        for name, size in sizes.items():
            if (value := dict.get(telemetry, name, _NOTHING)) is not _NOTHING:
                found[name] = _numbers(value, size, name)
        if unrecorded is not None and len(found) < dict.__len__(telemetry) and len(unrecorded) < _MANY_NAMES:
            unknown = [key for key in dict.keys(telemetry) if type(key) is not str or key not in sizes]
            unrecorded.update(shown(key) for key in unknown[:_MANY_NAMES])
    return v2, found


def _numbers(value: Any, size: int, expected: str) -> np.ndarray:
    """Return so many real numbers as float64; one where `size` is 0. `expected` is said in words, or a name."""
    if type(value) is np.ndarray and value.shape == (size,) and value.dtype == np.float64:
        return value
    if expected is not COMMAND:
        expected = f"{_WORDS.get(size, f'{size} numbers')} as {expected}"
    try:
        found = _several(value, size)
    except (KeyboardInterrupt, Overdue):
        raise
    except BaseException as error:
        reason = f"{shown(value)}, which cannot be read: {described(error, '')}"
        raise WrongResultError(reason, expected) from None
    if found is None:
        raise WrongResultError(shown(value), expected)
    return found


def _several(value: Any, size: int) -> np.ndarray | None:
    """Return so many real numbers as float64, or None where it is anything else; raises what `value` does."""
    kind = type(value)
    if size == 0:
        return None if (number := _real(value)) is None else np.array([number])
    if isinstance(value, np.ndarray) or hasattr(kind, "__array__"):
        array = np.asarray(value)
        good = array.shape == (size,) and array.dtype.kind in "iuf"
        return array.astype(np.float64) if good else None
    is_sequence = hasattr(kind, "__len__") and hasattr(kind, "__getitem__") and not hasattr(kind, "keys")
    if not is_sequence or issubclass(kind, str | bytes | bytearray):
        return None
    items: Iterable[Any] = islice(iter(value), size + 1)  # one that never ends is no three numbers either
    numbers = [_real(item) for item in items]
    return np.array(numbers, dtype=np.float64) if len(numbers) == size and None not in numbers else None


def _real(value: Any) -> float | None:
    """Return a real number, or None; a text, a truth value and a complex number are none."""
    kind = type(value)
    if kind is float:
        return float(value)
    if isinstance(value, np.ndarray | np.generic) or hasattr(kind, "__array__"):
        array = np.asarray(value)
        return float(array) if array.shape == () and array.dtype.kind in "iuf" else None
    return float(value) if isinstance(value, int | float) and kind is not bool else None
