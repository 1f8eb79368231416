"""The standard streams of a command: what happens to them neither ends a flight nor reaches the terminal unread."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Any, TextIO

# What a terminal would obey, spelt out: a name from a file or an option may hold anything. JSON has spelt its own
# below 0x20 already, and knows the spelling of the others.
_SPELT = {code: f"\\x{code:02x}" for code in range(0x20) if chr(code) not in "\n\t"} | {
    code: f"\\u{code:04x}" for code in range(0x7F, 0xA0)
}


class Stream:
    """A text stream that spells out control characters and goes on in silence when nothing can be written any more.

    Parameters
    ----------
    inner
        The stream itself.
    raw
        Whether control characters pass: rich colours its text, and spells out what is not its own.
    """

    def __init__(self, inner: TextIO, *, raw: bool = False) -> None:
        self._inner = inner
        self._raw = raw
        self.failed: OSError | None = None
        """Why nothing is written any more, where somebody ought to know: not of a reader that has gone."""
        if not raw:
            self.rich_proxied_file = Stream(inner, raw=True)

    def write(self, text: str) -> int:
        """Write, and return the number of characters that were given."""
        shown = text if self._raw else text.translate(_SPELT)
        try:
            self._inner.write(shown)
        except OSError as error:
            self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Write out what is buffered."""
        try:
            self._inner.flush()
        except OSError as error:
            self._give_up(error)

    def why_failed(self) -> OSError | None:
        """Return `failed`, of rich's part of the stream too."""
        return self.failed or (None if self._raw else self.rich_proxied_file.failed)

    def _give_up(self, error: OSError) -> None:
        if not isinstance(error, BrokenPipeError):  # the reader has seen enough, as in `uavftc-fly ... | head -1`
            self.failed = self.failed or error
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._inner.fileno())  # what is still in the buffers goes there
            os.close(nowhere)
            self._inner.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._inner, name)


def open_closed_ones() -> None:
    """Put the null device where a standard stream is closed, or the next file opened would get its place.

    A history would then take what JSBSim prints.
    """
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != descriptor:
                os.dup2(nowhere, descriptor)
                os.close(nowhere)


def guard() -> tuple[Stream, Stream]:
    """Put a `Stream` in place of standard output and standard error, and return both."""
    open_closed_ones()
    guarded = []
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        inner = getattr(sys, name)
        if inner is None:  # it was closed when the process began
            inner = open(descriptor, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 - for as long as the process
        with contextlib.suppress(AttributeError):  # not of what a test puts there
            inner.reconfigure(errors="backslashreplace")
        guarded.append(Stream(inner))
        setattr(sys, name, guarded[-1])
    return guarded[0], guarded[1]
