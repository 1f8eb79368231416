"""How far the surfaces travel when the rate gyro is noisy: control activity with white noise on the measured rates.

    python tools/noise_activity.py                              # scenario3, 0 and 0.05 deg/s, L1 and MRAC
    python tools/noise_activity.py scenario2 --rms-degps 0 0.01 0.05 0.2 --seeds 5

The noise is `sensors.gyro_noise_density_degps_per_rthz` with the given rms at the samples of the controller: Gaussian,
independent from sample to sample and from axis to axis. Printed for each surface: the mean over the seeds of the sum of
|change| of the command, rad.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from uavftc.analysis.metrics import metrics_of
from uavftc.core.signals import AXES, SURFACES
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario

CONTROLLERS = ("nndondi-l1", "nndondi-mrac")


def activity(scenario: str, controller: str, rms_degps: float, seed: int, plant: str = "jsbsim") -> np.ndarray:
    """Return the control activity of aileron, elevator and rudder, shape (3,), rad; nan where the flight is lost."""
    exact = load_scenario(scenario, plant=plant, controller=controller)
    density = rms_degps / math.sqrt(0.5 * exact.controller.rate_hz)
    noise = (f"seed={seed}", f"sensors.gyro_noise_density_degps_per_rthz={density!r}")
    noisy = load_scenario(scenario, plant=plant, controller=controller, overrides=noise)
    records, outcome = fly_to_memory(build_flight(noisy))
    if not outcome.completed:
        return np.full(3, np.nan)
    axes = metrics_of(records)
    return np.array([axes[axis]["control_activity_rad"] for axis in AXES])


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Control activity with white noise on the rate gyro.")
    parser.add_argument("scenario", nargs="?", default="scenario3")
    parser.add_argument("--plant", default="jsbsim", choices=("jsbsim", "analytic"))
    parser.add_argument("--rms-degps", type=float, nargs="+", default=[0.0, 0.05], help="rms of the noise, deg/s")
    parser.add_argument("--seeds", type=int, default=3, help="realisations of the noise")
    arguments = parser.parse_args()
    print(f"{arguments.scenario} on {arguments.plant}: travel of the commands, rad, mean of {arguments.seeds} seeds")
    print(f"{'controller':<14}{'noise [deg/s]':>14}" + "".join(f"{surface:>10}" for surface in SURFACES))
    for controller in CONTROLLERS:
        for rms in arguments.rms_degps:
            found = [
                activity(arguments.scenario, controller, rms, seed, arguments.plant)
                for seed in range(arguments.seeds if rms else 1)
            ]
            print(f"{controller:<14}{rms:>14g}" + "".join(f"{value:>10.2f}" for value in np.mean(found, axis=0)))


if __name__ == "__main__":
    main()
