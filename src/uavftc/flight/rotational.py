"""The rotational model of an aircraft: what the analytic plant flies, and what control moments are counted by."""

from __future__ import annotations

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.scenario.schema import Scenario


def rotational_model(aircraft: Aircraft, model: TrimmedModel | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return J, kg m^2, A_l, 1/s, and B_m, 1/s^2, of the analytic plant, shape (3, 3) each."""
    if model is None:
        assert aircraft.analytic is not None  # or there would be a trimmed model
        assert aircraft.mass_properties is not None
        inertia = np.array(aircraft.mass_properties.inertia_kgm2)
        return inertia, np.array(aircraft.analytic.A_l), np.array(aircraft.analytic.B_m)
    inertia = np.array(model.inertia_kgm2)
    inertia[[0, 1, 1, 2], [1, 0, 2, 1]] = 0.0  # eq. (2) has no product of inertia other than J_xz
    return inertia, np.array(model.A_at_once), model.B_rates


def moments_per_rad(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None) -> np.ndarray:
    """Return J B_m: moment about body x, y, z, N m, per rad of aileron, elevator and rudder, shape (3, 3).

    J is that of the plant: on JSBSim with all its products of inertia.
    """
    inertia, _, B_m = rotational_model(aircraft, model)
    if model is not None and scenario.plant == "jsbsim":
        inertia = np.array(model.inertia_kgm2)
    return inertia @ B_m
