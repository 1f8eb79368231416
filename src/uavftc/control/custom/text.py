"""What the user's code returned or raised, as a message shows it, whatever it does when it is looked at.

A value whose `repr`, or an error whose text, raises is described by its type. What cannot be printed is escaped, so
that a message can be written to any file and to any terminal.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from uavftc.control.custom.guard import Overdue

T = TypeVar("T")

_CONTAINERS: tuple[Any, ...] = (list, tuple, dict, set, str, bytes)
_MANY = 10_000  # items of a container whose repr is not asked for
_LONG = 100_000  # characters of a text that are looked at


def readable(text: str) -> str:
    """Return a text on one line, with what cannot be printed escaped: surrogates, control characters."""
    words = " ".join(str.__str__(text)[:_LONG].split())
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in words)


def shown(value: Any) -> str:
    """Return a value as an error shows it: in short, an array of another size by its shape."""

    def text() -> str:
        if isinstance(value, np.ndarray):
            array = np.asarray(value)
            if array.shape != (3,):
                return f"an array of shape {array.shape}, {array.dtype}"
        for kind in _CONTAINERS:
            if isinstance(value, kind) and (length := kind.__len__(value)) > _MANY:
                return f"a {type_name(value)} of length {length}"
        return readable(repr(value))

    return _short(_try(text, f"a value of type {type_name(value)} whose repr raises"), 120)


def described(error: BaseException, file: str) -> str:
    """Return what was raised, its line in the user's file, and what stands there."""
    line, text = place(error, file)
    what = _short(_what(error), 300)
    return what if line is None else readable(f"{what}; {file}, line {line}{f': {text}' if text else ''}")


def place(error: BaseException, file: str) -> tuple[int | None, str]:
    """Return the last line of `file` that the error passed through and its text; None where there is no such line."""

    def found() -> tuple[int | None, str]:
        if isinstance(error, SyntaxError) and error.filename == file and isinstance(error.lineno, int):
            return error.lineno, readable(error.text or "")
        passed = BaseException.__dict__["__traceback__"].__get__(error)
        frames = [frame for frame in traceback.extract_tb(passed) if frame.filename == file]
        return (frames[-1].lineno, readable(frames[-1].line or "")) if frames else (None, "")

    nowhere: tuple[int | None, str] = (None, "")
    return _try(found, nowhere)


def type_name(value: Any) -> str:
    """Return the name of a value's type, past whatever its metaclass says."""
    return readable(type.__dict__["__name__"].__get__(type(value)))


def _what(error: BaseException) -> str:
    """Return the type of an error and its text."""
    name = type_name(error)
    module = type.__dict__["__dict__"].__get__(type(error)).get("__module__")
    if type(module) is str and module not in ("builtins", "__main__") and not module.startswith("custom_controller_"):
        name = readable(f"{module}.{name}")

    def text() -> str:
        return readable(error.msg if isinstance(error, SyntaxError) else str(error))

    said = _try(text, "an error whose text raises")
    return f"{name}: {said}" if said else name


def _try(function: Callable[[], T], otherwise: T) -> T:
    """Return what the function returns, or `otherwise` where the user's object that it looks at raises."""
    try:
        return function()
    except Overdue:
        raise
    except BaseException:
        return otherwise


def _short(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 3]}..."
