"""Keys that promise less than their names: the seed."""

from __future__ import annotations

from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario


def test_the_seed_changes_nothing_as_its_description_says():
    flown = [
        fly_to_memory(build_flight(load_scenario("scenario3", overrides=[f"seed={seed}"])))[0] for seed in (0, 12345)
    ]
    assert flown[0].tobytes() == flown[1].tobytes()
