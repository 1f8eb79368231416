"""Engines that run: started, and checked by their thrust; and frames fine enough for their propellers.

`propulsion/set-running` = -1 is enough for most. Where an engine then gives no thrust, the next way is tried: fuel
that flows with full mixture and pitch (a tank may be frozen empty-handed), then magnetos and starter as a pilot would.
"""

from __future__ import annotations

import math

import jsbsim
import numpy as np

from uavftc.plants.jsbsim.units import LBF_N, SLUG_KG

FRAMES_S = (5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5)
WAYS = ("running", "fuel", "starter")
OPEN = 0.7  # throttle at which an engine is checked
LIVE = 2e-3  # thrust over weight, of all engines: below this none runs
ALIKE = 0.01  # relative difference of thrust between one frame time and the next finer
SPIN_S = 3.0
STARTER_S = 8.0


def has(fdm: jsbsim.FGFDMExec, name: str) -> bool:
    """Whether the loaded aircraft has a property."""
    return fdm.get_property_manager().get_node(name) is not None


def count(fdm: jsbsim.FGFDMExec) -> int:
    """Return the number of engines."""
    return int(fdm.get_propulsion().get_num_engines())


def throttle_position(engine: int) -> str:
    """Return the property of the throttle position that JSBSim gives to an engine, from 0."""
    return f"fcs/throttle-pos-norm[{engine}]"


def start(fdm: jsbsim.FGFDMExec, way: str = "running") -> None:
    """Start the engines, fuel frozen (assumption 1 of the paper: constant mass) where they run on frozen fuel."""
    n = count(fdm)
    if n:
        fdm["propulsion/set-running"] = -1
    fdm["propulsion/fuel_freeze"] = 1 if way == "running" else 0
    if way == "running" or not n:
        return
    for i in range(n):
        for name in (f"fcs/mixture-cmd-norm[{i}]", f"fcs/mixture-pos-norm[{i}]",
                     f"fcs/advance-cmd-norm[{i}]", f"fcs/advance-pos-norm[{i}]"):  # fmt: skip
            if has(fdm, name):
                fdm[name] = 1.0
    fdm["propulsion/set-running"] = -1
    if way == "starter":
        for name, value in (("propulsion/magneto_cmd", 3), ("propulsion/starter_cmd", 1), ("propulsion/cutoff_cmd", 0)):
            fdm[name] = value


def thrust(fdm: jsbsim.FGFDMExec) -> np.ndarray:
    """Return the thrust of each engine, N; nan where one reports none."""
    names = ("propulsion/engine/thrust-lbs", *(f"propulsion/engine[{i}]/thrust-lbs" for i in range(1, count(fdm))))
    return np.array([fdm[name] * LBF_N if has(fdm, name) else math.nan for name in names[: count(fdm)]])


def weight(fdm: jsbsim.FGFDMExec) -> float:
    """Return the weight, N."""
    return float(fdm["inertia/mass-slugs"] * SLUG_KG * 9.80665)


def pull(fdm: jsbsim.FGFDMExec) -> float:
    """Return the force of all engines along body x, N."""
    return float(fdm["forces/fbx-prop-lbs"] * LBF_N)
