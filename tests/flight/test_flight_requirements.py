"""Requirements of a flight: the default set of an aircraft, names that do not exist, and what a plant does not know."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import numpy as np
import pytest

from uavftc.core.signals import attitude_error
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.campaign.pool import fly_one
from uavftc.scenario.load import load_scenario, scenario_text


@functools.cache
def verdict(scenario, *overrides, **options):
    return fly_one(load_scenario(scenario, overrides=overrides, **options), keep_history=False).verdict


@pytest.mark.parametrize("scenario", ["scenario1", "scenario2", "scenario3"])
@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_the_papers_controller_survives_the_papers_scenarios(scenario, plant):
    found = verdict(scenario, plant=plant)
    assert found.outcome == "survived"
    assert found.margin > 0.9


def test_the_default_set_is_in_the_scenario_as_flown_and_judges_the_same_again(tmp_path):
    flight = build_flight(load_scenario("scenario3"))
    names = [one.name for one in flight.scenario.requirements]
    assert names[:5] == ["tracking", "excursion", "calm", "bank", "alpha"]
    file = tmp_path / "as-flown.yaml"
    file.write_text(scenario_text(flight.scenario), encoding="utf-8")
    assert load_scenario(file).requirements == flight.scenario.requirements
    assert verdict(str(file)) == verdict("scenario3")


def test_the_margins_of_the_default_set_are_those_computed_by_hand():
    flight = build_flight(load_scenario("scenario3"))
    records, _ = fly_to_memory(flight)
    found = {one.name: one.margin for one in verdict("scenario3").requirements}
    error = np.degrees(np.abs(attitude_error(records)))
    assert found["tracking"] == pytest.approx(1.0 - error[3000:].max(), abs=1e-12)
    assert found["excursion"] == pytest.approx(1.0 - error[1000:].max() / 5.0, abs=1e-12)
    steps = np.abs(np.diff(records["u2"], axis=0, prepend=records["u2"][:1]))
    travel = max(steps[max(0, k - 399) : k + 1, axis].sum() / 2.0 for axis in range(3) for k in range(len(steps)))
    assert found["calm"] == pytest.approx(1.0 - travel, abs=1e-12)
    assert found["bank"] == pytest.approx(1.0 - np.degrees(np.abs(records["x1"][:, 0])).max() / 60.0, abs=1e-12)
    alpha = np.degrees(records["alpha"])  # hale trusts -10 to 10 deg
    assert found["alpha"] == pytest.approx(1.0 - np.abs(alpha).max() / 10.0, abs=1e-9)


def test_a_flight_of_less_than_five_seconds_is_asked_no_excursion():
    flight = build_flight(load_scenario("scenario1", overrides=["duration_s=4"]))
    assert "excursion" not in [one.name for one in flight.scenario.requirements]


def test_a_flight_that_shakes_its_surfaces_to_its_end_is_degraded_by_calm():
    found = verdict("scenario2", "controller.delay_s=0.02", plant="analytic", controller="ndi-mrac")
    assert (found.outcome, found.limiting) == ("degraded", "calm")


def test_a_lost_vehicle_has_at_most_minus_one_and_the_time_of_the_loss():
    scenario = load_scenario("beyond/fault-hardover-stop")
    found = fly_one(scenario, keep_history=False)
    ended = found.outcome.ended_at_s
    assert found.verdict.outcome == "lost"
    assert found.verdict.margin == -1.0 - (scenario.duration_s - ended) / scenario.duration_s
    assert found.verdict.limiting == "flown"


def test_no_requirements_is_none():
    found = verdict("scenario1", "requirements=[]")
    assert (found.outcome, found.margin, found.requirements) == ("survived", 1.0, ())


def test_what_the_plant_does_not_know_is_not_judged_and_says_so():
    override = "requirements=[{name: a, always: 'alpha_deg <= 90'}, {name: b, always: 'p_degps <= 90'}]"
    result = fly_one(load_scenario("scenario1", plant="analytic", overrides=[override]), keep_history=False)
    assert [one.name for one in result.verdict.requirements] == ["flown", "b"]
    said = "requirements[0]: a is not judged, as plant: analytic does not know alpha_deg"
    assert said in result.summary()["warnings"]


def test_effectors_of_the_aircraft_are_signals_too():
    found = verdict("scenario1", "requirements=[{name: a, always: 'left_aileron_travel_radps <= 1'}]")
    assert 0.0 < found.margin < 1.0


def test_a_requirement_may_count_from_a_fault():
    def at(after):
        one = f"requirements=[{{name: r, always: 'abs(phi_error_deg) <= 1', after: '{after}', from_s: 1, to_s: 2}}]"
        return build_flight(load_scenario("scenario3", overrides=[one])).requirements[0]

    assert at("faults[2].start")[2:4] == (1800, 2000)  # 8 s + 1 s, 8 s + 2 s
    assert at("faults[2].end")[2:4] == (2600, 2800)


@pytest.mark.parametrize(
    ("requirements", "where", "words"),
    [
        ("[{name: r, always: 'phi_eror_deg <= 1'}]", "requirements[0].always", "did you mean phi_error_deg?"),
        ("[{name: r, eventually: 'rudder_rda <= 1'}]", "requirements[0].eventually", "did you mean rudder_rad?"),
        ("[{name: r, always: 'phi_deg <= 1', window_s: 1}]", "requirements[0].window_s", "remove window_s"),
    ],
)
def test_what_the_flight_does_not_have_is_refused_before_it(requirements, where, words):
    with pytest.raises(InputError) as error:
        build_flight(load_scenario("scenario1", overrides=[f"requirements={requirements}"]))
    assert where in str(error.value)
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("requirements", "where", "words"),
    [
        ("[{name: r}]", "requirements[0]", "neither always nor eventually"),
        ("[{name: r, always: 'p_degps <= 1', eventually: 'p_degps <= 1'}]", "requirements[0]", "one formula"),
        ("[{name: r, always: 'p_degps <= 0'}]", "requirements[0].always", "add scale:"),
        ("[{name: r, always: 'p_degps <= q_degps'}]", "requirements[0].always", "add scale:"),
        ("[{name: r, always: 'p_degps'}]", "requirements[0].always", "no <= or >="),
        ("[{name: r, always: 5}]", "requirements[0].always", "a formula such as"),
        ("[{name: r, always: 'p_degps <= 1', hold_s: 1}]", "requirements[0].hold_s", "remove it"),
        ("[{name: r, always: 'p_degps <= 1', from_s: 5, to_s: 4}]", "requirements[0].to_s", "at least from_s"),
        ("[{name: r, always: 'p_degps <= 1', from_s: 1.001, to_s: 1.002}]", "requirements[0].to_s", "no sample"),
        ("[{name: r, always: 'p_degps <= 1', after: 'faults[0].end'}]", "requirements[0].after", "an entry of faults"),
        ("[{name: r, always: 'p_degps <= 1', after: faults}]", "requirements[0].after", "faults[0].start"),
        ("[{name: flown, always: 'p_degps <= 1'}]", "requirements[0].name", "another name"),
        ("[{name: r, always: 'p_degps<=1'}, {name: r, always: 'p_degps<=1'}]", "requirements[1].name", "rename"),
        ("{name: r}", "requirements", "a list"),
    ],
)
def test_what_makes_no_sense_is_refused_with_its_place(requirements, where, words):
    with pytest.raises(InputError) as error:
        load_scenario("scenario1", overrides=[f"requirements={requirements}"])
    assert f"key {where}" in str(error.value)
    assert words in str(error.value)


def test_an_aircraft_says_its_own_envelope(tmp_path):
    import shutil

    from uavftc.config.shipped import aircraft_dir

    folder = Path(shutil.copytree(aircraft_dir() / "hale", tmp_path / "hale"))
    with (folder / "uavftc.yaml").open("a", encoding="utf-8") as companion:
        companion.write("limits: {bank_deg: 4, alpha_deg: [-2, 12]}\n")
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder)))
    asked = {one.name: one for one in flight.scenario.requirements}
    assert asked["bank"].formula.text == "abs(phi_deg) <= 4"
    assert asked["alpha"].formula.text == "-2 <= alpha_deg <= 12"
    assert asked["alpha"].scale == 7.0
    found = verdict("scenario1", aircraft=str(folder))
    assert (found.outcome, found.limiting) == ("degraded", "bank")
    assert math.isclose(found.margin, -0.2, abs_tol=0.01)  # banked to 5 deg: rho = -0.25, compressed by 1 + 0.25


@pytest.mark.parametrize("late", ["always: 'p_degps <= 1', from_s: 25", "eventually: 'p_degps <= 1', hold_s: 21"])
def test_what_the_flight_is_too_short_for_is_not_judged_and_says_so(late):
    override = f"requirements=[{{name: a, {late}}}, {{name: b, always: 'p_degps <= 90'}}]"
    result = fly_one(load_scenario("scenario1", plant="analytic", overrides=[override]), keep_history=False)
    assert [one.name for one in result.verdict.requirements] == ["flown", "b"]
    said = "requirements[0]: a is not judged, as the flight ends at 20 s, before it can be"
    assert said in result.summary()["warnings"]
