"""Signals that wait: what must not be left half done is finished first."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class Hold:
    """A context in which the given signals are noted; at its end each acts as it would have without it.

    Off the main thread, where Python delivers no signals, it does nothing.

    Parameters
    ----------
    signals
        By default all that end a process.
    """

    def __init__(self, *signals: int) -> None:
        self._signals = signals or ENDING
        self._before: dict[int, Any] = {}
        self._noted: list[int] = []
        self._acts_at = 0  # the how-manyth Ctrl-C is no longer held; 0 holds all
        self._second_acted = False  # and whoever catches its KeyboardInterrupt keeps what there is

    def __enter__(self) -> Hold:
        if threading.current_thread() is threading.main_thread():
            for number in self._signals:
                before = signal.getsignal(number)
                if before is not None and before != signal.SIG_IGN:  # None: not Python's own, and cannot be put back
                    self._before[number] = before
                    signal.signal(number, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)
        for number in dict.fromkeys(self._noted):
            signal.raise_signal(number)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self._noted.append(number)
        if number == signal.SIGINT and 0 < self._acts_at <= self._noted.count(number):
            self._noted.clear()
            self._second_acted = self._acts_at == 2
            self._acts_at = 0
            raise KeyboardInterrupt

    def interrupted(self) -> bool:
        """Return whether there was a Ctrl-C."""
        return self._second_acted or signal.SIGINT in self._noted

    def take(self) -> bool:
        """Return whether there was a Ctrl-C, which then does nothing more."""
        was, self._second_acted = self.interrupted(), False
        self._noted = [number for number in self._noted if number != signal.SIGINT]
        return was

    def note_again(self) -> None:
        """Note a Ctrl-C whose KeyboardInterrupt was caught."""
        self._noted.append(signal.SIGINT)

    @contextmanager
    def second_acts(self) -> Iterator[Callable[[], bool]]:
        """Yield `interrupted`; a second Ctrl-C in this context is a KeyboardInterrupt at once."""
        self._acts_at = 2
        try:
            yield self.interrupted
        finally:
            self._acts_at = 0

    @contextmanager
    def first_acts(self) -> Iterator[None]:
        """Let a Ctrl-C in this context be a KeyboardInterrupt at once."""
        self._acts_at = 1
        try:
            if self.take():
                raise KeyboardInterrupt
            yield
        finally:
            self._acts_at = 0
