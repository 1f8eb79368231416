"""hale in plain JSBSim: no code of the package flies it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import jsbsim
import numpy as np

from uavftc.config.shipped import aircraft_dir

HALE = aircraft_dir() / "hale"
RATES = {"rate/rotational": 4, "rate/translational": 3, "position/rotational": 5, "position/translational": 4}
INPUTS = {
    "left_aileron_rad": "fcs/left-aileron-cmd-norm", "right_aileron_rad": "fcs/right-aileron-cmd-norm",
    "elevator_position_rad": "fcs/elevator-cmd-norm", "rudder_position_rad": "fcs/rudder-cmd-norm",
}  # fmt: skip
STATE = [f"attitude/{x}-rad" for x in ("phi", "theta", "psi")] + [f"velocities/{x}-rad_sec" for x in "pqr"]


def plain() -> jsbsim.FGFDMExec:
    """Load hale in plain JSBSim, on its planet."""
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.set_aircraft_path(str(HALE.parent))
    fdm.set_engine_path(str(HALE / "engine"))
    fdm.set_systems_path(str(HALE / "systems"))
    fdm.set_dt(0.005)
    assert fdm.load_model("hale")
    fdm.load_planet(str(HALE / "flat_planet.xml"), False)
    return fdm


def at_trim(throttle: float, alpha: float, elevator: float) -> jsbsim.FGFDMExec:
    """Return plain JSBSim with hale at 30 m/s and 1000 m, its motion switched off and its engines at speed."""
    fdm = plain()
    for name in RATES:
        fdm[f"simulation/integrator/{name}"] = 0
    start = {"vt-fps": 30 / 0.3048, "h-sl-ft": 1000 / 0.3048, "alpha-rad": alpha, "theta-rad": alpha, "psi-true-rad": 0}
    for name, value in {"lat-geod-deg": 0, "long-gc-deg": 0, "terrain-elevation-ft": 0, **start}.items():
        fdm[f"ic/{name}"] = value
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["fcs/throttle-cmd-norm[0]"] = fdm["fcs/throttle-cmd-norm[1]"] = throttle
    fdm["fcs/elevator-cmd-norm"] = elevator
    fdm["ap/vt-set-fps"] = 30 / 0.3048
    for _ in range(1000):
        fdm.run()
    return fdm


FORCES = ["forces/fbx-total-lbs", "forces/fby-total-lbs", "forces/fbz-total-lbs"]
MOMENTS = ["moments/l-total-lbsft", "moments/m-total-lbsft", "moments/n-total-lbsft"]


def replayed(history: Mapping[str, np.ndarray], trim: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return the states, shape (n, 6), before, and forces and moments, shape (n, 6), after each frame.

    It is driven by the positions of the history alone.
    """
    before, after = reported(history, trim, STATE, (*FORCES, *MOMENTS))
    return before, after


def reported(
    history: Mapping[str, np.ndarray], trim: Mapping[str, Any], before: Sequence[str], after: Sequence[str] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Return what plain JSBSim reports of properties before and after each frame, a row each, driven likewise."""
    fdm = at_trim(trim["throttle"], trim["alpha"], trim["surfaces"][2])
    fdm["ap/at-on"] = 1
    for name, code in RATES.items():
        fdm[f"simulation/integrator/{name}"] = code
    seen = []
    for k in range(len(history["time_s"])):
        first = [fdm[name] for name in before]
        for name, command in INPUTS.items():
            fdm[command] = history[name][k]
        fdm.run()
        seen.append((first, [fdm[name] for name in after]))
    return np.array([first for first, _ in seen]), np.array([last for _, last in seen])
