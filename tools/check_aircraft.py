"""Check an aircraft folder: strict load, mass properties, level trim, control matrix.

    python tools/check_aircraft.py aircraft/hale

Exit code 0 if every figure is within its tolerance, 1 if one is not, 2 if the aircraft does not load.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

from uavftc.aircraft import load_aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim.linearise import ACCELERATIONS, control_matrix
from uavftc.plants.jsbsim.load import mass_properties
from uavftc.plants.jsbsim.plant import initialised
from uavftc.plants.jsbsim.probe import ensure_loads
from uavftc.plants.jsbsim.trim import residual, trim_level
from uavftc.plants.jsbsim.units import FT_M

STEP_S = 0.005
MASS_TOLERANCE = 1e-6  # relative
LINEAR_TOLERANCE = 1e-6  # m/s^2
ANGULAR_TOLERANCE = 1e-9  # rad/s^2
B_TOLERANCE = 1e-3  # of the largest element of B_m


def check(folder: str) -> bool:
    """Print the report of one aircraft; return whether everything is within tolerance."""
    aircraft = load_aircraft(folder, "aircraft")
    ensure_loads(aircraft)
    fdm = initialised(aircraft, STEP_S)
    trim = trim_level(fdm, aircraft, aircraft.initial.airspeed_mps, aircraft.initial.altitude_m)
    good = True

    def line(what: str, value: float, tolerance: float, unit: str) -> None:
        nonlocal good
        ok = abs(value) <= tolerance
        good = good and ok
        print(f"  {'ok  ' if ok else 'FAIL'} {what:<34} {value: .2e} {unit:<8} (tolerance {tolerance:g})")

    print(f"{aircraft.name}: {aircraft.description}")
    print("mass properties, JSBSim against uavftc.yaml")
    for what, (found, claimed, _unit) in mass_properties(aircraft, fdm).items():
        difference = np.max(np.abs(np.subtract(found, claimed))) / np.max(np.abs(claimed))
        line(what, float(difference), MASS_TOLERANCE, "relative")
    print(f"level trim at {trim.airspeed:g} m/s, {trim.altitude:g} m")
    print(f"       alpha {np.degrees(trim.alpha):.6f} deg, elevator {np.degrees(trim.elevator):.6f} deg, "
          f"throttle {trim.throttle:.6f}")  # fmt: skip
    u_dot, w_dot, _ = residual(fdm)
    line("u_dot", u_dot, LINEAR_TOLERANCE, "m/s^2")
    line("v_dot", fdm["accelerations/vdot-ft_sec2"] * FT_M, LINEAR_TOLERANCE, "m/s^2")
    line("w_dot", w_dot, LINEAR_TOLERANCE, "m/s^2")
    for name, rate in zip(("p_dot", "q_dot", "r_dot"), ACCELERATIONS, strict=True):
        line(name, fdm[rate], ANGULAR_TOLERANCE, "rad/s^2")
    print("control matrix B at trim, 1/s^2, against B_m of uavftc.yaml")
    B, B_m = control_matrix(fdm, aircraft), np.array(aircraft.analytic.B_m)
    print("       " + np.array2string(B, precision=6, suppress_small=True).replace("\n", "\n       "))
    line("B - B_m, largest over largest", float(np.max(np.abs(B - B_m)) / np.max(np.abs(B_m))), B_TOLERANCE, "relative")
    return good


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Check an aircraft folder: load, mass, trim, control matrix.")
    parser.add_argument("folder", help="name of a shipped aircraft, or a folder")
    try:
        return 0 if check(parser.parse_args().folder) else 1
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
