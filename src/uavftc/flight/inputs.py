"""Everything a scenario prescribes as a function of time, sampled before it is flown.

Reference, faults, disturbances and air are signals of t alone; a chunk of rows gets them in one vectorised pass. Each
acts on its window [start_s, end_s) and is evaluated at the samples inside it only.
"""

from __future__ import annotations

import numpy as np

from uavftc.actuators import CHAIN
from uavftc.config.effect import config_of
from uavftc.config.values import window_of
from uavftc.core.layout import Layout, shares, targets_of
from uavftc.core.signals import as_records, empty_rows
from uavftc.environment import KINDS
from uavftc.scenario.schema import Scenario


class Inputs:
    """The prescribed fields of the signal row.

    Parameters
    ----------
    scenario
        The flight.
    x1_trim
        Attitude that references count from, shape (3,), rad.
    layout
        The effectors.
    """

    def __init__(self, scenario: Scenario, x1_trim: np.ndarray, layout: Layout | None = None) -> None:
        layout = Layout() if layout is None else layout
        self._rate_hz = scenario.controller.rate_hz
        self._reference = [scenario.reference.phi_deg, scenario.reference.theta_deg, scenario.reference.psi_deg]
        self._x1_trim = x1_trim
        self._n, self._targets = len(layout.names), targets_of(layout.names, layout.gangs)
        self._shares = shares(layout.mixing)
        self._own = self._shares * layout.mixing
        self._disturbances = [(kind, entry) for kind in KINDS for entry in config_of(kind, scenario)]
        self._entries = [
            (effect, effect.drawn(entry, scenario.seed, i) if hasattr(effect, "drawn") else entry)
            for effect in (*CHAIN, *KINDS)
            if hasattr(effect, "prescribe")
            for i, entry in enumerate(config_of(effect, scenario))
        ]
        self._on_effectors = any(effect in CHAIN for effect, _ in self._entries)

    def fill(self, records: np.ndarray, first: int) -> None:
        """Write time, reference, faults and disturbances of samples `first` ... into records of a row."""
        t = np.arange(first, first + len(records)) / self._rate_hz
        records["t"] = t
        for i, signal in enumerate(self._reference):
            records["x1_c"][:, i] = self._x1_trim[i] + np.radians(signal.sample(t))
        records["effectiveness"] = 1.0
        records["effectors"]["effectiveness"] = 1.0
        for effect, entry in self._entries:
            window = window_of(entry, t)
            if window.start < window.stop:
                effect.prescribe(entry, t[window], records[window], self._targets)
        if self._on_effectors:
            self._gather(records)

    def _gather(self, records: np.ndarray) -> None:
        """Write omega and v_2a of each axis, as its effectors make them up."""
        for i in np.flatnonzero(self._own.any(axis=0)):
            records["effectiveness"][:, i] = records["effectors"]["effectiveness"] @ self._own[:, i]
            records["bias"][:, i] = records["effectors"]["bias"] @ self._shares[:, i]

    def acts_on(self, field: str) -> bool:
        """Whether a disturbance adds to a field of the row, such as `wind_n` or `d2`, at any time."""
        return any(field in getattr(kind, "FIELDS", ()) for kind, _ in self._disturbances)

    def wind_at_start(self, height: float = 0.0) -> np.ndarray:
        """Return the velocity of the air at t = 0, north-east-down, shape (3,), m/s, at a height above ground, m."""
        record = as_records(empty_rows(1, self._n))
        self.fill(record, 0)
        wind = record["wind_n"][0].copy()
        for kind, entry in self._disturbances:
            if hasattr(kind, "wind_at_start") and entry.start_s <= 0.0:
                wind += kind.wind_at_start(entry, height)
        return wind
