"""The same flight twice is the same flight, to the last bit: every shipped scenario, controller and plant.

pytest -n 0 -m slow -s tests/hostile/test_determinism.py       # prints its count
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from uavftc.config.shipped import scenario_names
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.controllers import CONTROLLERS
from uavftc.scenario.load import load_scenario, scenario_text
from uavftc.scenario.schema import Scenario

pytestmark = pytest.mark.slow

PLANTS = ("analytic", "jsbsim")


def history(scenario: Scenario) -> np.ndarray:
    """Fly a scenario from its beginning; return the bytes of its rows, shape (rows, bytes of a row)."""
    records, _ = fly_to_memory(build_flight(scenario))
    return np.ascontiguousarray(records).view(np.uint8).reshape(len(records), -1)


def test_a_flight_repeated_and_a_flight_of_its_text_are_the_same_to_the_bit(tmp_path: Path) -> None:
    again = tmp_path / "again.yaml"
    compared, differ = 0, []
    for name in scenario_names():
        for plant in PLANTS:
            for controller in (*CONTROLLERS, "pid", "lqi"):
                try:
                    scenario = load_scenario(name, plant=plant, controller=controller)
                except InputError:  # a gust needs the air of JSBSim
                    assert plant == "analytic"
                    continue
                first = history(scenario)
                again.write_text(scenario_text(scenario), encoding="utf-8")
                for what, other in (("repeated", scenario), ("from its text", load_scenario(again))):
                    compared += 1
                    if not np.array_equal(first, history(other)):
                        differ.append(f"{name}, {plant}, {controller}: {what}")
    print(f"\ndeterminism: {compared} comparisons, {len(differ)} differ")
    assert compared >= 108
    assert not differ, "\n".join(differ)
