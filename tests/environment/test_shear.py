"""Wind shear against its closed form, flown through a climb."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario

POWER = {"kind": "shear", "reference_height_m": 20, "north_mps": -4, "east_mps": 3, "exponent": 0.2}
LINEAR = {
    "kind": "shear", "profile": "linear", "reference_height_m": 900, "north_mps": 2, "north_mps_per_m": 0.05,
    "east_mps_per_m": -0.02,
}  # fmt: skip


def flown(*entries, seconds=10, **more):
    scenario = {"name": "shear", "duration_s": seconds, "reference": {"theta_deg": 5}, "disturbances": [*entries]}
    records, outcome = fly_to_memory(build_flight(Scenario.model_validate(scenario | more)))
    assert outcome.completed
    return records


def power(height):
    return np.outer((height / 20.0) ** 0.2, [-4.0, 3.0, 0.0])


def linear(height):
    return np.outer(height - 900.0, [0.05, -0.02, 0.0]) + np.array([2.0, 0.0, 0.0])


@pytest.mark.parametrize(("entry", "wind"), [(POWER, power), (LINEAR, linear)])
def test_the_wind_is_that_of_the_height(entry, wind):
    # at each sample of a climb, and in addition to what else blows
    records = flown(entry, {"kind": "wind", "east_mps": "0.1*t"})
    assert np.ptp(records["height"]) > 8.0
    other = np.outer(0.1 * records["t"], [0.0, 1.0, 0.0])
    np.testing.assert_allclose(records["wind_n"], wind(records["height"]) + other, rtol=1e-13)


@pytest.mark.parametrize("entry", [POWER, LINEAR])
def test_the_flight_starts_in_the_wind_of_its_height(entry):
    # in trim: no step of airspeed, and level flight stays level; the climb is what shears
    level = flown(entry, seconds=5, reference={})
    assert abs(level["wind_n"][0, 0]) > 4.0
    np.testing.assert_allclose(level["airspeed"], 30.0, atol=1e-3)
    np.testing.assert_allclose(level["height"], 1000.0, atol=1e-2)


def test_climbing_into_a_tail_wind_takes_airspeed():
    # W' = G h': the aircraft loses what the wind gains, less what the throttle makes up by then
    still = flown(seconds=6)
    tail = flown({**LINEAR, "north_mps_per_m": 0.2, "east_mps_per_m": 0}, seconds=6)
    k = 600
    gained = tail["wind_n"][k, 0] - tail["wind_n"][0, 0]
    assert gained > 0.5
    assert -gained < tail["airspeed"][k] - still["airspeed"][k] < -0.2 * gained


def test_it_acts_on_its_window():
    # from the first sample at start_s to the last before end_s
    records = flown({**LINEAR, "start_s": 1, "end_s": 2, "north_mps": 0.1, "north_mps_per_m": 0}, seconds=4)
    inside = (records["t"] >= 1.0) & (records["t"] < 2.0)
    assert inside.sum() == 200
    np.testing.assert_array_equal(records["wind_n"].any(axis=1), inside)


def test_below_ground_counts_as_the_ground():
    # a power of a negative height would not be a number
    from uavftc.environment import shear

    entry = shear.Config(north_mps=5)
    np.testing.assert_array_equal(shear.wind_at_start(entry, -3.0), np.zeros(3))
    np.testing.assert_allclose(shear.wind_at_start(entry, 1280.0), [10.0, 0.0, 0.0])  # 2^7 times 10 m, 1/7
