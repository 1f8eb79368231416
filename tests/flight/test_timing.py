"""How many plant steps a flight takes a sample, with and without a delay inside it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavftc.flight.build import build_flight
from uavftc.flight.timing import MAX_ALIGNING, timing_of
from uavftc.scenario.schema import MAX_PLANT_STEP_S, Scenario


def scenario(delay_s=0.0, rate_hz=200.0, substeps=None, plant="analytic"):
    return Scenario.model_validate(
        {
            "name": "t",
            "duration_s": round(rate_hz) / rate_hz,
            "plant": plant,
            "controller": {"delay_s": delay_s, "rate_hz": rate_hz},
            "simulation": {"substeps": substeps},
        }
    )


@given(
    samples=st.sampled_from([0.0, 0.25, 0.5, 1.0, 1.2, 2.75, 3.0]),
    rate_hz=st.sampled_from([20.0, 50.0, 100.0, 200.0, 333.0, 1000.0]),
)
def test_a_delay_falls_on_the_plant_steps_and_none_is_longer_than_allowed(samples, rate_hz):
    # Left open, the steps are the fewest that do both: a command then changes between two steps and never within one.
    timing = timing_of(scenario(samples / rate_hz, rate_hz))
    steps = samples * timing.substeps
    assert steps == pytest.approx(round(steps), abs=1e-6)
    assert timing.h == 1.0 / rate_hz
    assert timing.plant_step <= MAX_PLANT_STEP_S * (1.0 + 1e-9)
    fewest = max(1, math.ceil(1.0 / (rate_hz * MAX_PLANT_STEP_S) - 1e-9))
    fewer = [n for n in range(fewest, timing.substeps) if abs(n * samples - round(n * samples)) < 1e-6]
    assert fewer == []


@given(samples=st.floats(0.0, 5.0))
def test_the_steps_become_at_most_so_many_times_finer(samples):
    # No delay, however odd, makes a flight more than eight times as slow.
    assert 1 <= timing_of(scenario(samples / 200.0)).substeps <= MAX_ALIGNING


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_the_plant_that_is_built_steps_as_the_timing_says(plant):
    # A fifth of a sample takes five steps: the plant's own record of its step is what the results publish.
    flight = build_flight(scenario(0.001, plant=plant))
    assert flight.plant.settings["step_s"] == pytest.approx(0.001, rel=1e-12)
    assert flight.given.plant_step == pytest.approx(0.001, rel=1e-12)
    assert flight.given.h == 0.005
