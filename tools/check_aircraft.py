"""Check an aircraft folder: strict load, mass properties, level trim, control matrix.

    python tools/check_aircraft.py aircraft/hale

Exit code 0 if every figure is within its tolerance, 1 if one is not, 2 if the aircraft does not load.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np

from uavftc.aircraft.definition import load_aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim.load import initialised, mass_properties
from uavftc.plants.jsbsim.model import FRAME_S, trimmed_model
from uavftc.plants.jsbsim.trim import Trim

MASS_TOLERANCE = 1e-6  # relative
LINEAR_TOLERANCE = 1e-6  # m/s^2
ANGULAR_TOLERANCE = 1e-9  # rad/s^2
B_TOLERANCE = 1e-3  # of the largest element of B_m


def check(folder: str) -> bool:
    """Print the report of one aircraft; return whether everything is within tolerance."""
    aircraft = load_aircraft(folder, "aircraft")
    own, claims = aircraft.initial, aircraft.mass_properties
    if own is None or claims is None or aircraft.analytic is None:
        raise InputError(
            f"aircraft {aircraft.name}",
            found="no claims to check",
            expected="initial, mass_properties and analytic in uavftc.yaml",
            remedy="use uavftc design to see what is measured",
        )
    model = trimmed_model(aircraft, own.airspeed_mps, own.altitude_m)  # in a child process first
    trim = Trim(**model.trim)
    fdm = initialised(aircraft, FRAME_S)
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
    commands = ", ".join(f"{name} {value:.6f}" for name, value in zip(model.names, trim.surfaces, strict=True))
    print(f"       alpha {np.degrees(trim.alpha):.6f} deg, {commands}, throttle {trim.throttle:.6f}")
    for name, value in zip(("u_dot", "v_dot", "w_dot"), trim.residual[:3], strict=True):
        line(name, value, LINEAR_TOLERANCE, "m/s^2")
    for name, value in zip(("p_dot", "q_dot", "r_dot"), trim.residual[3:], strict=True):
        line(name, value, ANGULAR_TOLERANCE, "rad/s^2")
    print("control matrix B at trim, 1/s^2, against B_m of uavftc.yaml")
    B, B_m = model.B_rates, np.array(aircraft.analytic.B_m)
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
