"""Custom controllers that are Python objects of this process and stand in no file that a scenario could name."""

from __future__ import annotations

import inspect
import re
import sys
from contextlib import suppress
from types import ModuleType, SimpleNamespace
from typing import Any

from uavftc.errors import InputError

PREFIX = "python:"
"""Of a kind that names one of them."""

_known: dict[str, tuple[object, Any, str]] = {}
"""By kind: the object as given, what serves as its module, and its file."""


def register(controller: object) -> str:
    """Return the kind by which a scenario of this process names a controller.

    Parameters
    ----------
    controller
        A function ``step(t, x1_c, x1, x2)``; a function or class that makes one, ``create(design, h, options)``, whose
        first argument is named `design`; or a module. A step that remembers anything between samples belongs into what
        a `create` returns: a flight tries its controller once before it flies.

    Raises
    ------
    InputError
        If it is none of them.
    """
    if isinstance(controller, ModuleType):
        return controller.__name__ if sys.modules.get(controller.__name__) is controller else _add(controller)
    if not callable(controller):
        raise InputError(
            "controller",
            found=f"an object of type {type(controller).__name__}",
            expected="a name or path, a function step(t, x1_c, x1, x2) or create(design, h, options), or a module",
            remedy="see docs/custom-controller.md for both functions",
        )
    return _add(controller)


def known(kind: str) -> bool:
    """Return whether a kind names a controller of this process."""
    return kind in _known


def load(kind: str) -> tuple[Any, str]:
    """Return what serves as the module of a controller, and its file.

    Raises
    ------
    InputError
        If this process has no controller of this name.
    """
    if kind not in _known:
        raise missing(kind, f"controller.kind, '{kind}'")
    _, module, file = _known[kind]
    return module, file


def missing(kind: str, where: str) -> InputError:
    """Return the error that says that a controller was given in Python, and is not there any more."""
    return InputError(
        where,
        found=f"'{kind}', a controller that was given as a Python object to another process",
        expected="a controller that a file can name",
        remedy="write it to a .py file with create(design, h, options), and name that (docs/custom-controller.md)",
    )


def _add(controller: Any) -> str:
    for kind, (given, _, _) in _known.items():
        if given is controller:
            return kind
    written = getattr(controller, "__name__", type(controller).__name__).rpartition(".")[2]
    name = re.sub(r"[^A-Za-z0-9_]", "_", written).strip("_") or "step"
    kind, again = f"{PREFIX}{name}", 1
    while kind in _known:  # another one of the same name: results are named after it
        again += 1
        kind = f"{PREFIX}{name}_{again}"
    _known[kind] = controller, _module(controller), _file(controller, kind)
    return kind


def _module(controller: Any) -> Any:
    if isinstance(controller, ModuleType):
        return controller
    if _makes(controller):
        return SimpleNamespace(create=controller)
    return SimpleNamespace(create=lambda design, h, options: controller)


def _makes(controller: Any) -> bool:
    """Return whether a callable is a `create` and no step: its first argument is named design."""
    with suppress(TypeError, ValueError):
        return next(iter(inspect.signature(controller).parameters), "") == "design"
    return False


def _file(controller: Any, kind: str) -> str:
    """Return the file that a message about the controller's code names."""
    written = controller if inspect.isroutine(controller) or inspect.isclass(controller) else type(controller)
    with suppress(TypeError, OSError):
        return inspect.getfile(written)
    return kind
