"""Ctrl-C, from the first moment of a command to its last: one line and exit code 130, never a traceback."""

from __future__ import annotations

import _thread
import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType

from uavftc.cli import early

_seen = threading.Event()


def end_at_once() -> None:
    """From here on, Ctrl-C ends the process at once, unless somebody else has the signal, or it is ignored."""
    early.end_at_once()
    if signal.getsignal(signal.SIGINT) is early.at_once:
        sys.unraisablehook = _unraisable


@contextlib.contextmanager
def raising() -> Iterator[None]:
    """Within, Ctrl-C is Python's KeyboardInterrupt, so that a command clears up behind itself."""
    before = signal.getsignal(signal.SIGINT)
    ours = before is early.at_once
    try:
        if ours:
            signal.signal(signal.SIGINT, _raise)
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)


def was_seen() -> bool:
    """Return whether there was a Ctrl-C, whatever a library made of the KeyboardInterrupt."""
    return _seen.is_set()


def _raise(_number: int, _frame: FrameType | None) -> None:
    _seen.set()
    raise KeyboardInterrupt


def _unraisable(what: sys.UnraisableHookArgs) -> None:
    """Raise a KeyboardInterrupt again that fell where nothing can be raised, as in a destructor."""
    if what.exc_type is KeyboardInterrupt:
        again = threading.Timer(0.01, _thread.interrupt_main)
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(what)
