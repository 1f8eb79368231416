"""Faults of engines in JSBSim: what they do to throttle and thrust, when, and which are refused."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from flying import bare, jsbsim_plant
from uavftc.aircraft.definition import load_aircraft
from uavftc.config.shipped import aircraft_dir
from uavftc.core.signals import empty_rows
from uavftc.errors import InputError
from uavftc.flight.build import build_flight, make_plant
from uavftc.flight.fly import fly_to_memory
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim import engine_faults
from uavftc.plants.jsbsim.engine_faults import tried
from uavftc.plants.jsbsim.load import initialised
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.plants.jsbsim.trim import Trim, freeze, start
from uavftc.scenario.schema import Scenario

LBF_N, FT_M = 4.4482216152605, 0.3048
ARM_M = 5.0  # of hale's motors, hale.xml


def scenario(*faults, duration_s=3, **changes) -> Scenario:
    return Scenario.model_validate({"name": "engines", "duration_s": duration_s, "faults": list(faults), **changes})


def flown(*faults, **changes):
    flight = build_flight(scenario(*faults, **changes))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    return flight, records


def thrust_n(fdm, engine):
    return fdm[f"propulsion/engine[{engine}]/thrust-lbs"] * LBF_N


@pytest.fixture(scope="module")
def quiet():
    return flown()


def test_before_its_window_a_fault_changes_no_bit(quiet):
    # the channel has gain 1 and offset 0 till then
    for kind in ({"kind": "loss"}, {"kind": "stuck"}, {"kind": "reduced", "power": 0.5}):
        _, records = flown({**kind, "engine": 1, "start_s": 2.0})
        for name in records.dtype.names:
            np.testing.assert_array_equal(records[name][:401], quiet[1][name][:401], err_msg=name)


def test_at_the_end_of_its_window_the_throttle_is_that_of_the_controls_again():
    flight, records = flown({"kind": "reduced", "power": 0.5, "engine": 1, "start_s": 1.0, "end_s": 2.0})
    fdm = flight.plant.fdm
    assert fdm["fcs/throttle-pos-norm[0]"] == fdm["ap/at-throttle"]
    # the frame from t_400 has the throttle of row 401, and the controls alone give it
    assert records["throttle"][401] == pytest.approx(2.0 * records["throttle"][400], rel=0.02)


def test_a_lost_motor_pulls_no_more_within_a_second_and_the_yaw_moment_is_thrust_times_arm():
    # 1: left; both thrusts lie along body x, five metres to either side
    flight, _ = flown({"kind": "loss", "engine": "left_motor", "start_s": 1.0}, duration_s=2)
    fdm = flight.plant.fdm
    left, right = thrust_n(fdm, 0), thrust_n(fdm, 1)
    assert -60.0 < left <= 0.0  # the drag of a propeller that the air turns
    assert right > 100.0
    yaw = fdm["moments/n-prop-lbsft"] * LBF_N * FT_M
    assert yaw == pytest.approx(ARM_M * (left - right), rel=1e-6)


def test_number_and_name_are_one_engine():
    one = flown({"kind": "loss", "engine": 2, "start_s": 1.0}, duration_s=2)[1]
    other = flown({"kind": "loss", "engine": "right_motor", "start_s": 1.0}, duration_s=2)[1]
    assert one.tobytes() == other.tobytes()


@pytest.mark.parametrize("at", [None, 0.4])
def test_a_stuck_throttle_stays(at):
    fault = {"kind": "stuck", "engine": 1, "start_s": 1.0, "end_s": 2.0}
    _, records = flown(fault if at is None else {**fault, "at": at}, reference={"theta_deg": 5})
    held = records["throttle"][200] if at is None else at
    np.testing.assert_array_equal(records["throttle"][201:401], held)
    # and without the fault it would have moved
    assert np.ptp(flown(reference={"theta_deg": 5})[1]["throttle"][201:401]) > 0.01
    assert records["throttle"][401] != held


def test_a_reduced_engine_has_the_throttle_of_the_controls_scaled():
    flight, records = flown({"kind": "reduced", "power": 0.5, "engine": 1, "start_s": 1.0})
    fdm = flight.plant.fdm
    assert fdm["fcs/throttle-pos-norm[0]"] == 0.5 * fdm["fcs/throttle-pos-norm[1]"]
    # the autothrottle opens both to hold the airspeed
    assert fdm["fcs/throttle-pos-norm[1]"] > 1.1 * records["throttle"][0]


def test_the_airspeed_hold_of_the_bridge_goes_on_acting():
    # of an aircraft without an autothrottle: the other engine is opened
    aircraft = {"aircraft": "jsbsim:737", "initial": {"airspeed_mps": 150, "altitude_m": 3000}, "duration_s": 5}
    flight, records = flown({"kind": "loss", "engine": 1, "start_s": 1.0}, **aircraft)
    assert flight.plant.settings["airspeed_hold"] == "bridge"
    assert flight.plant.fdm["fcs/throttle-pos-norm[1]"] > records["throttle"][0] + 0.05
    assert records["throttle"][-1] == 0.0


@pytest.mark.parametrize(
    ("name", "airspeed", "altitude", "engine", "least_s", "most_s"),
    [
        ("hale", 30.0, 1000.0, 0, 0.05, 1.0),  # electric: the propeller slows down first
        ("jsbsim:c172p", 50.0, 1000.0, 0, 0.2, 3.0),  # piston
        ("jsbsim:737", 150.0, 3000.0, 1, 0.0, 0.01),  # turbine: at once
    ],
)
def test_a_lost_engine_stops_within_a_stated_time(name, airspeed, altitude, engine, least_s, most_s):
    aircraft = load_aircraft(name)
    seen = tried(aircraft, trimmed_model(aircraft, airspeed, altitude), engine)
    assert seen.after_s is not None
    assert least_s < seen.after_s < most_s
    assert seen.left_n <= 1e-6 < seen.before_n


@pytest.mark.parametrize(
    ("name", "airspeed", "altitude"), [("jsbsim:c172p", 50.0, 1000.0), ("jsbsim:737", 150.0, 3000.0)]
)
def test_at_throttle_zero_alone_the_engine_would_run_on(name, airspeed, altitude):
    # why a loss is more than a throttle: a piston engine idles, a turbine keeps pulling
    aircraft = load_aircraft(name)
    model = trimmed_model(aircraft, airspeed, altitude)
    fdm = initialised(aircraft, 0.005)
    start(fdm, aircraft, Trim(**model.trim), np.zeros(3), {})
    freeze(fdm)
    for throttle in model.trim["throttles"]:
        fdm[throttle] = 0.0
    for _ in range(2000):
        fdm.run()
    assert fdm["propulsion/engine/set-running"] == 1.0


def test_only_the_engine_of_the_fault_is_stopped():
    # magnetos and cutoff are commanded for all engines or for the active one
    aircraft = load_aircraft("jsbsim:c310")
    flight, _ = flown(
        {"kind": "loss", "engine": 2, "start_s": 0.5},
        aircraft=aircraft.reference, initial={"airspeed_mps": 75, "altitude_m": 1500}, duration_s=2,
    )  # fmt: skip
    fdm = flight.plant.fdm
    assert [fdm[f"propulsion/engine[{j}]/set-running"] for j in (0, 1)] == [1.0, 0.0]
    assert thrust_n(fdm, 0) > 500.0
    assert thrust_n(fdm, 1) <= 0.0


@pytest.mark.parametrize(("lasts_s", "runs"), [(1.0, 1.0), (6.0, 0.0)])
def test_an_engine_starts_again_if_the_air_still_turns_it(lasts_s, runs):
    # fuel and ignition are back at the end of the window; after six seconds the propeller stands
    flight, _ = flown(
        {"kind": "loss", "engine": 1, "start_s": 0.5, "end_s": 0.5 + lasts_s},
        aircraft="jsbsim:c172p", initial={"airspeed_mps": 50, "altitude_m": 1000}, duration_s=10,
    )  # fmt: skip
    assert flight.plant.fdm["propulsion/engine/set-running"] == runs


def test_a_flight_flown_again_at_finer_steps_has_the_same_fault():
    flight = build_flight(scenario({"kind": "loss", "engine": 1, "start_s": 0.1}))
    plant = make_plant(flight.scenario, flight.aircraft, flight.model, Timing(0.005, 4), flight.inputs, flight.layout)
    rows = empty_rows(60, flight.shape)
    assert plant.run(bare(plant), rows, 0, 60) == 60
    throttle = [plant.fdm[f"fcs/throttle-pos-norm[{j}]"] for j in (0, 1)]
    assert throttle[0] == 0.0 < throttle[1]


def test_without_a_fault_the_copy_has_no_channel(hale):
    manager = jsbsim_plant(hale).fdm.get_property_manager()
    assert manager.get_node("uavftc/engine-gain[0]") is None


# --- refused --------------------------------------------------------------------------------------------------------


def refused(*faults, **changes) -> InputError:
    with pytest.raises(InputError) as error:
        build_flight(scenario(*faults, **changes))
    return error.value


@pytest.mark.parametrize(("engine", "near"), [(3, "choose one of them"), ("left_moter", "did you mean left_motor?")])
def test_an_engine_that_the_aircraft_does_not_have_is_refused_with_those_that_it_has(engine, near):
    error = refused({"kind": "loss", "engine": engine})
    assert error.where == "key faults[0].engine"
    assert error.expected == "one of 1 (left_motor), 2 (right_motor), the engines of hale"
    assert error.remedy == near


def test_a_glider_has_no_engine():
    error = refused({"kind": "loss", "engine": 1}, aircraft="jsbsim:SGS")
    assert "a fault of a surface: jsbsim:SGS has no engine" in error.expected


@pytest.mark.parametrize(("first", "second"), [(1, "left_motor"), ("left_motor", 1), (1, 1)])
def test_two_faults_of_one_engine_at_a_time_are_refused_and_both_named(first, second):
    error = refused({"kind": "loss", "engine": first, "end_s": 2}, {"kind": "stuck", "engine": second, "start_s": 1})
    assert error.where == "key faults[1]"
    assert error.found == "faults[1] on [1, end) s overlaps faults[0] on [0, 2) s, both on the left_motor"
    assert error.expected.startswith("at most one fault at a time on an engine")


def test_one_after_the_other_and_side_by_side_are_flown():
    flight, _ = flown(
        {"kind": "stuck", "engine": 1, "at": 0.6, "start_s": 0.5, "end_s": 1},
        {"kind": "reduced", "engine": 1, "power": 0.5, "start_s": 1},
        {"kind": "stuck", "engine": 2, "at": 0.2},
        {"kind": "stuck", "surface": "rudder", "at_deg": 0},
        duration_s=1.5,
    )
    fdm = flight.plant.fdm
    assert fdm["fcs/throttle-pos-norm[0]"] == 0.5 * fdm["ap/at-throttle"]
    assert fdm["fcs/throttle-pos-norm[1]"] == 0.2


def test_an_engine_that_goes_on_pulling_is_refused_with_what_was_measured(monkeypatch):
    # as a solid rocket would; here the propeller has no time to slow down
    monkeypatch.setattr(engine_faults, "LOST_S", 0.05)
    engine_faults._tried.cache_clear()
    try:
        error = refused({"kind": "loss", "engine": 1})
    finally:
        engine_faults._tried.cache_clear()
    assert error.where == "key faults[0].kind"
    assert "left_motor of hale pulls" in error.found
    assert "after 0.05 s without throttle, fuel and ignition" in error.found


def test_flight_controls_that_run_after_the_fault_are_refused(tmp_path):
    # in a file of their own they run after what the main file has in the same section
    folder = tmp_path / "hale"
    shutil.copytree(aircraft_dir() / "hale", folder)
    text = (folder / "hale.xml").read_text()
    begin, end = text.index("  <flight_control"), text.index("</flight_control>")
    late = (
        '<channel name="late"><fcs_function name="late/throttle"><function><sum><value>0</value>'
        "<property>ap/at-throttle</property></sum></function><output>fcs/throttle-pos-norm[0]</output></fcs_function></channel>"
    )
    (folder / "controls.xml").write_text(f"{text[begin:end].strip()}{late}</flight_control>")
    rest = text[end + len("</flight_control>") :]
    (folder / "hale.xml").write_text(f'{text[:begin]}<flight_control file="controls.xml"/>{rest}')
    error = refused({"kind": "reduced", "power": 0.5, "engine": 1}, aircraft=str(folder))
    assert error.where == "key faults[0].engine"
    assert "set the throttle after the fault" in error.found
    # the right motor is left to the autothrottle, in a <system>, which runs before
    build_flight(scenario({"kind": "reduced", "power": 0.5, "engine": 2}, aircraft=str(folder)))


def test_engines_count_in_the_order_of_the_xml_whatever_that_of_the_companion_file(edited):
    folder = edited("uavftc.yaml", ("left_motor:", "x:"), ("right_motor:", "left_motor:"), ("x:", "right_motor:"))
    # what is called right is now JSBSim's first
    aircraft = load_aircraft(str(folder))
    assert list(trimmed_model(aircraft, 30.0, 1000.0).engine_order) == ["right_motor", "left_motor"]
    assert list(trimmed_model(load_aircraft("hale"), 30.0, 1000.0).engine_order) == ["left_motor", "right_motor"]
