"""Keys that promise less than their names: the seed."""

from __future__ import annotations

import numpy as np

from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario


def flown(seed: int, *overrides: str) -> np.ndarray:
    scenario = load_scenario("scenario3", overrides=[f"seed={seed}", "duration_s=5", *overrides])
    return fly_to_memory(build_flight(scenario))[0]


def test_the_seed_changes_nothing_where_nothing_is_random():
    assert flown(0).tobytes() == flown(12345).tobytes()


def test_the_seed_changes_what_is_random_and_gives_the_same_flight_again():
    noisy = "sensors.gyro_noise_density_degps_per_rthz=0.005"
    assert flown(1, noisy).tobytes() == flown(1, noisy).tobytes()
    assert not np.array_equal(flown(1, noisy)["x2_meas"], flown(2, noisy)["x2_meas"])
