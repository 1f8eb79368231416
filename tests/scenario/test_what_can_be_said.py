"""Keys that promise less than their names: the seed, and faults that are written another way."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario

STUCK = "faults=[{kind: stuck, surface: rudder, start_s: 5, at_deg: 2}]"


def test_the_message_on_a_stuck_surface_says_how_to_write_one_and_that_flies_stuck():
    with pytest.raises(InputError) as told:
        load_scenario("scenario1", overrides=[STUCK])
    assert "effectiveness: 0, bias_deg: 2" in str(told.value)
    written = "faults=[{surface: rudder, start_s: 5, effectiveness: 0, bias_deg: 2}]"
    scenario = load_scenario("scenario1", plant="analytic", overrides=[written, "duration_s=6"])
    records, _ = fly_to_memory(build_flight(scenario))
    np.testing.assert_array_equal(records["u2"][records["t"] >= 5.0, 2], np.radians(2.0))


def test_the_seed_changes_nothing_as_its_description_says():
    flown = [
        fly_to_memory(build_flight(load_scenario("scenario3", overrides=[f"seed={seed}"])))[0] for seed in (0, 12345)
    ]
    assert flown[0].tobytes() == flown[1].tobytes()
