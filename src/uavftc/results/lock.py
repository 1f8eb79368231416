"""The lock of a result folder: one job at a time writes to it, and what a killed job left beside it is known as ours.

It is a hidden file next to the folder, `.<name>.uavftc`, held by `flock` while a job writes: the system itself lets go
of it when the job ends, however it ends, in whatever container. In the file stand a line that says what it is and a
random token for each job; a folder beside it with such a token in its name is ours, and no other is.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import stat
from collections.abc import Sequence
from pathlib import Path

MARK = "uavftc: a job writes the results of the folder of this name; the file goes when it has ended"
_TOKEN = re.compile(r"[0-9a-f]{16}")
_MOST_BYTES = 1 << 16


class TakenError(Exception):
    """Another job holds the lock."""


class NotOursError(Exception):
    """Something that uavftc did not write has the lock's name."""


class Lock:
    """The lock of the folder `target`; `token` is in the names of what its holder writes beside it."""

    def __init__(self, target: Path) -> None:
        self.path = target.with_name(f".{target.name}.uavftc") if target.name else target
        self.token = secrets.token_hex(8)
        self._descriptor: int | None = None
        self._others: list[str] = []

    @property
    def held(self) -> bool:
        """Whether it was taken and not released yet."""
        return self._descriptor is not None

    def take(self) -> list[str]:
        """Take the lock and return the tokens of jobs that were killed; empty where the system has no such locks.

        Raises
        ------
        TakenError, NotOursError
            As they say; nothing is changed then.
        OSError
            If the file cannot be written.
        """
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
        while True:
            descriptor = os.open(self.path, flags, 0o666)
            try:
                if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                    raise NotOursError
                alone = _flock(descriptor)
                if self._is(descriptor):
                    text = os.read(descriptor, _MOST_BYTES).decode(errors="replace")
                    if text and not text.startswith(MARK):  # empty: killed before it wrote anything
                        raise NotOursError
                    tokens = [line for line in text.splitlines()[1:] if _TOKEN.fullmatch(line)]
                    _write(descriptor, [*tokens, self.token])
                    break
            except (TakenError, NotOursError):
                os.close(descriptor)
                raise
            except BaseException:
                self._forget(descriptor)
                raise
            os.close(descriptor)  # its holder removed it between our two looks
        self._descriptor = descriptor
        self._others = [] if alone else tokens
        return tokens if alone else []

    def release(self, *, forget: bool = True) -> None:
        """Let go, and remove the file unless it is to say that something of ours is left; nothing if not held."""
        descriptor = self._descriptor
        if descriptor is None:
            return
        with contextlib.suppress(OSError):
            if not forget:
                pass
            elif self._others:  # no locks there: they may still be at work
                _write(descriptor, self._others)
            elif self._is(descriptor):
                _remove(self.path)
        self._descriptor = None
        _close(descriptor)

    def _forget(self, descriptor: int) -> None:
        """Close a file that could not be made the lock, and remove it if nothing stands in it."""
        with contextlib.suppress(OSError):
            if os.fstat(descriptor).st_size == 0 and self._is(descriptor):
                _remove(self.path)
        _close(descriptor)

    def _is(self, descriptor: int) -> bool:
        """Return whether the open file is still the one that has the name."""
        try:
            return os.path.samestat(os.fstat(descriptor), os.lstat(self.path))
        except FileNotFoundError:
            return False


def _close(descriptor: int) -> None:
    with contextlib.suppress(OSError):  # it is closed then too
        os.close(descriptor)


def _remove(path: Path) -> None:
    """Remove a file; what failed once by chance is tried again."""
    try:
        path.unlink()
    except OSError:
        path.unlink(missing_ok=True)


def _write(descriptor: int, tokens: Sequence[str]) -> None:
    text = "\n".join([MARK, *tokens, ""]).encode()
    if os.pwrite(descriptor, text, 0) < len(text):  # a disk that is full in the middle of it
        os.ftruncate(descriptor, 0)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    os.ftruncate(descriptor, len(text))


def _flock(descriptor: int) -> bool:
    """Lock an open file; return False where the system, or the file system, knows no such locks.

    Raises
    ------
    TakenError
        If another process, or another part of this one, has it.
    """
    try:
        import fcntl  # noqa: PLC0415 - not on Windows
    except ImportError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise TakenError from None
    except OSError:
        return False
    return True
