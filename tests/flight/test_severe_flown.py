"""Severe faults in flight: on hale as in plain JSBSim with the same positions, and every shipped one."""

from __future__ import annotations

import numpy as np
import pytest

from flying import flown
from plain import FORCES, MOMENTS, replayed
from uavftc.config.effect import tag_of
from uavftc.config.shipped import scenario_names
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import FAULTS

LEFT = "faults=[{{kind: {}, surface: left_aileron, start_s: 0.5, end_s: 3}}]"


@pytest.mark.parametrize("fault", ["hardover, rate_degps: 40, to_deg: 10", "stuck, at_deg: -4", "float, ratio: 0.5"])
def test_a_left_aileron_with_a_fault_flies_as_plain_jsbsim_with_the_same_positions(fault):
    # states before, and forces and moments after, each frame
    overrides = (LEFT.format(fault), "duration_s=4", "saturation=null")
    flight = build_flight(load_scenario("scenario1", overrides=list(overrides)))
    rows = empty_rows(flight.steps + 1, flight.shape)
    records = as_records(rows, flight.shape)
    flight.inputs.fill(records, 0)
    ours = np.empty((len(rows), 6))
    for k in range(len(rows)):
        assert flight.plant.run(flight.program, rows, k, k + 1) == k + 1
        ours[k] = [flight.plant.fdm[name] for name in (*FORCES, *MOMENTS)]
    history = published(records, flight.columns)
    states, forces = replayed(history, flight.model.trim)
    np.testing.assert_allclose(np.unwrap(states[:, :3], axis=0), records["x1"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(states[:, 3:], records["x2"], rtol=0, atol=1e-9)
    scale = np.abs(forces).max(axis=0).reshape(2, 3).max(axis=1).repeat(3)
    np.testing.assert_allclose(ours / scale, forces / scale, rtol=0, atol=1e-9)
    inside = (records["t"] >= 0.5) & (records["t"] < 3.0)
    assert np.ptp(history["left_aileron_rad"] - history["left_aileron_cmd_rad"]) > 1e-3
    np.testing.assert_array_equal(history["left_aileron_rad"][~inside], history["left_aileron_cmd_rad"][~inside])


def test_a_hardover_is_seen_in_the_position_of_the_history():
    # 40 deg/s from where it was to 10 deg, to one plant step
    overrides = (LEFT.format("hardover, rate_degps: 40, to_deg: 10"), "duration_s=4", "saturation=null")
    flight, records, _ = flown("scenario1", "jsbsim", None, overrides)
    position = published(records, flight.columns)["left_aileron_rad"]
    first = int(np.searchsorted(records["t"], 0.5))
    way = np.radians(10.0) - position[first]
    there = np.argmax(position >= np.radians(10.0) - 1e-12) - first
    assert abs(there * 0.005 - way / np.radians(40.0)) <= 0.005
    np.testing.assert_allclose(np.diff(position[first : first + there]), np.radians(40.0) * 0.005, rtol=0, atol=1e-12)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_a_stuck_surface_holds_to_the_last_bit(plant):
    overrides = (LEFT.format("stuck"), "duration_s=4")
    flight, records, _ = flown("scenario1", plant, None, overrides)
    position = published(records, flight.columns)["left_aileron_rad"]
    inside = (records["t"] >= 0.5) & (records["t"] < 3.0)
    assert np.ptp(position[inside]) == 0.0
    assert position[inside][0] == position[np.argmax(inside) - 1]


def test_before_a_fault_begins_the_flight_is_the_one_without_it_bit_for_bit():
    faulty = flown("scenario1", "jsbsim", None, (LEFT.format("hardover"), "duration_s=1"))[1]
    sound = flown("scenario1", "jsbsim", None, ("duration_s=1",))[1]
    before = faulty["t"] < 0.5
    for name in ("x1", "x2", "v2", "u2", "effectors"):
        assert faulty[name][before].tobytes() == sound[name][before].tobytes()
    assert not np.array_equal(faulty["u2"], sound["u2"])


SHIPPED = [name for name in scenario_names("beyond") if name.startswith(("beyond/fault-", "beyond/engine-"))]


def test_there_is_a_scenario_of_each_fault_on_hale_and_on_a_stock_aircraft():
    # an oscillation of each mode; of engines and of surfaces
    def flown_on(aircraft):
        scenarios = [load_scenario(name) for name in SHIPPED]
        return {tag_of(type(f)) + getattr(f, "mode", "") for s in scenarios if s.aircraft == aircraft for f in s.faults}

    every = {tag_of(kind) for kind in FAULTS} - {"oscillatory"} | {"oscillatoryliquid", "oscillatorysolid"}
    assert flown_on("hale") == flown_on("jsbsim:c172p") == every


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_fault_flies(name):
    # to its end, but for the rudder at its stop, which takes the vehicle from any controller
    flight = build_flight(load_scenario(name))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed is (name != "beyond/fault-hardover-stop")
    assert np.isfinite(records["x1"]).all()


def test_a_floating_surface_needs_a_flow():
    from uavftc.errors import InputError

    with pytest.raises(InputError, match="no floating surface"):
        load_scenario("scenario1", plant="analytic", overrides=[LEFT.format("float, ratio: 0.5")])


SERVO = ("kind: deadband, width_deg: 5", "kind: backlash, width_deg: 5", "kind: delay, delay_s: 1",
         "kind: rate-limit, rate_degps: 0.1")  # fmt: skip


@pytest.mark.parametrize("fault", ["kind: stuck", "kind: total-loss", "effectiveness: 0", *SERVO])
def test_a_fault_that_changed_nothing_is_worth_a_warning(tmp_path, fault):
    # a rudder that the controller never moves, and that has no trim
    (tmp_path / "resting.py").write_text(
        "def create(design, h, options):\n    return lambda t, x1_c, x1, x2: [0, 0, 0]\n"
    )
    overrides = ["duration_s=1", f"faults=[{{surface: rudder, start_s: 0.5, {fault}}}]"]
    flight = build_flight(load_scenario("scenario1", controller=str(tmp_path / "resting.py"), overrides=overrides))
    _, outcome = fly_to_memory(flight)
    assert outcome.remarks == ("faults[0]: changed nothing: the rudder did what it would have done without it",)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_a_rate_that_a_servo_never_reaches_is_worth_a_warning_and_one_that_it_does_is_not(plant):
    # the elevator of scenario 1 with a servo of 57 rad/s: its fastest sets the limit
    servo = ("actuators={bandwidth_radps: 57}", "duration_s=4")
    fault = "faults=[{{kind: rate-limit, surface: elevator, rate_degps: {:.17g}}}]"
    free, records, _ = flown("scenario1", plant, None, servo)
    fastest = np.degrees(np.abs(np.diff(published(records, free.columns)["elevator_servo_rad"])).max()) * 200
    _, slow, limited = flown("scenario1", plant, None, (*servo, fault.format(0.5 * fastest)))
    assert limited.remarks == ()
    assert not np.array_equal(slow["x1"], records["x1"])
    _, fast, untouched = flown("scenario1", plant, None, (*servo, fault.format(5.0 * fastest)))
    assert untouched.remarks == ("faults[0]: changed nothing: the elevator did what it would have done without it",)
    np.testing.assert_array_equal(fast["x1"], records["x1"])


@pytest.mark.parametrize(
    "fault", ["backlash, width_deg: 5e-324", "delay, delay_s: 5e-324", "deadband, width_deg: 5e-324"]
)
def test_a_fault_of_a_servo_that_is_too_small_for_a_number_is_worth_a_warning_too(fault):
    overrides = [f"faults=[{{surface: rudder, kind: {fault}}}]", "duration_s=0.1"]
    _, outcome = fly_to_memory(build_flight(load_scenario("scenario1", overrides=overrides)))
    assert outcome.remarks == ("faults[0]: changed nothing: the rudder did what it would have done without it",)


@pytest.mark.parametrize("end", ["1e25", "1.7e308"])
def test_a_window_may_end_long_after_every_flight(end):
    overrides = [f"faults=[{{kind: loss, engine: 1, end_s: {end}}}]", f"damage=[{{mass_kg: -1, end_s: {end}}}]"]
    flight = build_flight(load_scenario("scenario1", overrides=[*overrides, "duration_s=0.1", "controller.rate_hz=70"]))
    assert fly_to_memory(flight)[1].completed


def test_a_fault_that_changed_something_is_not():
    _, _, outcome = flown("scenario1", "jsbsim", None, (LEFT.format("stuck"), "duration_s=4"))
    assert outcome.remarks == ()


def test_a_fault_that_the_flight_did_not_live_to_see_is_worth_a_warning():
    faults = "faults=[{kind: hardover, surface: rudder, start_s: 1}, {kind: stuck, surface: elevator, start_s: 18}]"
    _, _, outcome = flown("scenario1", "jsbsim", None, (faults,))
    assert not outcome.completed
    assert outcome.remarks == (f"faults[1]: never began; the flight ended at {outcome.ended_at_s:g} s",)
