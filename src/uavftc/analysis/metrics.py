"""The paper's six metrics of section 4, and control activity.

    IAE = int |e| dt    ISE = int e^2 dt    ITAE = int t |e| dt    ITSE = int t e^2 dt        (rad, s)

e is the attitude error x1_c - x1; the integrals are trapezoidal over the rows. The steady-state error is |e| in the
last row; the convergence time is that of the first row after the last one with |e| > 0.02 deg (the paper's band; its
unit is the one in which its own figures fit). Control activity is the total variation of the commanded deflection
v2, before saturation: it separates controllers that track alike but work the surfaces differently.
"""

from __future__ import annotations

import math

import numpy as np

from uavftc.core.signals import AXES, attitude_error

CONVERGENCE_BAND_DEG = 0.02  # section 4: "tracking errors [...] kept within 0.02"
INTEGRALS = ("iae", "ise", "itae", "itse")


class Metrics:
    """Metrics of a flight, from chunks of its rows in order; memory does not grow with the flight."""

    def __init__(self) -> None:
        self._rows = 0
        self._last: np.ndarray | None = None
        self._integrals = np.zeros((4, 3))
        self._activity = np.zeros(3)
        self._converged_at: list[float | None] = [0.0, 0.0, 0.0]

    def take(self, records: np.ndarray) -> None:
        """Add the next rows: structured array of dtype `signals.ROW`, shape (n,)."""
        if not len(records):
            return
        self._rows += len(records)
        self._converge(records)
        if self._last is not None:
            records = np.concatenate([self._last, records])
        t = records["t"][:, None]
        e = np.abs(attitude_error(records))
        dt = np.diff(t, axis=0)
        for i, f in enumerate((e, e * e, t * e, t * e * e)):
            self._integrals[i] += (0.5 * (f[1:] + f[:-1]) * dt).sum(axis=0)
        self._activity += np.abs(np.diff(records["v2"], axis=0)).sum(axis=0)
        self._last = records[-1:].copy()

    def _converge(self, records: np.ndarray) -> None:
        outside = np.degrees(np.abs(attitude_error(records))) > CONVERGENCE_BAND_DEG
        t = records["t"]
        for axis in range(3):
            if self._converged_at[axis] is None and not outside[0, axis]:
                self._converged_at[axis] = float(t[0])
            where = np.flatnonzero(outside[:, axis])
            if len(where):
                after = where[-1] + 1
                self._converged_at[axis] = float(t[after]) if after < len(t) else None

    def axes(self, *, completed: bool = True) -> dict[str, dict[str, float | None]]:
        """Return the metrics of each axis, keyed as in `summary.json`.

        Of a flight that was lost (`completed` false) the steady-state error and the convergence time are None.
        What has no finite value is None.
        """
        last = self._last
        error = np.full(3, math.nan) if last is None else np.degrees(np.abs(attitude_error(last)))[0]
        flown = completed or self._rows > 1  # of a flight lost where it began there is nothing to measure
        result: dict[str, dict[str, float | None]] = {}
        for i, axis in enumerate(AXES):
            values: dict[str, float | None] = {
                "steady_state_error_deg": float(error[i]) if completed else None,
                "convergence_time_s": self._converged_at[i] if completed else None,
            }
            values |= {name: float(self._integrals[k, i]) if flown else None for k, name in enumerate(INTEGRALS)}
            values["control_activity_rad"] = float(self._activity[i]) if flown else None
            result[axis] = {k: v if v is None or math.isfinite(v) else None for k, v in values.items()}
        return result


def metrics_of(records: np.ndarray, *, completed: bool = True) -> dict[str, dict[str, float | None]]:
    """Return the metrics of a whole flight held in memory, shape (n,), dtype `signals.ROW`; see `Metrics.axes`."""
    metrics = Metrics()
    metrics.take(records)
    return metrics.axes(completed=completed)
