"""A flight held to the pace of a clock, a few rows at a time, each of them sent on; how late it was is kept.

It changes no bit of a flight: it looks at rows that are flown, and waits.
"""

from __future__ import annotations

import math
import socket
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from uavftc.errors import InputError
from uavftc.flight.build import Flight
from uavftc.jobs.live.flightgear import encoder
from uavftc.jobs.live.target import Target

PACKETS_HZ = 50.0  # of flight: what a display needs
PIECE_S = 0.05  # of a wait: Ctrl-C is looked for after each


def checked_pace(pace: float | None) -> float:
    """Return the seconds of flight in a second, 1 where none is given.

    Raises
    ------
    InputError
        If it is not a finite number above 0.
    """
    if pace is None:
        return 1.0
    if not (math.isfinite(pace) and pace > 0.0):
        expected = "a number above 0: seconds of flight in a second"
        raise InputError(f"--pace {pace:g}", found=f"{pace:g}", expected=expected, remedy="write --pace 1.0")
    return pace


class Pace:
    """Waits for the clock after every few rows, and sends the last of them.

    Parameters
    ----------
    flight
        What is flown.
    pace
        Seconds of flight in a second.
    target
        Where packets go; None is nowhere.
    """

    def __init__(self, flight: Flight, pace: float, target: Target | None = None) -> None:
        rate = flight.scenario.controller.rate_hz
        self.rows = max(1, round(rate / PACKETS_HZ))
        self._pace, self._target = pace, target
        self._encode = encoder(flight) if target is not None else None
        self._socket = socket.socket(target.family, socket.SOCK_DGRAM) if target is not None else None
        if self._socket is not None:
            self._socket.setblocking(False)
        self._started: float | None = None
        self._late: list[float] = []
        self._sent = self._refused = 0

    def take(self, row: np.void, stop: Callable[[], bool] | None = None) -> float:
        """Wait until a row is due, send it, and return how long that took, s; less where `stop` returns true."""
        begun = time.perf_counter()
        if self._started is None:
            self._started = begun - float(row["t"]) / self._pace
        due = self._started + float(row["t"]) / self._pace
        while (left := due - time.perf_counter()) > 0.0 and not (stop is not None and stop()):
            time.sleep(min(left, PIECE_S))
        self._late.append(max(0.0, time.perf_counter() - due))
        if self._socket is not None and self._encode is not None and self._target is not None:
            try:
                self._socket.sendto(self._encode(row), self._target.address)
                self._sent += 1
            except OSError:  # nobody there, or no room: the flight goes on
                self._refused += 1
        return time.perf_counter() - begun

    def close(self) -> None:
        """Close what it opened."""
        if self._socket is not None:
            self._socket.close()

    def timing(self) -> dict[str, Any]:
        """Return how it went, for `timing` of a summary: all of it wall-clock."""
        late = np.array(self._late or [0.0])
        found: dict[str, Any] = {
            "wall_pace": self._pace,
            "wall_lateness_median_s": float(np.median(late)),
            "wall_lateness_p99_s": float(np.quantile(late, 0.99)),
            "wall_lateness_max_s": float(late.max()),
        }
        if self._target is not None:
            found |= {"wall_packets_sent": self._sent, "wall_packets_refused": self._refused}
        return found


def lateness_text(timing: dict[str, Any]) -> str:
    """Return the line of the terminal on what `Pace.timing` says."""
    median, most = 1e3 * timing["wall_lateness_median_s"], 1e3 * timing["wall_lateness_max_s"]
    sent = f"; {timing['wall_packets_sent']} packets sent" if "wall_packets_sent" in timing else ""
    if refused := timing.get("wall_packets_refused"):
        sent += f", {refused} refused by the system"
    return f"pace {timing['wall_pace']:g}: late by {median:.1f} ms in the median, {most:.1f} ms at most{sent}"
