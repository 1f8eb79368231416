"""Where a custom controller comes from: a file, an entry point, or a module by its import path."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from uavftc.control import whole
from uavftc.control.custom import in_memory
from uavftc.control.custom.guard import Guard
from uavftc.control.custom.text import described, place
from uavftc.errors import InputError

GROUP = "uavftc.controllers"
"""Group of the entry points by which an installed package gives its controllers short names."""

SHIPPED = {name: f"{whole.__name__}.{name}" for name in whole.NAMES}
"""The shipped entry points in GROUP, known without package metadata too; no other package can replace them."""

HOW = "./my_controller.py, or my_package.my_module for one that can be imported (see docs/custom-controller.md)"
"""How a custom controller is named, for the end of a remedy."""


def is_path(kind: str) -> bool:
    """Return whether a controller's kind is the path of a file: it has a separator, or ends in .py."""
    return kind.endswith(".py") or "/" in kind or "\\" in kind


def registered() -> dict[str, EntryPoint]:
    """Return the entry points by name, the shipped first, then those of installed packages, sorted."""
    found = {name: EntryPoint(name, value, GROUP) for name, value in SHIPPED.items()}
    for entry in sorted(entry_points(group=GROUP), key=lambda e: (e.name, e.value)):
        found.setdefault(entry.name, entry)
    return found


def is_there(kind: str) -> bool:
    """Return whether a kind that is not a path can be found: its package exists. Nothing of it is run."""
    if kind in SHIPPED or in_memory.known(kind) or kind in registered():
        return True
    if not all(part.isidentifier() for part in kind.split(".")):
        return False
    with _folders_searched(Path.cwd()), suppress(ValueError, ImportError):
        return importlib.util.find_spec(kind.partition(".")[0]) is not None
    return False


def load(kind: str) -> tuple[Any, str]:
    """Return the module of a controller and its file.

    The working directory is searched after the environment, and so is the folder of a file, but only while the module
    is loaded: what the controller imports, it imports at its top.

    Raises
    ------
    InputError
        If there is no such module, or loading it fails.
    """
    if kind.startswith(in_memory.PREFIX):
        return in_memory.load(kind)
    where = f"controller.kind, '{kind}'"
    guard = Guard()
    try:
        with guard.armed():
            if is_path(kind):
                module: Any = _from_file(Path(kind))
            else:
                entry = registered().get(kind)
                with _folders_searched(Path.cwd()):
                    module = importlib.import_module(kind) if entry is None else entry.load()
            file = getattr(module, "__file__", None)
            return module, str.__str__(file) if isinstance(file, str) and file else kind
    except BaseException as error:
        if guard.is_users(error):
            raise
        if isinstance(error, ModuleNotFoundError) and not is_path(kind) and _is_of(kind, error.name):
            raise InputError(
                where,
                found=f"no module {error.name} in the environment or in {Path.cwd()}",
                expected="the import path of a module, the path of a .py file, or the name of an entry point",
                remedy=f"check the spelling, or go to the folder that holds it; give one as {HOW}",
            ) from None
        if isinstance(error, OSError) and place(error, kind)[0] is None:
            reason = error.strerror if type(error.strerror) is str else described(error, kind)
            raise InputError(
                where,
                found=f"a file that cannot be read: {reason}",
                expected="a readable .py file",
                remedy="check the path and its permissions",
            ) from None
        raise failed(where, error, kind, "a module that can be imported") from None


def _is_of(kind: str, module: object) -> bool:
    """Return whether a module that was not found is the controller's, or a package above it."""
    return type(module) is str and f"{kind}.".startswith(f"{module}.")


def attribute(module: Any, name: str, file: str) -> Any:
    """Return what a module holds under a name, None where it holds nothing.

    Raises
    ------
    InputError
        If the module's `__getattr__` raises anything but AttributeError.
    """
    guard = Guard()
    try:
        with guard.armed():
            return getattr(module, name, None)
    except BaseException as error:
        if guard.is_users(error):
            raise
        raise failed(f"{file}, {name}", error, file, "a module whose names can be looked up") from None


def checksum(kind: str) -> str | None:
    """Return the SHA-256 of the file of a controller, for the provenance of a flight; None if it is in no file."""
    with suppress(OSError):
        return hashlib.sha256(Path(load(kind)[1]).read_bytes()).hexdigest()
    return None


def _from_file(path: Path) -> ModuleType:
    """Return the module of a file, run once for each content; no __pycache__ is left next to it."""
    source = path.read_bytes()
    digest = hashlib.sha256(str(path).encode() + b"\0" + source).hexdigest()[:12]
    name = f"custom_controller_{re.sub(r'[^A-Za-z0-9_]', '_', path.stem)}_{digest}"
    if name in sys.modules:
        return sys.modules[name]
    module = ModuleType(name)
    module.__file__ = str(path)
    code = compile(source, str(path), "exec", dont_inherit=True)
    sys.modules[name] = module  # numba and dataclasses look a module up by its name
    try:
        with _folders_searched(Path.cwd(), path.parent):
            exec(code, vars(module))
    except BaseException:
        sys.modules.pop(name, None)
        raise
    return module


@contextmanager
def _folders_searched(*folders: Path) -> Iterator[None]:
    """Search these folders for modules too, after all others, and leave no compiled files in them."""
    added = [str(folder) for folder in folders if str(folder) not in sys.path]
    before = sys.dont_write_bytecode
    sys.path += added
    sys.dont_write_bytecode = True
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.dont_write_bytecode = before
        for folder in added:
            with suppress(ValueError):
                sys.path.remove(folder)


def failed(where: str, error: BaseException, file: str, expected: str) -> InputError:
    """Return the error that says what the user's code raised, and at which line."""
    line, _ = place(error, file)
    remedy = "correct the code" if line is None else f"correct line {line}"
    return InputError(where, found=described(error, file), expected=expected, remedy=remedy)
