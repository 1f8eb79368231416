"""The progress of many flights, on standard error: one line that is written over, or in a log one now and then."""

from __future__ import annotations

import sys
import time
from typing import TextIO

SCREEN_S = 0.5  # between two lines on a terminal
LOG_S = 30.0  # and in a log


class Rate:
    """Shows flights done, how many a second, the time left and failures; it is called as `sweep.Progress` is.

    Parameters
    ----------
    stream
        Where to; standard error by default.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._screen = self._stream.isatty()
        self._began: tuple[float, int] | None = None
        self._shown_at = -1e9
        self._width = 0

    def __call__(self, done: int, total: int, failures: int) -> None:
        """Show the state, unless it was shown a moment ago."""
        now = time.monotonic()
        if self._began is None:
            self._began = now, done
        if done < total and now - self._shown_at < (SCREEN_S if self._screen else LOG_S):
            return
        self._shown_at = now
        began, before = self._began
        text = line(done, total, failures, done - before, now - began)
        if self._screen:
            self._stream.write(f"\r{text.ljust(self._width)}")
            self._width = len(text)
        else:
            self._stream.write(f"{text}\n")
        self._stream.flush()

    def end(self) -> None:
        """Leave the line on the screen as it is, and begin another."""
        if self._screen and self._width:
            self._stream.write("\n")
            self._stream.flush()


def line(done: int, total: int, failures: int, flown: int, seconds: float) -> str:
    """Return the state in a line, from flights flown in a number of seconds."""
    parts = [f"{done} of {total} flights ({100.0 * done / total:.0f} %)"]
    if flown and seconds > 0:
        rate = flown / seconds
        parts.append(f"{rate:.3g} a second")
        if done < total:
            parts.append(f"{clock((total - done) / rate)} left")
    parts.append(f"{failures} {'failure' if failures == 1 else 'failures'}")
    return ", ".join(parts)


def clock(seconds: float) -> str:
    """Return a duration in short."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
