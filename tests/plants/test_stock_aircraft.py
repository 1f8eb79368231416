"""Aircraft that JSBSim ships, flown by name with the paper's controller; and those it cannot fly, refused with why."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

from flying import flown
from uavftc.aircraft.definition import load_aircraft
from uavftc.analysis.metrics import metrics_of
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.results.flight import notes_of
from uavftc.scenario.load import load_scenario, scenario_text

IAE_RAD_S = 0.25  # a step of 5 deg through the outer loop of 0.5 1/s is 0.0873 / 0.5 = 0.175
STEADY_DEG = 0.2


def stock(name, *overrides, plant="jsbsim"):
    """Fly scenario 1 without the saturation that was made for hale."""
    return flown("scenario1", plant, None, (f"aircraft=jsbsim:{name}", "saturation=null", *overrides))


NAMES = pytest.mark.parametrize("name", ["c172p", "737", "J3Cub", "SGS"])


@NAMES
def test_the_step_is_flown(name):
    # No key but the aircraft's name: airspeed, trim, B_m and surface signs are found out, the paper's gains stay.
    flight, records, outcome = stock(name)
    assert outcome.completed, outcome.ended_because
    metrics = metrics_of(records)
    for axis in AXES:
        assert metrics[axis]["iae"] <= IAE_RAD_S, axis
        assert metrics[axis]["steady_state_error_deg"] <= STEADY_DEG, axis
    limits = flight.plant.u_limits
    assert np.all(records["u2"] >= limits[:, 0])
    assert np.all(records["u2"] <= limits[:, 1])


@NAMES
def test_the_airspeed_chosen_is_said(name):
    # The scenario as flown carries it, the flight begins with it, and the envelope counts from it.
    flight, records, _ = stock(name)
    chosen = flight.scenario.initial
    assert load_scenario("scenario1").initial.airspeed_mps is None
    assert chosen.airspeed_mps == flight.plant.settings["trim"]["airspeed_mps"]
    assert chosen.altitude_m == 1500.0
    assert records["airspeed"][0] == pytest.approx(chosen.airspeed_mps, abs=1e-6)
    assert flight.scenario.envelope.min_airspeed_mps == 0.5 * chosen.airspeed_mps
    assert flight.scenario.envelope.max_airspeed_mps == 2.0 * chosen.airspeed_mps


def test_airspeed_is_held_where_the_power_suffices():
    # 20 s with the nose 5 deg higher: the throttle of a 737 makes up for it, to 1 % of the airspeed.
    flight, records, _ = stock("737")
    assert flight.plant.settings["airspeed_hold"] == "bridge"
    airspeed = flight.scenario.initial.airspeed_mps
    assert np.max(np.abs(records["airspeed"] - airspeed)) < 0.01 * airspeed
    assert np.max(records["throttle"]) < 1.0


@pytest.mark.parametrize("name", ["c172p", "J3Cub"])
def test_airspeed_falls_in_a_climb_only_under_full_power(name):
    # A pitch of 5 deg takes more power than these have: the throttle is opened all the way and stays there.
    flight, records, _ = stock(name)
    assert flight.plant.settings["airspeed_hold"] == "bridge"
    assert records["airspeed"][-1] < 0.95 * flight.scenario.initial.airspeed_mps
    np.testing.assert_array_equal(records["throttle"][records["t"] > 8.0], 1.0)


@pytest.mark.parametrize("name", ["c172p", "J3Cub"])
def test_airspeed_is_held_in_level_flight(name):
    # Without the climb the same hold keeps the airspeed to 1 %. For 8 s: with the bank of 5 deg that the scenario holds
    # at a constant heading, the sideslip goes on growing (J3Cub: 12 deg after 20 s), and with it the drag.
    overrides = ("reference.theta_deg=0", f"initial.airspeed_mps={SPEED[name]}", "duration_s=8")
    _, records, outcome = stock(name, *overrides)
    assert outcome.completed
    assert np.max(np.abs(records["airspeed"] - SPEED[name])) < 0.01 * SPEED[name]


SPEED = {"c172p": 55.0, "J3Cub": 35.0}


def test_a_glider_has_no_airspeed_to_hold():
    flight, records, _ = stock("SGS")
    assert flight.plant.settings["airspeed_hold"] == "none"
    assert flight.plant.settings["trim"]["method"] == "glide"
    assert np.all(np.isnan(records["throttle"]))
    assert records["altitude"][200] < records["altitude"][0]  # it begins in a glide


@pytest.mark.parametrize("name", ["737", "SGS"])
def test_flown_twice_and_as_flown_are_the_same_to_the_bit(name, tmp_path):
    # The scenario as flown has the airspeed that was chosen: it is measured alone there, in another process.
    flight, records, _ = stock(name)
    overrides = (f"aircraft=jsbsim:{name}", "saturation=null")
    again, _ = fly_to_memory(build_flight(load_scenario("scenario1", plant="jsbsim", overrides=overrides)))
    assert again.tobytes() == records.tobytes()
    file = tmp_path / "scenario.yaml"
    file.write_text(scenario_text(flight.scenario), encoding="utf-8")
    as_flown, _ = fly_to_memory(build_flight(load_scenario(file)))
    assert as_flown.tobytes() == records.tobytes()


def test_the_measured_model_flies_as_analytic_plant():
    # Without a companion the rotational model is the one measured: same trim, same B_m, and the same step.
    flight, records, outcome = stock("c172p", "initial.airspeed_mps=62", plant="analytic")
    assert outcome.completed
    found = trimmed_model(load_aircraft("jsbsim:c172p"), 62.0, 1500.0)
    np.testing.assert_array_equal(flight.scenario.controller.inner.B_m, found.B_rates)
    np.testing.assert_allclose(records["x1"][0], [found.trim["phi"], found.trim["theta"], 0.0], atol=1e-15)
    np.testing.assert_array_equal(flight.plant.u_limits, found.limits_rad)
    metrics = metrics_of(records)
    assert max(metrics[axis]["iae"] for axis in AXES) <= IAE_RAD_S
    assert max(metrics[axis]["steady_state_error_deg"] for axis in AXES) <= STEADY_DEG


def refusal(name, *overrides):
    with pytest.raises(InputError) as error:
        stock(name, *overrides)
    assert name in error.value.where
    assert error.value.remedy
    return error.value


def test_backlash_is_taken_up_from_below(tmp_path):
    # c172x: the actuators of elevator and ailerons have a hysteresis wider than any small deflection. The trim is that
    # of the same aircraft without it, and so is the effect of its surfaces.
    found = trimmed_model(load_aircraft("jsbsim:c172x"), 62.0, 1500.0)
    stock_folder = load_aircraft("jsbsim:c172x").folder
    folder = shutil.copytree(stock_folder, tmp_path / "c172x")
    for part in ("engine", "systems"):
        shutil.copytree(stock_folder.parents[1] / part, folder / part, dirs_exist_ok=True)
    text = (folder / "c172x.xml").read_text(encoding="utf-8")
    assert text.count("<hysteresis_width>") >= 2
    (folder / "c172x.xml").write_text(re.sub("<hysteresis_width>.*</hysteresis_width>", "", text), encoding="utf-8")
    bare = trimmed_model(load_aircraft(str(folder)), 62.0, 1500.0)
    assert found.effectors[1].servo["backlash_rad"] > 0.0
    assert "backlash_rad" not in bare.effectors[1].servo
    assert found.trim["alpha"] == pytest.approx(bare.trim["alpha"], abs=1e-4)
    assert found.effectors[1].trim_rad == pytest.approx(bare.effectors[1].trim_rad, abs=1e-4)
    np.testing.assert_allclose(np.diag(found.B_rates), np.diag(bare.B_rates), rtol=0.02)


def test_an_aircraft_without_a_trim_is_refused():
    # B17: the message names the condition, the nearest thing to a flight, and the equation that is left over.
    error = refusal("B17", "initial.airspeed_mps=62")
    assert error.where == "aircraft B17, trim at 62 m/s and 1500 m"
    assert error.found.startswith("no steady flight; the nearest to a steady flight is 62 m/s, alpha 7.")
    assert "u_dot = -0.2 m/s^2 is left" in error.found
    assert "initial.airspeed_mps" in error.remedy


def test_without_an_airspeed_the_refusal_names_the_speeds_tried():
    # The thrust of B17 does not carry it at any of those between its stall and 4.5 times that.
    assert refusal("B17").where == "aircraft B17, trim at 62 to 220 m/s and 1500 m"


def test_an_aircraft_without_surfaces_is_refused_with_what_its_commands_move():
    # mk82 is a bomb.
    found = refusal("mk82").found
    assert found.startswith("no steady flight: nothing that the flight controls read moves it")
    assert "aileron 0 rad/s^2, elevator 0 rad/s^2, rudder 0 rad/s^2" in found


@pytest.mark.parametrize(("name", "lacks"), [("L17", "fcs/flaps-pos-deg"), ("f104", "systems/radar/range")])
def test_a_property_that_only_another_program_defines_is_taken_as_zero(name, lacks):
    # Some of JSBSim's aircraft run under FlightGear only, which would define the property. The flight says so.
    flight, _, outcome = stock(name, "duration_s=1")
    assert outcome.completed
    assert f"{name}.xml reads what nothing defines, taken as 0: {lacks}" in notes_of(flight)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("c172", "jsbsim:c172p, jsbsim:c172r or jsbsim:c172x?"),
        ("C172P", "did you mean jsbsim:c172p"),
        ("boing314", "did you mean jsbsim:Boeing314?"),
    ],
)
def test_names_near_an_unknown_one_are_suggested(name, meant):
    # Those equally near in their order, since some, such as c172x, cannot be flown.
    with pytest.raises(InputError) as error:
        load_aircraft(f"jsbsim:{name}")
    assert meant in error.value.remedy


@pytest.mark.parametrize("name", ["c17p", "c172", "../c172p", ""])
def test_an_unknown_name_is_refused_with_the_names_there_are(name):
    with pytest.raises(InputError, match="which JSBSim does not ship") as error:
        load_aircraft(f"jsbsim:{name}")
    assert "c172p" in error.value.expected


def test_a_reference_too_large_is_refused_with_the_surface():
    # 737 at 155 m/s and a step of 120 deg in heading: the rudder does not reach.
    error = refusal("737", "initial.airspeed_mps=155", "reference.psi_deg=120")
    assert "too little rudder for the reference" in error.found
    assert "a smaller reference" in error.remedy
