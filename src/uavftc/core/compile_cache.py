"""The cache of compiled laws: where numba keeps machine code, so that only the first flight compiles.

numba notices a change in the file of an entry only, not in what the entry calls. So the code is in a folder that is
named after all compiled sources. Below it, a law from outside this project has a folder named after its sources.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numba

from uavftc.core import cache

COMPILED = (
    "core", "control", "sensors", "actuators", "environment", "plants", "flight/envelope.py", "gym/look.py",
    "gym/machine.py", "stage.py",
)  # fmt: skip
"""Where this project's compiled code lives."""


@functools.cache
def compile_cache_dir() -> Path:
    """Return the folder of compiled laws for exactly this source, made if needed.

    It lies in the user's cache, never next to the source: an installed package may be read-only. NUMBA_CACHE_DIR moves
    it where UAVFTC_CACHE_DIR, which moves all caches, is not set.
    """
    here = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256(numba.__version__.encode())
    for part in COMPILED:
        path = here / part
        for file in [path] if path.is_file() else sorted(path.rglob("*.py")):
            digest.update(file.relative_to(here).as_posix().encode() + b"\0" + file.read_bytes())
    name = digest.hexdigest()[:16]
    laws_only = None if os.environ.get(cache.HOME_VARIABLE) else os.environ.get("NUMBA_CACHE_DIR")
    return cache.cache_folder(name, home=Path(laws_only) if laws_only else None)


def is_compiled() -> bool:
    """Whether an earlier flight has left compiled laws for this source."""
    return any(compile_cache_dir().rglob("*.nbi"))


def outside(entry: Callable[..., None]) -> str | None:
    """Return the hash of the source of a law that is not this project's, or None.

    The law's file counts, and what stands next to it: its folder, or all of its package.
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
