"""Signals that a requirement may name: the columns of the history, and what is derived from them.

    {phi,theta,psi}_error_rad     reference less attitude, the heading's within half a turn
    NAME_travel_radps             of a deflection NAME_rad: how far it went in the window behind the sample, over the
                                  length of the window; of a command too (aileron_cmd_travel_radps)
    NAME_saturated_share          of an axis' surface: the share of the samples in the window at which its command was
                                  at or beyond its limits; 0 where it has none

Every name that ends in `_rad`, `_radps` or `_radps2` may end in `_deg`, `_degps` or `_degps2` in its place. At the
start, the window reaches back to it alone, and what has not been flown counts as at rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import NamedTuple, Protocol

import numpy as np

from uavftc.core.signals import SURFACES, Column, axis_error, column

WINDOW_S = 2.0
"""Length of the window of travel and saturated share where a requirement does not say it, s."""
IN_DEGREES = {"rad": "deg", "radps": "degps", "radps2": "degps2"}

Limits = Mapping[str, tuple[float, float]]
"""Least and greatest command about trim of an axis' surface, by its name, rad."""


class Source(Protocol):
    """One signal of a flight while it goes by."""

    def take(self, records: np.ndarray) -> np.ndarray:
        """Return the values at the next rows, shape (n,)."""


class Window(NamedTuple):
    """The samples behind one of them, and with it."""

    rows: int
    """How many steps it reaches back."""
    length_s: float


class Known(NamedTuple):
    """A name that a requirement may use."""

    make: Callable[[Window], Source]
    windowed: bool = False
    """Whether it looks back over a window."""


class Plain:
    """A value of the same sample.

    Parameters
    ----------
    value
        Given records, shape (n,), returns shape (n,).
    factor
        From the unit of `value` to that of the name.
    """

    def __init__(self, value: Callable[[np.ndarray], np.ndarray], factor: float = 1.0) -> None:
        self._value, self._factor = value, factor

    def take(self, records: np.ndarray) -> np.ndarray:
        """Return the values at the next rows."""
        values = self._value(records)
        return values if self._factor == 1.0 else self._factor * values


class Behind:
    """What a sum has grown by over the window behind each sample, times a factor.

    Parameters
    ----------
    value
        Given records, shape (n,), returns shape (n,).
    increments
        Given these values and the one before them, or the first of all, returns what is added at each, shape (n,).
    window
        How far to look back.
    factor
        Of the result.
    """

    def __init__(
        self,
        value: Callable[[np.ndarray], np.ndarray],
        increments: Callable[[np.ndarray, float], np.ndarray],
        window: Window,
        factor: float,
    ) -> None:
        self._value, self._increments, self._factor = value, increments, factor
        self._last: float | None = None
        self._sums = np.zeros(window.rows)  # at the samples that a window may still begin at

    def take(self, records: np.ndarray) -> np.ndarray:
        """Return the values at the next rows."""
        values = np.array(self._value(records))  # next to each other in memory
        added = self._increments(values, float(values[0] if self._last is None else self._last))
        self._last = float(values[-1])
        n = len(self._sums)
        # summed one after the other, so that the chunks in which a flight comes change no bit
        sums = np.cumsum(np.concatenate([self._sums[-1:], added]))[1:]
        behind = np.concatenate([self._sums, sums])
        self._sums = behind[-n:]
        return self._factor * (sums - behind[: len(sums)])


def known_signals(columns: Sequence[Column], limits: Limits) -> dict[str, Known]:
    """Return every name that a requirement may use in a flight with these columns, rad and rad/s first.

    Parameters
    ----------
    columns
        That the flight records and its plant knows.
    limits
        Of the commands of the axes.
    """
    return dict(_signals(tuple(columns), tuple(limits.items())))


@lru_cache(maxsize=16)  # the same for every flight of a campaign, and a tenth of a millisecond each time
def _signals(columns: tuple[Column, ...], of_axes: tuple[tuple[str, tuple[float, float]], ...]) -> dict[str, Known]:
    limits = dict(of_axes)
    found: dict[str, Known] = {"t": _plain(lambda records: records["t"])}
    for spec in columns:
        found[spec.name] = _plain(partial(_column, spec))
    for i, name in enumerate(("phi", "theta", "psi")):
        found[f"{name}_error_rad"] = _plain(partial(_error, i))
    for spec in columns:
        if _is_deflection(spec):
            found[f"{spec.name.removesuffix('_rad')}_travel_radps"] = Known(_travel(spec), windowed=True)
    for i, name in enumerate(SURFACES):
        found[f"{name}_saturated_share"] = Known(_saturated(i, limits.get(name, (-math.inf, math.inf))), windowed=True)
    return found | _in_degrees(found)


def _column(spec: Column, records: np.ndarray) -> np.ndarray:
    return column(records, spec)


def _error(axis: int, records: np.ndarray) -> np.ndarray:
    return axis_error(records, axis)


def _plain(value: Callable[[np.ndarray], np.ndarray]) -> Known:
    return Known(lambda window: Plain(value))


def _is_deflection(spec: Column) -> bool:
    return spec.name.endswith("_rad") and (spec.effector is not None or spec.field in ("v2", "u2"))


def _way(values: np.ndarray, before: float) -> np.ndarray:
    steps = np.empty_like(values)
    np.subtract(values[1:], values[:-1], out=steps[1:])
    steps[0] = values[0] - before
    return np.abs(steps, out=steps)


def _travel(spec: Column) -> Callable[[Window], Source]:
    return lambda window: Behind(partial(_column, spec), _way, window, 1.0 / window.length_s)


def _saturated(axis: int, limits: tuple[float, float]) -> Callable[[Window], Source]:
    def at_limit(values: np.ndarray, before: float) -> np.ndarray:
        return ((values <= limits[0]) | (values >= limits[1])).astype(float)

    return lambda window: Behind(lambda records: records["v2"][:, axis], at_limit, window, 1.0 / window.rows)


def _in_degrees(known: Mapping[str, Known]) -> dict[str, Known]:
    found = {}
    for name, signal in known.items():
        stem, _, unit = name.rpartition("_")
        if unit in IN_DEGREES:
            found[f"{stem}_{IN_DEGREES[unit]}"] = signal._replace(make=_turned(signal.make))
    return found


def _turned(make: Callable[[Window], Source]) -> Callable[[Window], Source]:
    return lambda window: Plain(make(window).take, math.degrees(1.0))
