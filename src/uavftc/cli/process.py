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

from uavftc.cli import interrupt, streams
from uavftc.cli.outcome import UNEXPECTED

OBJECTS_A_COLLECTION = 50_000  # Python's own 700 collect a hundred times while the imports make what stays anyway


def run(command: Callable[[], object]) -> NoReturn:
    """Run a command as the whole of this process, and end it.

    The process ends without taking itself down: freeing LLVM, numba and JSBSim object by object takes as long as a
    third of a short flight's process, and some aircraft crash JSBSim then. Exit functions are called and the standard
    streams are written out; a command closes its files itself.
    """
    interrupt.end_at_once()
    stdout, stderr = streams.guard()
    gc.set_threshold(OBJECTS_A_COLLECTION, 20, 100)
    try:
        command()
        code = 0
    except SystemExit as end:
        if end.code is not None and not isinstance(end.code, int):
            raise
        code = end.code or 0
    for stream in (stdout, stderr):
        stream.flush()
    if (failed := stdout.why_failed()) is not None:
        print(f"error: standard output: {failed.strerror or failed}", file=sys.stderr)
        code = code or UNEXPECTED
    if threading.active_count() > 1:  # somebody is still at work: end as Python does
        sys.exit(code)
    with contextlib.suppress(Exception):  # nobody is left to read what an exit function raises
        atexit._run_exitfuncs()
    for stream in (stdout, stderr):
        stream.flush()
    os._exit(code)
