"""Everything a scenario prescribes as a function of time, sampled before it is flown.

Reference, faults, disturbances and air are signals of t alone; a chunk of rows gets them in one vectorised pass. Each
acts on its window [start_s, end_s) and is evaluated at the samples inside it only. Overlapping disturbances add up.
"""

from __future__ import annotations

import numpy as np

from uavftc.core.signals import ROW, SURFACES
from uavftc.environment.gust import one_minus_cosine
from uavftc.scenario.disturbances import AngularAcceleration, AttitudeRate, Gust, Wind
from uavftc.scenario.schema import Scenario


class Inputs:
    """The prescribed fields of the signal row.

    Parameters
    ----------
    scenario
        The flight.
    x1_trim
        Attitude that references count from, shape (3,), rad.
    """

    def __init__(self, scenario: Scenario, x1_trim: np.ndarray) -> None:
        self._scenario = scenario
        self._x1_trim = x1_trim

    def fill(self, records: np.ndarray, first: int) -> None:
        """Write time, reference, faults and disturbances of samples `first` ... into records, dtype `signals.ROW`."""
        s = self._scenario
        t = np.arange(first, first + len(records)) / s.controller.rate_hz
        records["t"] = t
        reference = (s.reference.phi_deg, s.reference.theta_deg, s.reference.psi_deg)
        for i, signal in enumerate(reference):
            records["x1_c"][:, i] = self._x1_trim[i] + np.radians(signal.sample(t))
        records["effectiveness"] = 1.0
        for fault in s.faults:
            i, on = SURFACES.index(fault.surface), fault.active(t)
            records["effectiveness"][on, i] = fault.effectiveness.sample(t[on])
            records["bias"][on, i] = np.radians(fault.bias_deg.sample(t[on]))
        for item in s.disturbances:
            if isinstance(item, Gust):
                profile = one_minus_cosine(t, start=item.start_s, ramp=item.ramp_s, hold=item.hold_s)
                records["wind_n"] += profile[:, None] * (item.north_mps, item.east_mps, item.down_mps)
                continue
            if isinstance(item, AngularAcceleration):
                field, scale, parts = "d2", np.pi / 180.0, (item.p_degps2, item.q_degps2, item.r_degps2)
            elif isinstance(item, AttitudeRate):
                field, scale, parts = "d1", np.pi / 180.0, (item.phi_degps, item.theta_degps, item.psi_degps)
            elif isinstance(item, Wind):
                field, scale, parts = "wind_n", 1.0, (item.north_mps, item.east_mps, item.down_mps)
            else:
                raise TypeError(f"a disturbance of type {type(item).__name__} has no signal")
            on = item.active(t)
            for i, signal in enumerate(parts):
                records[field][on, i] += scale * signal.sample(t[on])

    @property
    def has_wind(self) -> bool:
        """Whether the air moves at any time."""
        return any(isinstance(item, Wind | Gust) for item in self._scenario.disturbances)

    @property
    def has_moment(self) -> bool:
        """Whether d2 acts at any time."""
        return any(isinstance(item, AngularAcceleration) for item in self._scenario.disturbances)

    def wind_at_start(self) -> np.ndarray:
        """Return the velocity of the air at t = 0, north-east-down, shape (3,), m/s."""
        record = np.zeros(1, ROW)
        self.fill(record, 0)
        return record["wind_n"][0].copy()
