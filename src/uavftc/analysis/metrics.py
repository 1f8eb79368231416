"""The metrics of a flight, one entry each in the table `METRICS`: the paper's six of section 4, and control activity.

    IAE = int |e| dt    ISE = int e^2 dt    ITAE = int t |e| dt    ITSE = int t e^2 dt        (rad, s)

e is the attitude error x1_c - x1; the integrals are trapezoidal over the rows. The steady-state error is |e| in the
last row; the convergence time is that of the first row after the last one with |e| > 0.02 deg (the paper's band; its
unit is the one that fits its printed figures). Control activity is the total variation of the commanded deflection
v2, before saturation: it separates controllers that track alike but move the surfaces differently. It belongs to its
condition: a surface's effect grows with the square of the airspeed, the gains do not, and the rudder that travels
0.14 rad in scenario 3 at 30 m/s travels 37 rad at 45 m/s (`--set initial.airspeed_mps=45`). It is that of exact sensors
too: with noise on the gyro every controller travels more (tools/noise_activity.py).

An axis that the aircraft does not control has no metric: every one of them is None there.

Summary, terminal, comparison and CSV list what `METRICS` holds, in its order: a new metric is one more entry.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from uavftc.core.axes import ALL, Controlled
from uavftc.core.signals import AXES, attitude_error

CONVERGENCE_BAND_DEG = 0.02  # section 4: "tracking errors [...] kept within 0.02"
INTEGRALS = ("iae", "ise", "itae", "itse")
"""Names of the paper's integral metrics, which its tables compare; other metrics may be integrals too."""


class Piece(NamedTuple):
    """The next rows of a flight as a metric sees them, the last row of the piece before in front of them."""

    t: np.ndarray
    """Time, s, shape (n,)."""
    error: np.ndarray
    """|x1_c - x1|, rad, shape (n, 3)."""
    command: np.ndarray
    """v2, rad, shape (n, 3): aileron, elevator, rudder."""


class Measure(Protocol):
    """What a metric keeps of a flight while it goes by; its size does not grow with the flight."""

    def take(self, piece: Piece) -> None:
        """Add the next rows."""

    def values(self) -> Sequence[float | None]:
        """Return the value for roll, pitch and yaw so far; None, or what is not finite, where there is none."""


class Integral:
    """The integral over time of f(t, |e|), by the trapezoidal rule.

    Parameters
    ----------
    f
        Given t, s, shape (n, 1), and |e|, rad, shape (n, 3), returns shape (n, 3).
    """

    def __init__(self, f: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
        self._f = f
        self._sum = np.zeros(3)

    def take(self, piece: Piece) -> None:
        """Add the trapezoids between the rows."""
        t = piece.t[:, None]
        f = self._f(t, piece.error)
        self._sum += (0.5 * (f[1:] + f[:-1]) * np.diff(t, axis=0)).sum(axis=0)

    def values(self) -> Sequence[float | None]:
        """Return the integrals, in the unit of f times s."""
        return self._sum.tolist()


class LastError:
    """|e| in the last row, deg."""

    def __init__(self) -> None:
        self._last = np.full(3, math.nan)

    def take(self, piece: Piece) -> None:
        """Keep the last row."""
        self._last = np.degrees(piece.error[-1])

    def values(self) -> Sequence[float | None]:
        """Return |e|, deg."""
        return self._last.tolist()


class ConvergenceTime:
    """The time of the first row after the last one outside the band, s; None while outside, 0 if never outside."""

    def __init__(self) -> None:
        self._at: list[float | None] = [0.0, 0.0, 0.0]

    def take(self, piece: Piece) -> None:
        """Look for the last row outside."""
        outside = np.degrees(piece.error) > CONVERGENCE_BAND_DEG
        for axis in range(3):
            where = np.flatnonzero(outside[:, axis])
            if len(where):
                after = where[-1] + 1
                self._at[axis] = float(piece.t[after]) if after < len(piece.t) else None

    def values(self) -> Sequence[float | None]:
        """Return the times, s."""
        return list(self._at)


class TotalVariation:
    """The sum of |change| of the commanded deflection of each axis' surface, rad."""

    def __init__(self) -> None:
        self._sum = np.zeros(3)

    def take(self, piece: Piece) -> None:
        """Add the changes between the rows."""
        self._sum += np.abs(np.diff(piece.command, axis=0)).sum(axis=0)

    def values(self) -> Sequence[float | None]:
        """Return the sums, rad."""
        return self._sum.tolist()


@dataclass(frozen=True)
class Metric:
    """One metric: what it is called, how it is computed, and how its value is shown."""

    name: str
    """Its key in `summary.json`."""
    label: str
    unit: str
    """In ASCII, as `rad s^2`."""
    measure: Callable[[], Measure]
    """Makes what computes it, anew for each flight."""
    digits: int = 4
    """Decimals shown."""
    at_end: bool = False
    """Whether it describes the end of the flight, so that a lost flight has none."""
    missing: str = "-"
    """Shown where a flight that was not lost has no value."""
    good: float | None = None
    """Values up to it are shown in green, above it in yellow or red; None: without colour."""
    poor: float = math.inf
    """Values above it are shown in red."""

    @property
    def title(self) -> str:
        """Label and unit."""
        return f"{self.label} [{self.unit}]"


METRICS: tuple[Metric, ...] = (
    Metric(
        "steady_state_error_deg",
        "steady-state error",
        "deg",
        LastError,
        at_end=True,
        good=CONVERGENCE_BAND_DEG,
        poor=10.0 * CONVERGENCE_BAND_DEG,
    ),
    Metric(
        "convergence_time_s",
        "convergence time",
        "s",
        ConvergenceTime,
        digits=2,
        at_end=True,
        missing="not within\nthe flight",
        good=math.inf,
    ),
    Metric("iae", "IAE", "rad s", partial(Integral, lambda t, e: e)),
    Metric("ise", "ISE", "rad^2 s", partial(Integral, lambda t, e: e * e)),
    Metric("itae", "ITAE", "rad s^2", partial(Integral, lambda t, e: t * e)),
    Metric("itse", "ITSE", "rad^2 s^2", partial(Integral, lambda t, e: t * e * e)),
    Metric("control_activity_rad", "control activity", "rad", TotalVariation),
)
"""Every metric, in the order in which they are written and shown."""


class Metrics:
    """Every metric of a flight, from chunks of its rows in order; memory does not grow with the flight.

    Parameters
    ----------
    controlled
        Whether roll, pitch and yaw are controlled; another axis has no metric.
    """

    def __init__(self, controlled: Controlled = ALL) -> None:
        self._rows = 0
        self._controlled = controlled
        self._last: np.ndarray | None = None
        self._measures = [(metric, metric.measure()) for metric in METRICS]

    def take(self, records: np.ndarray) -> None:
        """Add the next rows: structured array of dtype `signals.ROW`, shape (n,)."""
        if not len(records):
            return
        self._rows += len(records)
        if self._last is not None:
            records = np.concatenate([self._last, records])
        piece = Piece(records["t"], np.abs(attitude_error(records)), records["v2"])
        for _, measure in self._measures:
            measure.take(piece)
        self._last = records[-1:].copy()

    def axes(self, *, completed: bool = True) -> dict[str, dict[str, float | None]]:
        """Return the metrics of each axis, keyed as in `summary.json`.

        Of a flight that was lost (`completed` false), what describes the end (steady-state error, convergence time) is
        None. What has no finite value is None.
        """
        flown = completed or self._rows > 1  # of a flight lost where it began there is nothing to measure
        result: dict[str, dict[str, float | None]] = {axis: {} for axis in AXES}
        for metric, measure in self._measures:
            applies = completed if metric.at_end else flown
            for axis, value, own in zip(AXES, measure.values(), self._controlled, strict=True):
                known = applies and own and value is not None and math.isfinite(value)
                result[axis][metric.name] = value if known else None
        return result


def metrics_of(
    records: np.ndarray, *, completed: bool = True, controlled: Controlled = ALL
) -> dict[str, dict[str, float | None]]:
    """Return the metrics of a whole flight held in memory, shape (n,), dtype `signals.ROW`; see `Metrics`."""
    metrics = Metrics(controlled)
    metrics.take(records)
    return metrics.axes(completed=completed)


def controlled_of(axes: Mapping[str, Mapping[str, float | None]]) -> Controlled:
    """Return which axes were controlled in a flight, from its metrics as in `summary.json`.

    An axis that has none, while another has, was not. Where no axis has any, nothing was flown and all count.
    """
    roll, pitch, yaw = (any(value is not None for value in axes[axis].values()) for axis in AXES)
    return (roll, pitch, yaw) if roll or pitch or yaw else ALL
