"""The cache of compiled laws: where numba keeps machine code, so that only the first flight compiles.

numba notices a change in the file of an entry only, not in what the entry calls. So the code lies in a folder that is
named after all compiled sources; that of a law from outside this project in one below it, named after its own.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numba
import platformdirs

COMPILED = ("core", "control", "sensors", "actuators", "plants", "flight/envelope.py")
"""Where this project's compiled code lives."""


@functools.cache
def compile_cache_dir() -> Path:
    """Return the folder of compiled laws for exactly this source, made if needed.

    It lies in the user's cache (or under NUMBA_CACHE_DIR), never beside the source: an installed package may be
    read-only. Where no such folder can be written, a private temporary one serves for this user.
    """
    here = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256(numba.__version__.encode())
    for part in COMPILED:
        path = here / part
        for file in [path] if path.is_file() else sorted(path.rglob("*.py")):
            digest.update(file.relative_to(here).as_posix().encode() + b"\0" + file.read_bytes())
    name = digest.hexdigest()[:16]
    override = os.environ.get("NUMBA_CACHE_DIR")
    user = Path(override) if override else platformdirs.user_cache_path("uavftc")
    for base in (user, Path(tempfile.gettempdir()) / f"uavftc-{os.getuid() if hasattr(os, 'getuid') else 'user'}"):
        folder = base / name
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            if os.access(folder, os.W_OK) and _is_ours(base) and _is_ours(folder):
                return folder
    return Path(tempfile.mkdtemp(prefix="uavftc-"))


def _is_ours(folder: Path) -> bool:
    """Whether nobody else can write there: what lies in the cache is run."""
    if not hasattr(os, "getuid"):
        return True
    status = folder.stat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


def is_compiled() -> bool:
    """Whether an earlier flight has left compiled laws for this source."""
    return any(compile_cache_dir().rglob("*.nbi"))


def outside(entry: Callable[..., None]) -> str | None:
    """Return the hash of the source of a law that is not this project's, or None.

    The law's file counts, and what stands beside it: its folder, or all of its package.
    """
    file = Path(entry.__code__.co_filename).resolve()
    here = Path(__file__).resolve().parents[1]
    if here in file.parents or not file.is_file():
        return None
    package = entry.__module__.split(".")[:-1]
    top = file.parents[len(package) - 1] if package else file.parent
    digest = hashlib.sha256(str(top).encode())
    for source in sorted(top.rglob("*.py") if package else top.glob("*.py")):
        with contextlib.suppress(OSError):
            digest.update(source.relative_to(top).as_posix().encode() + b"\0" + source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@contextlib.contextmanager
def compile_cache(part: str | None = None) -> Iterator[None]:
    """Point numba's cache at our folder while a law is compiled; other users of numba keep theirs.

    `part` names a folder in it, for a law from outside this project (`outside`).
    """
    before = numba.config.CACHE_DIR
    folder = compile_cache_dir()
    if part is not None:
        folder /= part
        folder.mkdir(mode=0o700, exist_ok=True)
    numba.config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before
