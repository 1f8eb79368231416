"""Where a custom controller comes from: a file, an entry point, or a module by its import path."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import re
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from uavftc.control import whole
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
    if kind in SHIPPED or kind in registered():
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
    where = f"controller.kind, '{kind}'"
    file = kind
    try:
        if is_path(kind):
            module: Any = _from_file(Path(kind))
        else:
            entry = registered().get(kind)
            with _folders_searched(Path.cwd()):
                module = importlib.import_module(kind) if entry is None else entry.load()
        file = str(getattr(module, "__file__", None) or kind)
    except ModuleNotFoundError as error:
        if is_path(kind) or error.name is None or not f"{kind}.".startswith(f"{error.name}."):
            raise failed(where, error, file, "a module that can be imported") from None
        raise InputError(
            where,
            found=f"no module {error.name} in the environment or in {Path.cwd()}",
            expected="the import path of a module, the path of a .py file, or the name of an entry point",
            remedy=f"check the spelling, or go to the folder that holds it; give one as {HOW}",
        ) from None
    except OSError as error:
        raise InputError(
            where,
            found=f"a file that cannot be read: {error.strerror or error}",
            expected="a readable .py file",
            remedy="check the path and its permissions",
        ) from None
    except (Exception, SystemExit) as error:
        raise failed(where, error, file, "a module that can be imported") from None
    return module, file


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
        del sys.modules[name]
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


def described(error: BaseException, file: str) -> str:
    """Return what was raised, its line in the user's file, and the text of that line."""
    line, text = place(error, file)
    what = " ".join(traceback.format_exception_only(error)[-1].split())[:300]
    if line is None:
        return what
    return f"{what}; {file}, line {line}{f': {text}' if text else ''}"


def place(error: BaseException, file: str) -> tuple[int | None, str]:
    """Return the last line of `file` that the error passed through and its text; None where there is no such line."""
    if isinstance(error, SyntaxError) and error.filename == file:
        return error.lineno, (error.text or "").strip()
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    return (frames[-1].lineno, frames[-1].line or "") if frames else (None, "")
