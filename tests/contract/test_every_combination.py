"""One suite over every plant and every controller: what every flight promises."""

from __future__ import annotations

import numpy as np
import pytest

from flying import flown
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario, scenario_text

PLANTS = ("analytic", "jsbsim")
CONTROLLERS = ("nndondi-l1", "ndi-l1", "nndondi-mrac", "ndi-mrac")

pytestmark = [pytest.mark.parametrize("plant", PLANTS), pytest.mark.parametrize("controller", CONTROLLERS)]


def test_rows_and_times(plant: str, controller: str) -> None:
    flight, records, outcome = flown("scenario3", plant, controller)
    assert outcome.completed
    assert len(records) == flight.steps + 1 == 4001
    np.testing.assert_array_equal(records["t"], np.arange(4001) / 200.0)
    for field in ("x1", "x2", "v1", "v2", "u2", "d1_hat", "f_hat"):
        assert np.all(np.isfinite(records[field])), field


def test_the_first_row_is_the_trim(plant: str, controller: str) -> None:
    _, records, _ = flown("scenario3", plant, controller)
    np.testing.assert_allclose(records["x1"][0], 0.0, atol=1e-9)
    np.testing.assert_allclose(records["x2"][0], 0.0, atol=1e-12)
    np.testing.assert_allclose(records["x1_c"][0], np.radians(5.0), atol=1e-9)


def test_the_step_is_tracked_through_faults(plant: str, controller: str) -> None:
    _, records, _ = flown("scenario3", plant, controller)
    error = np.degrees(np.abs(records["x1_c"] - records["x1"]))
    assert np.max(error[-1]) < 0.05


def test_the_surface_is_the_fault_of_the_limited_command(plant: str, controller: str) -> None:
    # eq. (6) over eq. (20), recomputed from the published columns alone
    _, records, _ = flown("scenario3", plant, controller)
    expected = records["effectiveness"] * np.clip(records["v2"], -0.05, 0.1) + records["bias"]
    np.testing.assert_allclose(records["u2"], expected, rtol=1e-14, atol=1e-17)


def test_a_second_flight_is_identical_to_the_bit(plant: str, controller: str) -> None:
    _, records, _ = flown("scenario3", plant, controller)
    again, _ = fly_to_memory(build_flight(load_scenario("scenario3", plant=plant, controller=controller)))
    assert records.tobytes() == again.tobytes()


def test_the_scenario_as_flown_flies_the_same(
    plant: str, controller: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    flight, records, _ = flown("scenario3", plant, controller)
    file = tmp_path_factory.mktemp("as-flown") / "scenario.yaml"
    file.write_text(scenario_text(flight.scenario), encoding="utf-8")
    again, _ = fly_to_memory(build_flight(load_scenario(file)))
    assert records.tobytes() == again.tobytes()


@pytest.mark.parametrize("delay_s", [0.005, 0.0075, 0.0025])
def test_a_delay_shifts_the_surface(plant: str, controller: str, delay_s: float) -> None:
    overrides = (f"controller.delay_s={delay_s}", "duration_s=2")
    _, records, outcome = flown("scenario1", plant, controller, overrides)
    assert outcome.completed
    whole = int(np.ceil(delay_s * 200.0))  # at t_k itself the command of the last whole sample before still holds
    limited = np.clip(records["v2"], -0.05, 0.1)
    np.testing.assert_array_equal(records["u2"][whole:], limited[:-whole])
    assert np.all(records["u2"][:whole] == 0.0)
