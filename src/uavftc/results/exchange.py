"""Two folders that change places in one step, where the system can do that."""

from __future__ import annotations

import errno
import functools
import os
import sys
from collections.abc import Callable
from pathlib import Path

_AT_FDCWD = -100  # linux/fcntl.h
_RENAME_EXCHANGE = 2  # linux/fs.h
_NOT_THERE = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)  # of the system, or of the file system


def exchange(one: Path, other: Path) -> bool:
    """Let two paths change places in one step; return False, with nothing done, where that cannot be had.

    Raises
    ------
    OSError
        If one of them is not there, or may not be moved.
    """
    renameat2 = _renameat2()
    if renameat2 is None:
        return False
    code = renameat2(os.fsencode(one), os.fsencode(other))
    if code in _NOT_THERE:
        return False
    if code:
        raise OSError(code, os.strerror(code), str(one), None, str(other))
    return True


@functools.cache
def _renameat2() -> Callable[[bytes, bytes], int] | None:
    """Return the system's exchange of two paths, which gives its error number or 0; None where there is none."""
    if not sys.platform.startswith("linux"):
        return None
    import ctypes  # noqa: PLC0415

    function = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)  # glibc since 2.28
    if function is None:
        return None
    function.argtypes = (ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint)

    def call(one: bytes, other: bytes) -> int:
        failed = function(_AT_FDCWD, one, _AT_FDCWD, other, _RENAME_EXCHANGE)
        return ctypes.get_errno() if failed else 0

    return call
