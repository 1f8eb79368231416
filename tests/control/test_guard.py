"""The guard of the user's code: a step that takes too long, and whose a KeyboardInterrupt is."""

from __future__ import annotations

import signal
import sys
import threading
import time
from contextlib import suppress

import pytest

from uavftc.control.custom.guard import Guard, Overdue


def spin(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


def handlers():
    return signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)[0]


@pytest.mark.parametrize("block", [time.sleep, spin], ids=["asleep", "busy"])
def test_a_blocked_step_is_interrupted_in_time_and_the_signals_are_handed_back(block):
    before, guard, started = handlers(), Guard(0.1), time.monotonic()
    with pytest.raises(Overdue), guard.armed():
        guard.timed(block, 60.0)
    assert 0.1 <= time.monotonic() - started < 10.0
    assert handlers() == before


def test_a_step_has_its_whole_time_whenever_it_begins():
    # the timer runs through all steps; what was left of it when a step began is not that step's limit
    guard = Guard(0.2)
    with guard.armed():
        for _ in range(3):
            guard.timed(time.sleep, 0.12)
        with pytest.raises(Overdue):
            guard.timed(time.sleep, 60.0)
        time.sleep(0.3)  # between two steps nothing is timed
        assert guard.timed(lambda: 5) == 5


def test_a_step_that_catches_it_is_interrupted_again_and_reported_all_the_same():
    def stubborn():
        for _ in range(3):
            with suppress(BaseException):
                time.sleep(60.0)
        raise ValueError("something else")

    guard = Guard(0.05)
    with pytest.raises(Overdue), guard.armed():
        guard.timed(stubborn)


def test_off_the_main_thread_a_step_is_measured_once_it_is_over():
    found = []

    def work():
        guard = Guard(0.01)
        with guard.armed():
            try:
                guard.timed(time.sleep, 0.05)
            except Overdue:
                found.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [True]


def test_a_timer_of_somebody_else_is_left_alone(monkeypatch):
    before = signal.signal(signal.SIGALRM, lambda *_: None)
    try:
        guard = Guard(0.01)
        with guard.armed():
            assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
            with pytest.raises(Overdue):
                guard.timed(time.sleep, 0.05)
    finally:
        signal.signal(signal.SIGALRM, before)


def test_under_a_debugger_the_time_does_not_count():
    # who stands at a breakpoint for a minute goes on with the flight
    guard, before = Guard(0.05), sys.gettrace()
    with guard.armed():
        try:
            sys.settrace(lambda *_: None)
            assert guard.timed(lambda: time.sleep(0.2)) is None
        finally:
            sys.settrace(before)


def test_a_keyboard_interrupt_is_the_users_only_after_a_ctrl_c():
    guard = Guard()
    with guard.armed():
        assert not guard.is_users(KeyboardInterrupt())
        with pytest.raises(KeyboardInterrupt) as error:
            signal.raise_signal(signal.SIGINT)
        assert guard.is_users(error.value)
        assert not guard.is_users(ValueError())
