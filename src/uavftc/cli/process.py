"""The process of a command: how it starts and how it ends, for a flight that takes less time than its imports."""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import sys
import threading
from collections.abc import Callable
from typing import NoReturn

OBJECTS_A_COLLECTION = 50_000  # Python's own 700 collect a hundred times while the imports make what stays anyway


def run(command: Callable[[], object]) -> NoReturn:
    """Run a command as the whole of this process, and end it.

    The process ends without taking itself down: freeing LLVM, numba and JSBSim object by object takes as long as a
    third of a short flight's process, and some aircraft crash JSBSim then. Exit functions are called and the standard
    streams are written out; a command closes its files itself.
    """
    gc.set_threshold(OBJECTS_A_COLLECTION, 20, 100)
    try:
        command()
        code = 0
    except SystemExit as end:
        if end.code is not None and not isinstance(end.code, int):
            raise
        code = end.code or 0
    if threading.active_count() > 1:  # another thread is still running: end as Python does
        sys.exit(code)
    with contextlib.suppress(Exception):  # nobody is left to read what an exit function raises
        atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):  # its reader has gone, or it is closed
            code = code or 120  # Python's code for this
    os._exit(code)
