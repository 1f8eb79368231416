"""Servos in flight: their accuracy, what is published of them, and those that an aircraft has by itself."""

from __future__ import annotations

import numpy as np
import pytest
from ruamel.yaml import YAML

import v_tail
from flying import flown, integrals
from uavftc.config.shipped import scenario_names
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.recorder import published
from uavftc.flight.timing import timing_of
from uavftc.results.flight import notes_of
from uavftc.scenario.load import load_scenario, scenario_text

REAL = "actuators={bandwidth_radps: 57, damping: 0.7, rate_limit_degps: 100, delay_s: 0.02}"
ACCURATE = [  # with the plant steps a sample that are chosen for it: 57 rad/s x 0.83 ms, or 1.25 ms
    (REAL, 6),
    ("actuators={bandwidth_radps: 57, damping: 0.7, delay_s: 0.02}", 6),
    ("actuators={bandwidth_radps: 57, delay_s: 0.02}", 6),
    ("actuators={bandwidth_radps: 57, delay_s: 0.02, backlash_deg: 0.1}", 6),
    ("actuators={rate_limit_degps: 60, delay_s: 0.01}", 4),
]


@pytest.mark.parametrize(("servo", "chosen"), ACCURATE)
@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_integrals_change_by_less_than_a_thousandth_at_half_the_step(plant, servo, chosen):
    # IAE, ISE, ITAE, ITSE of scenario 3 with a real servo, at the steps that are chosen for it and at half of them
    assert timing_of(load_scenario("scenario3", plant=plant, overrides=[servo])).substeps == chosen
    coarse, fine = (integrals("scenario3", plant, (servo, f"simulation.substeps={n}")) for n in (chosen, 2 * chosen))
    assert np.abs(coarse / fine - 1.0).max() < 1e-3


def test_plant_steps_suit_the_servo_and_all_delays_where_they_are_left_open():
    def substeps(*overrides):
        return timing_of(load_scenario("scenario3", overrides=list(overrides))).substeps

    assert substeps("actuators.min_deg=-5") == 1  # nothing to resolve
    assert substeps("actuators.rate_limit_degps=60") == 4
    assert substeps("actuators.bandwidth_radps=10") == 1
    assert substeps("actuators.rudder.bandwidth_radps=57") == 6
    assert substeps("actuators.bandwidth_radps=1000") == 8  # as fine as it becomes
    assert substeps("actuators.delay_s=0.0125") == 4
    assert substeps("actuators.delay_s=0.011") == 5  # fifths of a sample
    assert substeps("faults=[{kind: rate-limit, surface: rudder, rate_degps: 5}]") == 4
    assert substeps("actuators.delay_s=0.0125", "actuators.rudder.delay_s=0.011") == 8  # halves and fifths: the finest
    assert substeps("faults=[{kind: delay, surface: rudder, delay_s: 0.006}]") == 5
    assert substeps("actuators.bandwidth_radps=57", "simulation.substeps=1") == 1  # who asks for one gets it


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_the_servo_is_published_counted_as_its_surface_is(plant):
    # between the samples of a fault-free flight the surface is what the servo reaches: to the end of the step on
    # JSBSim, with a twelfth of the corner of each new command besides
    over = ("actuators.bandwidth_radps=20", "actuators.rudder=null", "simulation.substeps=1", "duration_s=5")
    flight, records, _ = flown("scenario1", plant, None, over)
    names = [c.name for c in flight.columns if c.name.endswith("_servo_rad")]
    assert names == ["left_aileron_servo_rad", "right_aileron_servo_rad", "elevator_servo_rad"]
    history = published(records, flight.columns)
    share = 1.0 - np.exp(-20.0 * 0.005)
    assert np.ptp(history["right_aileron_servo_rad"]) > 0.01
    for name in ("left_aileron", "right_aileron", "elevator"):
        y, u = history[f"{name}_servo_rad"], history[f"{name}_cmd_rad"]
        low, high = ((-0.05, 0.1), (-0.1, 0.05))[name == "right_aileron"]
        u = np.clip(u, low, high)
        np.testing.assert_allclose(y[1:], y[:-1] + share * (u[:-1] - y[:-1]), rtol=0, atol=1e-14)
        if plant == "jsbsim":
            corner = 20.0 * np.diff(u, prepend=u[:1])  # y' = 20 (u - y) jumps by this as the command does
            corner[0] = 20.0 * u[0]
            np.testing.assert_allclose(history[f"{name}_rad"][:-1], y[1:] + corner[:-1] * 0.005 / 12, atol=1e-14)


def test_a_scenario_as_flown_says_the_same_again():
    # what an own map leaves out is filled in, and nothing of it is lost
    over = [REAL, "actuators.left_aileron={bandwidth_radps: 20, damping: null}", "actuators.rudder=null"]
    scenario = load_scenario("scenario1", overrides=over)
    text = scenario_text(scenario)
    assert "left_aileron:" in text
    assert scenario.actuators.named()["left_aileron"].rate_limit_degps == 100
    again = type(scenario).model_validate(YAML(typ="safe").load(text))
    assert again == scenario
    assert scenario_text(again) == text


REFUSED = [
    ("actuators.bandwidth=20", "actuators.bandwidth", ["unknown key 'bandwidth'", "did you mean bandwidth_radps?"]),
    ("actuators.delay_s=-1", "actuators.delay_s", ["at least 0, s"]),
    ("actuators.rudder={bandwidth_radp: 20}", "actuators.rudder.bandwidth_radp", ["did you mean bandwidth_radps?"]),
    ("actuators.rudder={bandwidth_radps: t}", "actuators.rudder.bandwidth_radps", ["a finite number, rad/s", "quotes"]),
    ("actuators.rudder={min_deg: 1}", "actuators.rudder.min_deg", ["at most 0, deg"]),
    ("actuators.rudder=20", "actuators.rudder", ["unknown key 'rudder'", "or the name of a surface with a section"]),
    ("actuators.damping=0.7", "actuators.damping", ["0.7 alone", "bandwidth_radps next to it"]),
    ("actuators.rudder={damping: 0.7}", "actuators.rudder.damping", ["0.7 alone", "bandwidth_radps next to it"]),
    ("actuators={min_deg: 0, max_deg: 0}", "actuators.max_deg", ["a servo that can move"]),
    ("actuators=20", "actuators", ["a section"]),
    ("faults=[{kind: delay, surface: rudder}]", "faults[0].delay_s", ["add delay_s"]),
    ("faults=[{kind: backlash, surface: rudder, width_deg: 0}]", "faults[0].width_deg", ["greater than 0, deg"]),
    ("faults=[{kind: rate-limit, surface: rudder, width_deg: 1}]", "faults[0].width_deg", ["belongs to kind"]),
    ("faults=[{kind: rate_limit, surface: rudder}]", "faults[0].kind", ["did you mean rate-limit?"]),
]


@pytest.mark.parametrize(("override", "key", "said"), REFUSED, ids=[r[0] for r in REFUSED])
def test_a_wrong_key_is_refused_with_its_place_and_what_to_write(override, key, said):
    with pytest.raises(InputError) as told:
        load_scenario("scenario1", overrides=[override])
    message = str(told.value)
    assert f"key {key}\n" in message
    for words in said:
        assert words in message


def test_a_delay_that_takes_too_much_memory_is_refused_with_its_key():
    many = ["duration_s=10000", "simulation.substeps=6"]
    for override, key in (
        ("actuators.delay_s=9000", "actuators.delay_s"),
        ("actuators.rudder.delay_s=9000", "actuators.rudder.delay_s"),
        ("faults=[{kind: delay, surface: rudder, delay_s: 9000}]", "faults[0].delay_s"),
    ):
        with pytest.raises(InputError, match="at most 10000000 plant steps") as told:
            load_scenario("scenario1", overrides=[override, *many])
        assert f"key {key}\n" in str(told.value)


def test_a_name_that_the_aircraft_does_not_have_is_refused_with_the_nearest():
    with pytest.raises(InputError) as told:
        build_flight(load_scenario("scenario1", overrides=["actuators.left_ailron.delay_s=0.01"]))
    assert "key actuators.left_ailron" in str(told.value)
    assert "did you mean left_aileron?" in str(told.value)


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
def test_a_controller_is_given_how_far_the_servos_go(plant):
    # the closest of saturation (rad), servo (deg) and stop; an aileron's members count as the axis does
    over = ["saturation={min_rad: -0.05, max_rad: 0.1}", "actuators={min_deg: -4, max_deg: 4, rudder: null}"]
    own = "actuators.left_aileron={min_deg: -2, max_deg: 3}"
    for more, left in (([], (-0.05, np.radians(4.0))), ([own], (np.radians(-2.0), np.radians(3.0)))):
        design = build_flight(load_scenario("scenario1", plant=plant, overrides=[*over, *more])).given.design
        expected = [left, (-0.05, np.radians(4.0)), (-0.05, 0.1)]
        np.testing.assert_allclose(design.limits_rad, expected, rtol=0, atol=1e-15)
    free = build_flight(load_scenario("scenario1", plant=plant, overrides=["saturation=null", over[1]])).given
    np.testing.assert_allclose(free.design.limits_rad[2], free.stops_rad[3], rtol=0, atol=1e-15)  # the rudder's stops


# --- an aircraft with servos of its own ------------------------------------------------------------------------------

OWN = "lag 40 rad/s, delay 20 ms, backlash 1 deg"


@pytest.fixture(scope="module")
def tail(tmp_path_factory):
    """The folder of an aircraft with a servo at each surface."""
    return str(v_tail.write(tmp_path_factory.mktemp("servos")))


def of_tail(folder, *overrides, plant="jsbsim"):
    keys = ["initial={airspeed_mps: 25, altitude_m: 200}", "duration_s=2", "saturation=null", "faults=[]"]
    flight = build_flight(
        load_scenario("scenario1", plant=plant, aircraft=folder, overrides=[*keys, "disturbances=[]", *overrides])
    )
    return flight, fly_to_memory(flight)[0]


def test_the_servo_of_an_aircrafts_own_is_not_doubled_and_said(tail):
    # the common keys leave it out: the flight is the one without them, to the bit, and a warning says what it has
    keys = "actuators={rate_limit_degps: 30, delay_s: 0.01}"
    plain, without = of_tail(tail)
    flight, records = of_tail(tail, keys)
    assert records.tobytes() == without.tobytes()
    assert not {"lag", "servo_delay"} & set(flight.program.names)
    (said,) = (note for note in notes_of(flight) if note.startswith("actuators"))
    assert "ail_l, ail_r, tail_l, tail_r of" in said
    assert f"have servos of their own ({OWN}), so the common keys leave them out" in said
    assert not any("actuators" in note for note in notes_of(plain))


def test_an_own_name_puts_a_servo_ahead_of_the_aircrafts_and_says_that_both_act(tail):
    # the command of that surface comes later, and those of the others do not
    flight, records = of_tail(tail, "actuators={tail_l: {delay_s: 0.05}}", "simulation.substeps=1")
    (said,) = (note for note in notes_of(flight) if note.startswith("actuators"))
    assert said.startswith("actuators.tail_l: tail_l of")
    assert said.endswith(f"has a servo of its own ({OWN}), and what is given here acts ahead: both act")
    assert "servo_delay" in flight.program.names
    params = flight.program["servo_delay"].state
    j = flight.given.effectors.index("tail_l")
    assert [bool(line[1]) for line in params] == [k == j for k in range(4)]  # the delay of each, in plant steps
    assert np.isfinite(records["x1"]).all()


def test_the_analytic_plant_has_the_scenarios_servos_only(tail):
    # it flies no XML, so nothing can be doubled there
    flight, _ = of_tail(tail, "actuators.bandwidth_radps=57", plant="analytic")
    assert "lag" in flight.program.names
    assert not any(note.startswith("actuators") for note in notes_of(flight))


def test_two_gangs_with_a_servo_for_one_effector_are_refused(tail):
    # the V-tail serves pitch and yaw; by its own name each is settled
    both = "actuators={elevator: {delay_s: 0.01}, rudder: {delay_s: 0.02}}"
    with pytest.raises(InputError, match="one servo for each effector") as told:
        of_tail(tail, both)
    assert "key actuators.rudder" in str(told.value)
    assert "tail_l, which is of elevator too" in str(told.value)
    named = both.replace("}}", "}, tail_l: {}, tail_r: {delay_s: 0.04}}")
    flight, _ = of_tail(tail, named)
    assert "servo_delay" in flight.program.names


# --- the shipped ones ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
@pytest.mark.parametrize("name", [name for name in scenario_names("beyond") if name.startswith("beyond/servo-")])
def test_the_shipped_servos_are_flown_to_their_reference(name, plant):
    # each acts, and is held by the controller
    flight, records, outcome = flown(name, plant)
    assert outcome.completed
    assert {"lag", "servo_delay"} & set(flight.program.names)
    error = np.degrees(np.abs(records["x1_c"] - records["x1"])[-1])
    assert error.max() < 0.06  # of the 5 deg step exp(-0.5 t) are left on a c172p, after 12 s 0.012 deg, and its drift
    ideal = flown(name, plant, None, ("actuators=null",))[1]
    assert np.degrees(np.abs(records["u2"] - ideal["u2"])).max() > 0.1


FAULTS = [f"fault-{kind}{on}" for kind in ("rate-limit", "delay", "backlash", "deadband") for on in ("", "-c172p")]


@pytest.mark.parametrize("name", FAULTS)
def test_the_shipped_faults_of_servos_change_the_flight(name):
    # and after the window the controller brings it back
    _, records, outcome = flown(f"beyond/{name}")
    assert outcome.completed
    assert outcome.remarks == ()
    free = flown(f"beyond/{name}", "jsbsim", None, ("faults=[]",))[1]
    apart = np.degrees(np.abs(records["u2"] - free["u2"]))
    inside = apart[records["t"] < 12.0].max()
    assert inside > 0.2
    assert apart[-1].max() < 0.1 * inside
