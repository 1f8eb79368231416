"""The user's cache: one home for compiled laws, trimmed models, copies of aircraft and the aircraft list.

It is UAVFTC_CACHE_DIR where that is set, else the system's place for the user's caches. What is there is run or
trusted, so a folder is used only if it belongs to this user and nobody else can write to it.
"""

from __future__ import annotations

import contextlib
import functools
import os
import tempfile
from pathlib import Path

import platformdirs

HOME_VARIABLE = "UAVFTC_CACHE_DIR"


def cache_home() -> Path:
    """Return the folder below which everything is cached; it need not exist."""
    override = os.environ.get(HOME_VARIABLE)
    return Path(override) if override else platformdirs.user_cache_path("uavftc")


def cache_folder(*names: str, home: Path | None = None) -> Path:
    """Return the folder home/names..., made if needed, that this user can write to and nobody else.

    Parameters
    ----------
    names
        Folder in folder, below the home.
    home
        `cache_home()` where it is None. Where it has no safe folder, a private temporary one is used: one
        for this user, or one for this process if that is not possible either.
    """
    user = os.getuid() if hasattr(os, "getuid") else "user"
    for base in (home or cache_home(), Path(tempfile.gettempdir()) / f"uavftc-{user}"):
        if _is_safe(base, names):
            return base.joinpath(*names)
    folder = _of_this_process().joinpath(*names)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@functools.cache
def _of_this_process() -> Path:
    return Path(tempfile.mkdtemp(prefix="uavftc-"))


def _is_safe(base: Path, names: tuple[str, ...]) -> bool:
    """Make the folder, and return whether it and all between it and the base are ours and can be written."""
    with contextlib.suppress(OSError):
        base.parent.mkdir(parents=True, exist_ok=True)
        for depth in range(len(names) + 1):
            folder = base.joinpath(*names[:depth])
            folder.mkdir(mode=0o700, exist_ok=True)
            if not _is_ours(folder):
                return False
        return os.access(base.joinpath(*names), os.W_OK)
    return False


def _is_ours(folder: Path) -> bool:
    """Return whether the folder is this user's and nobody else can write there."""
    if not hasattr(os, "getuid"):
        return True
    status = folder.stat()
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
