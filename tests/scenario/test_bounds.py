"""Bounds on what a flight takes: its rate, its plant steps, JSBSim's settling, the memory of a delay."""

from __future__ import annotations

import time

import pytest

from uavftc.flight.timing import timing_of
from uavftc.plants.jsbsim.trim import SETTLE_S
from uavftc.scenario.checks import MAX_DELAY_STEPS, MAX_PLANT_STEPS, MIN_JSBSIM_STEP_S, most_substeps

FAST = "controller: {rate_hz: 10000}\nsimulation: {substeps: 1000}"

WRONG = [
    (
        "duration_s: 1e9\nplant: analytic\ncontroller: {rate_hz: 1e-9}",
        "controller.rate_hz",
        ["1e-09", "at least 1, Hz"],
    ),
    ("duration_s: 1\ncontroller: {rate_hz: 1e-300}", "controller.rate_hz", ["1e-300", "at least 1"]),
    ("duration_s: 1e7\ncontroller: {rate_hz: 1e-7}", "controller.rate_hz", ["1e-07", "at least 1"]),
    (f"duration_s: 1\n{FAST}", "simulation.substeps", ["1e-07 s each", "at least 5e-06 s", "lower it to 20"]),
    (
        "duration_s: 1e7\nplant: analytic\ncontroller: {rate_hz: 1}",
        "simulation.substeps",
        ["200 plant steps in each of 10000000", "2000000000 plant steps", "at most 200000000"],
    ),
    (f"duration_s: 21\nplant: analytic\n{FAST}", "simulation.substeps", ["210000000 plant steps"]),
    (
        f"duration_s: 10\nplant: analytic\n{FAST}".replace("00}\n", "00, delay_s: 5}\n"),
        "controller.delay_s",
        ["5 s, 50000000 plant steps", "at most 10000000"],
    ),
]


@pytest.mark.parametrize(("text", "key", "words"), WRONG)
def test_what_cannot_be_flown_in_time_or_memory_is_refused_with_the_count(refused, text, key, words):
    started = time.monotonic()
    message = str(refused(text, head="name: test\n"))
    assert f"key {key}\n" in message
    for word in words:
        assert word in message, message
    assert time.monotonic() - started < 10.0  # before any of it is flown, sampled or settled


def test_what_is_just_within_the_bounds_is_not_refused(load):
    # 200 Hz with the 1000 substeps that are documented, and 1 Hz, which takes 200 of them
    assert load("simulation: {substeps: 1000}").substeps == 1000
    assert load("controller: {rate_hz: 10000}\nsimulation: {substeps: 20}").substeps == 20
    slow = load("controller: {rate_hz: 1}")
    assert slow.substeps == 200
    assert load("controller: {delay_s: 1e9}").controller.delay_s == 1e9  # as good as the flight's length


def test_jsbsim_settles_in_a_million_steps_at_most():
    # some 5 us each: the longest wait before a flight
    assert SETTLE_S / MIN_JSBSIM_STEP_S <= 1.000001e6


@pytest.mark.parametrize("rate_hz", [1.0, 200.0, 1000.0, 10_000.0])
@pytest.mark.parametrize("delay_s", [0.00123457, 1.00012345])
def test_a_delay_makes_the_plants_step_no_finer_than_the_bounds(load, rate_hz, delay_s):
    scenario = load(f"controller: {{rate_hz: {rate_hz}, delay_s: {delay_s}}}")
    substeps = timing_of(scenario).substeps
    assert scenario.substeps <= substeps <= max(scenario.substeps, most_substeps(scenario))
    assert substeps * scenario.steps <= MAX_PLANT_STEPS
    assert 1.0 / (rate_hz * substeps) >= MIN_JSBSIM_STEP_S * (1.0 - 1e-9)
    assert delay_s * rate_hz * substeps <= MAX_DELAY_STEPS
