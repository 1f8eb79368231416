"""Checks of a custom controller: anything wrong with it becomes an `InputError` that names the user's code."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from uavftc.control.custom.module import failed
from uavftc.errors import InputError

CREATE, STEP, PARAMETERS = "create(design, h, options)", "step(t, x1_c, x1, x2)", "params(design, h, options)"
"""The functions of a controller, as messages show them."""


def require(function: Any, file: str, expected: str, what: str | None = None) -> None:
    """Refuse what is not a function of the arguments in `expected`."""
    name, _, rest = expected.partition("(")
    what = what or name
    remedy = f"define {expected}" if what == name else f"return a function {expected}"
    if not callable(function):
        found = f"no function {name}" if function is None and what == name else f"{what}: {shown(function)}"
        raise InputError(file, found=found, expected=f"the function {expected}", remedy=remedy)
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # a builtin; the trial will show
        return
    try:
        signature.bind(*rest.rstrip(")").split(", "))
    except TypeError as error:
        raise InputError(
            f"{file}, {name}", found=f"{name}{signature}: {error}", expected=expected, remedy=remedy
        ) from None


def call(function: Callable[..., Any], arguments: tuple[Any, ...], file: str, name: str) -> Any:
    """Return what the user's function returns; what it raises is reported with its line in the user's file."""
    try:
        return function(*arguments)
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        raise failed(f"{file}, {name}", error, file, f"{name.partition('(')[0]} to return") from None


def three_numbers(value: Any, file: str, function: str, expected: str, *, finite: bool = True) -> None:
    """Refuse what is not three real numbers."""
    try:
        array = np.asarray(value)
        good = array.shape == (3,) and array.dtype.kind in "iuf" and (not finite or bool(np.isfinite(array).all()))
    except (TypeError, ValueError):
        good = False
    if not good:
        remedy = "return v2, or (v2, {'v1': ...})" if function == STEP else "give a number on every axis"
        raise InputError(f"{file}, {function}", found=shown(value), expected=expected, remedy=remedy)


def shown(value: Any) -> str:
    """Return a value as a message shows it: in short; an array of another size by its shape."""
    if isinstance(value, np.ndarray) and value.shape != (3,):
        return f"an array of shape {value.shape}, {value.dtype}"
    text = " ".join(repr(value).split())
    return text if len(text) <= 120 else f"{text[:117]}..."
