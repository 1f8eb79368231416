"""The worked example of docs/custom-controller.md flown as a user would: told of no fault, shown the positions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.scenario.load import load_scenario

EXAMPLE = Path(__file__).parents[1] / "examples" / "indi.py"
MEASURED = "u2 = from_positions @ (positions - design.positions_trim_rad)"
FREE = ("saturation={min_rad: -0.2, max_rad: 0.2}", "disturbances=[]", "duration_s=15")
FAULTS = {
    "none": "[]",
    "effectiveness": "[{surface: aileron, start_s: 3, effectiveness: 0.4}, "
    "{surface: elevator, start_s: 5, effectiveness: 0.5, bias_deg: 0.5}]",
    "stuck": "[{kind: stuck, surface: left_aileron, start_s: 1}]",
}


def errors(controller: str, faults: str, *, plant: str = "jsbsim"):
    """Return |x1_c - x1|, deg, shape (N + 1, 3), and the history of scenario 2 without its disturbances."""
    overrides = [*FREE, f"faults={faults}"]
    flight = build_flight(load_scenario("scenario2", plant=plant, controller=controller, overrides=overrides))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    return np.degrees(np.abs(records["x1_c"] - records["x1"])), published(records, flight.columns)


@pytest.mark.parametrize("case", FAULTS)
def test_it_holds_the_attitude_under_a_fault_that_nobody_tells_it_of(case):
    # 5 deg on each axis; after 10 s the paper's loop of 0.5 rad/s has 5 exp(-5) = 0.03 deg left, fault or not
    error, history = errors(str(EXAMPLE), FAULTS[case])
    assert error[2000:].max() < 0.04
    if case != "none":  # and PID, whose gains count on the surfaces, is at least five times further off in roll
        pid, _ = errors("pid", FAULTS[case])
        assert pid[2000:, 0].max() > 5.0 * error[2000:, 0].max()
        left, right = history["left_aileron_rad"], history["right_aileron_rad"]
        if case == "stuck":  # where it was at 1 s, and the other half does the work of both
            assert np.ptp(left[201:]) == 0.0
            assert np.ptp(right[201:]) > 1e-3
    assert {"x2_dot_p_radps2", "lacking_aileron_rad"} <= set(history)
    lacking = np.degrees(np.abs(history["lacking_aileron_rad"][2000:]).max())
    assert lacking < 0.01  # the surface is where it is wanted


def test_on_the_analytic_plant_too():
    error, _ = errors(str(EXAMPLE), FAULTS["effectiveness"], plant="analytic")
    assert error[2000:].max() < 0.04


def test_taking_the_command_for_the_position_costs_what_a_lame_surface_does_not_do(tmp_path):
    # ailerons at 15 %: the law that believes its own command is half as far off again, rms from 4 s on
    source = EXAMPLE.read_text(encoding="utf-8")
    assert MEASURED in source
    (tmp_path / "believing.py").write_text(source.replace(MEASURED, "u2 = v2"), encoding="utf-8")
    lame = "[{surface: aileron, start_s: 3, effectiveness: 0.15}]"
    rms = [
        np.sqrt(np.mean(errors(controller, lame)[0][800:, 0] ** 2))
        for controller in (str(EXAMPLE), str(tmp_path / "believing.py"))
    ]
    assert rms[1] > 1.3 * rms[0]


def test_the_example_is_as_short_as_the_page_says():
    assert len(EXAMPLE.read_text(encoding="utf-8").splitlines()) <= 40
