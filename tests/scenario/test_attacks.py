"""What was found by trying odd entries of faults, servos, sensors, damage and air: each refused, or said."""

from __future__ import annotations

import pytest

from uavftc.errors import InputError
from uavftc.scenario.checks import warnings
from uavftc.scenario.load import load_scenario


@pytest.mark.parametrize("flag", ["'yes'", "1", "yes", "null", "'true'"])
@pytest.mark.parametrize(
    ("entry", "key"),
    [
        ("faults=[{{surface: rudder, kind: stuck, known: {}}}]", "faults[0].known"),
        ("disturbances=[{{kind: turbulence, severity: light, rotational: {}}}]", "disturbances[0].rotational"),
    ],
)
def test_only_true_and_false_are_flags(entry, key, flag):
    with pytest.raises(InputError) as told:
        load_scenario("scenario1", overrides=[entry.format(flag)])
    for word in (f"key {key}", "expected: true or false", "remedy:   write true or false, without quotes"):
        assert word in str(told.value)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("known_after_s: 3", "faults[0].known_after_s: without known: true the controller is told nothing"),
        (
            "known: true, known_after_s: 19.5, start_s: 1",
            "faults[0].known_after_s: the flight ends before 20.5 s, so the controller is told nothing",
        ),
        ("known: true, known_after_s: 19", None),
        ("known: true", None),
    ],
)
def test_a_controller_that_is_never_told_is_worth_a_warning(keys, said):
    scenario = load_scenario("scenario1", overrides=[f"faults=[{{surface: rudder, kind: stuck, {keys}}}]"])
    assert warnings(scenario) == ([] if said is None else [said])


@pytest.mark.parametrize(("value", "remedy"), [("3", "put it in quotes"), ("[a, b]", "write one text in its place")])
def test_what_should_be_a_text_says_how_it_becomes_one(value, remedy):
    with pytest.raises(InputError) as told:
        load_scenario("scenario1", overrides=[f"faults=[{{surface: {value}, kind: stuck}}]"])
    assert f"remedy:   {remedy}" in str(told.value)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("controller.delay_s=20", "controller.delay_s: no shorter than the flight, so no command reaches a surface"),
        ("actuators.delay_s=1e9", "actuators.delay_s: no shorter than the flight, so no command reaches its surface"),
        (
            "actuators={rudder: {delay_s: 30}}",
            "actuators.rudder.delay_s: no shorter than the flight, so no command reaches its surface",
        ),
        (
            "faults=[{kind: delay, surface: rudder, delay_s: 1e308, end_s: 3}]",
            "faults[0].delay_s: no shorter than the flight, so no command reaches the surface in its window",
        ),
    ],
)
def test_a_delay_that_no_command_outlasts_is_worth_a_warning(override, said):
    assert warnings(load_scenario("scenario2", overrides=["disturbances=[]", override])) == [said]


def test_a_delay_that_a_named_servo_has_in_common_with_all_is_said_once():
    scenario = load_scenario("scenario2", overrides=["actuators={delay_s: 30, rudder: {backlash_deg: 1}}"])
    assert len(warnings(scenario)) == 1
