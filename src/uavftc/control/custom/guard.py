"""Where the user's own code runs: how long a step may take, and whether a KeyboardInterrupt is the user's.

On the main thread, where the system has interval timers (not on Windows), a step that takes too long is interrupted as
it stands. Elsewhere, and in a call into compiled code that does not return to Python, it is measured once it is over. A
step that never comes back from compiled code is not interrupted by anything but the end of the process.
"""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

_AGAIN_S = 0.1  # after which a step that caught its interruption is interrupted again
_LEAST_S = 1e-3  # of the timer: it must not ring all the time


class Overdue(BaseException):  # not an Exception: a step that catches all of those is interrupted too
    """Raised inside a step that takes too long."""


class Guard:
    """What is known of the user's code while it runs.

    Parameters
    ----------
    timeout_s
        How long one timed call may take, s.
    """

    def __init__(self, timeout_s: float = math.inf) -> None:
        self.timeout_s = timeout_s
        self._pressed = False
        self._since: float | None = None
        """When the timed call that runs now began."""

    @contextmanager
    def armed(self) -> Iterator[None]:
        """While it is open, timed calls are interrupted in time and Ctrl-C is noticed, which acts as it did before."""
        self._pressed = False
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.getsignal(signal.SIGINT)

        def noticed(number: int, frame: Any) -> None:
            self._pressed = True
            before(number, frame)  # type: ignore[operator, misc]  # it is callable, or this is not installed

        # somebody else's timer is left alone: then steps are measured
        timed = (
            self.timeout_s < math.inf
            and hasattr(signal, "setitimer")
            and signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
        )
        if callable(before):
            signal.signal(signal.SIGINT, noticed)
        if timed:
            signal.signal(signal.SIGALRM, self._ring)
            signal.setitimer(signal.ITIMER_REAL, self.timeout_s)
        try:
            yield
        finally:
            if timed:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                signal.signal(signal.SIGALRM, signal.SIG_DFL)
            if signal.getsignal(signal.SIGINT) is noticed:  # the first Ctrl-C of a flight hands it back by itself
                signal.signal(signal.SIGINT, before)

    def is_users(self, error: BaseException) -> bool:
        """Return whether an error is a Ctrl-C of the user, not a KeyboardInterrupt that the code raised by itself."""
        return isinstance(error, KeyboardInterrupt) and self._pressed

    def timed(self, function: Callable[..., Any], *arguments: Any, **named: Any) -> Any:
        """Return what the function returns.

        Raises
        ------
        Overdue
            If it took longer than allowed, whatever it returned or raised.
        """
        self._since = time.monotonic()
        try:
            result = function(*arguments, **named)
        except BaseException as error:
            if self._is_overdue() and not self.is_users(error) and not isinstance(error, Overdue):
                raise Overdue from None
            raise
        if self._is_overdue():
            raise Overdue
        return result

    def _is_overdue(self) -> bool:
        """Return whether the timed call took too long, and end its time."""
        since, self._since = self._since, None
        return since is not None and time.monotonic() - since > self.timeout_s and sys.gettrace() is None

    def _ring(self, _signal: int, _frame: object) -> None:
        """Interrupt the timed call if its time is over; else ring again when it will be."""
        now = time.monotonic()
        left = self.timeout_s if self._since is None else self._since + self.timeout_s - now
        if left <= 0.0 and sys.gettrace() is not None:  # somebody is looking at it with a debugger
            self._since, left = now, self.timeout_s
        signal.setitimer(signal.ITIMER_REAL, max(left, _LEAST_S) if left > 0.0 else _AGAIN_S)
        if left <= 0.0:
            raise Overdue
