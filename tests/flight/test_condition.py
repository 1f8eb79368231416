"""At which condition a flight begins: given, the aircraft's, or the lowest airspeed with ample authority."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.aircraft.definition import load_aircraft
from uavftc.errors import InputError
from uavftc.flight import condition
from uavftc.flight.condition import (
    AMPLE,
    authority_of,
    best_model,
    check_start,
    choose_airspeed,
    condition_of,
    largest_step,
    model_of,
    reasons_against,
)
from uavftc.flight.defaults import resolved
from uavftc.plants.jsbsim.model import ALTITUDE_M, TrimmedModel
from uavftc.scenario.schema import Scenario


def scenario(**sections):
    return Scenario.model_validate({"name": "c", "duration_s": 20, "reference": {"phi_deg": 5}, **sections})


def model(airspeed=50.0, reach=1.0, nonlinearity=0.0):
    """A trimmed model with a surface an axis, 10 rad/s^2 per rad each, and so much reach, rad."""
    B = np.vstack([np.zeros((3, 3)), 10.0 * np.eye(3)])
    return TrimmedModel(
        trim={"airspeed": airspeed, "altitude": 1500.0},
        mass_kg=1.0, inertia_kgm2=np.eye(3).tolist(), engines=1, rad_per_command=[1.0] * 3, measured_rad=[True] * 3,
        limits_rad=[[-reach, reach]] * 3, A=np.zeros((8, 8)).tolist(), A_at_once=np.zeros((3, 3)).tolist(),
        B=B.tolist(), throttle_mps2=1.0, nonlinearity=[nonlinearity] * 3,
    )  # fmt: skip


@pytest.fixture(scope="module")
def hale():
    return load_aircraft("hale")


@pytest.fixture(scope="module")
def stock():
    """An aircraft that says nothing about itself."""
    return load_aircraft("jsbsim:c172p")


def test_the_scenario_goes_before_the_aircraft_and_the_aircraft_before_a_choice(hale, stock):
    # Each value alone: giving only an altitude does not choose an airspeed.
    own = hale.initial
    assert own is not None
    assert condition_of(scenario(), hale) == (own.airspeed_mps, own.altitude_m)
    assert condition_of(scenario(initial={"airspeed_mps": 25}), hale) == (25.0, own.altitude_m)
    assert condition_of(scenario(initial={"altitude_m": 400}), hale) == (own.airspeed_mps, 400.0)
    assert condition_of(scenario(), stock) == (None, ALTITUDE_M)
    assert condition_of(scenario(initial={"airspeed_mps": 60, "altitude_m": 9}), stock) == (60.0, 9.0)


def test_the_companion_files_rotational_model_needs_no_trim(hale):
    # The paper's model is given, not measured: the analytic plant of hale never starts JSBSim.
    assert model_of(scenario(plant="analytic"), hale) is None


def test_the_lowest_airspeed_with_ample_authority_is_chosen():
    # Not the one with the most: an aircraft is flown as slowly as it can be controlled well.
    needed = 1.0 / float(np.min(authority_of(scenario(), model(reach=1.0)).ratio))  # reach of ratio 1
    models = [model(30.0, 2.0 * needed), model(40.0, 1.01 * AMPLE * needed), model(50.0, 9.0 * needed)]
    assert best_model(scenario(), models).trim["airspeed"] == 40.0


def test_where_none_is_ample_the_one_with_the_most_is_taken():
    needed = 1.0 / float(np.min(authority_of(scenario(), model(reach=1.0)).ratio))
    models = [model(30.0, 1.5 * needed), model(40.0, 2.5 * needed), model(50.0, 2.0 * needed)]
    assert best_model(scenario(), models).trim["airspeed"] == 40.0


def test_an_airspeed_at_which_a_surface_is_not_linear_counts_as_none():
    needed = 1.0 / float(np.min(authority_of(scenario(), model(reach=1.0)).ratio))
    models = [model(30.0, 9.0 * needed, nonlinearity=0.9), model(40.0, 1.5 * needed)]
    assert best_model(scenario(), models).trim["airspeed"] == 40.0


def test_an_aircraft_that_no_airspeed_gives_authority_is_refused_with_the_numbers(stock):
    needed = 1.0 / float(np.min(authority_of(scenario(), model(reach=1.0)).ratio))
    models = [model(30.0, 0.3 * needed), model(40.0, 0.5 * needed)]
    with pytest.raises(InputError) as error:
        choose_airspeed(scenario(), stock, models)
    assert error.value.where == "aircraft c172p, at 40 m/s and 1500 m"
    assert "roll has 0.50 times the deflection it needs" in error.value.found
    assert "initial.airspeed_mps" in error.value.remedy
    assert reasons_against(scenario(reference={"phi_deg": 0.5}), models[1]) == []


def test_the_demand_is_the_largest_step_of_each_axis_in_the_whole_flight():
    # An expression is judged at all samples, a number at one; each counts by its size.
    reference = {"phi_deg": "8*sin(t)", "theta_deg": -3, "psi_deg": "t"}
    found = np.degrees(largest_step(scenario(reference=reference)))
    np.testing.assert_allclose(found, [8.0, 3.0, 20.0], rtol=1e-4)


def test_a_slower_controller_asks_for_less():
    # Authority is over what the controller demands; a custom one counts with the paper's ordinary haste.
    slow, fast = (scenario(controller={"outer": {"bandwidth": b}}) for b in (0.5, 2.0))
    custom = scenario(controller={"kind": "pid"})
    ratios = [authority_of(s, model()).ratio[0] for s in (slow, fast, custom)]
    assert ratios[0] > ratios[1]
    assert ratios[2] == ratios[0]


@pytest.mark.parametrize(
    ("envelope", "inside"),
    [
        ({}, True),
        ({"min_airspeed_mps": 29, "max_airspeed_mps": 31}, True),
        ({"min_airspeed_mps": 30}, False),
        ({"min_airspeed_mps": 31}, False),
        ({"max_airspeed_mps": 30}, False),
    ],
)
def test_a_flight_starts_inside_its_envelope(hale, envelope, inside):
    # Outside it would be lost at t = 0, with a result that says nothing.
    flown = resolved(scenario(envelope=envelope), hale, None)
    if inside:
        check_start(flown)
        return
    with pytest.raises(InputError, match=r"an airspeed at the start of 30 m/s, outside") as error:
        check_start(flown)
    assert "initial.airspeed_mps" in error.value.remedy
    check_start(resolved(scenario(plant="analytic", envelope=envelope), hale, None))  # it has no airspeed to lose


def test_a_given_airspeed_is_the_only_one_that_is_measured(stock, monkeypatch):
    # Trimming at each airspeed takes seconds: only who leaves it open pays for them.
    asked = []

    def one(aircraft, airspeed, altitude):
        asked.append((airspeed, altitude))
        return model(airspeed)

    def every(aircraft, altitude):
        asked.append(("all", altitude))
        return (model(40.0), model(50.0))

    monkeypatch.setattr(condition, "trimmed_model", one)
    monkeypatch.setattr(condition, "trimmed_models", every)
    monkeypatch.setattr(condition, "stepped", lambda _aircraft, found: found)
    found = model_of(scenario(initial={"airspeed_mps": 61}), stock)
    assert found is not None
    assert found.trim["airspeed"] == 61.0
    assert model_of(scenario(initial={"altitude_m": 700}), stock) is not None
    assert asked == [(61.0, 1500.0), ("all", 700.0)]
