"""What a noisy gyro does to the surfaces: the figures that stand next to every claim that L1 is calm."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from uavftc.analysis.metrics import metrics_of
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.paper.captions import NOISY
from uavftc.scenario.load import load_scenario

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("noise_activity", ROOT / "tools" / "noise_activity.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_noise_takes_the_calm_from_L1_and_leaves_it_four_to_five_times_calmer_than_MRAC(tool: ModuleType):
    # seeds 0 to 2, as the tool prints them: 22, 28 and 35 rad; 106, 108 and 143 rad
    L1, MRAC = (
        np.mean([tool.activity("scenario3", name, 0.05, seed) for seed in range(3)], axis=0)
        for name in tool.CONTROLLERS
    )
    np.testing.assert_allclose(L1, [21.8, 28.2, 34.7], rtol=0.02)
    np.testing.assert_allclose(MRAC, [106.2, 107.7, 143.2], rtol=0.02)
    assert np.all((MRAC / L1 > 3.8) & (MRAC / L1 < 5.0))


def test_without_noise_the_tool_flies_the_shipped_loop(tool: ModuleType):
    records, _ = fly_to_memory(build_flight(load_scenario("scenario3", controller="nndondi-l1")))
    expected = [axis["control_activity_rad"] for axis in metrics_of(records).values()]
    np.testing.assert_array_equal(tool.activity("scenario3", "nndondi-l1", 0.0, 0), expected)


def test_activity_grows_with_the_airspeed():
    # the sentence of the metrics' docstring: the rudder's 0.14 rad at 30 m/s is 37 rad at 45 m/s
    for airspeed, travel in ((30, 0.144), (45, 37.4)):
        scenario = load_scenario("scenario3", overrides=[f"initial.airspeed_mps={airspeed}"])
        records, outcome = fly_to_memory(build_flight(scenario))
        assert outcome.completed
        assert metrics_of(records)["yaw"]["control_activity_rad"] == pytest.approx(travel, rel=0.01)


def test_it_is_said_wherever_L1_is_called_calm():
    for page in ("README.md", "docs/reproduction.md"):
        calm = [
            line for line in (ROOT / page).read_text(encoding="utf-8").splitlines() if "calm" in line and "L1" in line
        ]
        assert calm
        assert all("tools/noise_activity.py" in line for line in calm)
    assert "tools/noise_activity.py" in NOISY
