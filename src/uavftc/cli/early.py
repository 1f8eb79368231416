"""Ctrl-C in the first moments of a process: it imports next to nothing, since a traceback may come of each import."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]  # what `signal` is made of, and ten times faster to import
import os

INTERRUPTED = 130  # 128 + SIGINT, the shell's convention


def at_once(_number: int = 2, _frame: object = None) -> None:
    """End the process: nothing was begun yet, or all is done."""
    try:  # noqa: SIM105 - contextlib is one of the imports
        os.write(2, b"interrupted\n")
    except OSError:
        pass
    os._exit(INTERRUPTED)


def end_at_once() -> None:
    """From here on, Ctrl-C ends the process at once, unless somebody else has the signal, or it is ignored."""
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, at_once)
