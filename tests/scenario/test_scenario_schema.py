"""The schema: defaults, units of meaning, and every refusal with its key, what was found and what was expected."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from uavftc.config.values import window_of
from uavftc.scenario.checks import warnings
from uavftc.scenario.schema import Scenario


def scenario(**changes) -> Scenario:
    return Scenario.model_validate({"name": "test", "duration_s": 20, **changes})


def test_defaults_are_the_papers():
    s = scenario()
    outer, inner = s.controller.outer, s.controller.inner
    assert (outer.kind, outer.bandwidth, outer.sigma, outer.gamma) == ("nndo-ndi", (0.5,) * 3, (0.5,) * 3, 0.05)
    assert (outer.rbf.centres, outer.rbf.width) == ((-0.2, -0.1, 0.0, 0.1, 0.2), 0.4)
    assert (inner.kind, inner.adaptation_gain, inner.filter_bandwidth) == ("l1", 1e5, 60.0)
    assert inner.reference_gain == "plant"
    assert inner.B_m is None
    # the printed A_s = A_m + K_1 of section 4
    A_s = np.array(inner.A_m) + np.array(inner.K_1)
    np.testing.assert_array_equal(A_s, [[-7.5, 1.2, -3.5], [-1.5, -0.5, -1], [-0.02, 0, -1]])
    assert (s.plant, s.aircraft, s.seed, s.saturation, s.faults) == ("jsbsim", "hale", 0, None, ())
    assert s.controller.rate_hz == 200


def test_every_section_may_be_left_out_or_null():
    sections = ("initial", "reference", "controller", "saturation", "faults", "disturbances", "sensors", "envelope")
    assert scenario(**dict.fromkeys(sections)) == scenario()
    assert scenario(controller={"outer": None, "inner": None}) == scenario()


def test_a_number_stands_for_three_axes():
    assert scenario(controller={"outer": {"bandwidth": 2}}).controller.outer.bandwidth == (2.0, 2.0, 2.0)
    assert scenario(sensors={"gyro_bias_degps": 0.3}).sensors.gyro_bias_degps == (0.3, 0.3, 0.3)


def test_a_scenario_cannot_be_changed():
    with pytest.raises(ValidationError, match="frozen"):
        scenario().plant = "analytic"


def test_limits_of_each_surface():
    one = {"min_rad": -0.05, "max_rad": 0.1}
    np.testing.assert_array_equal(scenario(saturation=one).limits_rad(), [[-0.05, 0.1]] * 3)
    per_surface = scenario(saturation={"elevator": one}).limits_rad()
    np.testing.assert_array_equal(per_surface, [[-np.inf, np.inf], [-0.05, 0.1], [-np.inf, np.inf]])
    assert np.isinf(scenario().limits_rad()).all()


def test_samples_and_substeps():
    s = scenario()
    assert (s.steps, len(s.times()), s.times()[-1], s.substeps) == (4000, 4001, 20.0, 1)
    assert scenario(controller={"rate_hz": 50}).substeps == 4  # 20 ms in steps of at most 5 ms
    assert scenario(controller={"rate_hz": 1000}).substeps == 1
    assert scenario(simulation={"substeps": 7}).substeps == 7


def test_a_window_holds_its_start_and_not_its_end():
    fault = scenario(faults=[{"surface": "rudder", "start_s": 8, "end_s": 12}]).faults[0]
    assert window_of(fault, np.array([7.995, 8.0, 11.995, 12.0])) == slice(1, 3)
    assert window_of(fault, np.array([1.0, 2.0])) == slice(2, 2)  # before it


REFUSED = [
    # text of the file, line, key, what the message must say
    ("foo: 1", 3, "foo", ["unknown key 'foo'"]),
    ("duration: 3", 3, "duration", ["did you mean duration_s?"]),
    ("plant: x-plane", 3, "plant", ["'x-plane'", "jsbsim, analytic"]),
    ("plant: null", 3, "plant", ["null", "jsbsim, analytic"]),
    ("seed:", 3, "seed", ["null", "whole number"]),
    ("aircraft: null", 3, "aircraft", ["null", "a text"]),
    ("seed: -1", 3, "seed", ["-1", "at least 0"]),
    ("seed: 1.5", 3, "seed", ["whole number"]),
    ("seed: true", 3, "seed", ["true", "whole number"]),
    ("description: 5", 3, "description", ["a text"]),
    ("initial: {airspeed_mps: 0}", 3, "initial.airspeed_mps", ["greater than 0, m/s"]),
    ("initial: {airspeed: 30}", 3, "initial.airspeed", ["did you mean airspeed_mps?"]),
    ("reference: 5", 3, "reference", ["section"]),
    ("reference: {phi_rad: 1}", 3, "reference.phi_rad", ["did you mean phi_deg?"]),
    ("reference: {phi_deg: true}", 3, "reference.phi_deg", ["true", "number or an expression"]),
    ("reference: {phi_deg: .nan}", 3, "reference.phi_deg", ["not finite"]),
    ("reference: {phi_deg: 1e999}", 3, "reference.phi_deg", ["not finite"]),
    ("reference: {phi_deg: [1]}", 3, "reference.phi_deg", ["number or an expression"]),
    ("reference: {phi_deg: t.real}", 3, "reference.phi_deg", ["'t.real'", "'.' is not allowed"]),
    ("reference:\n  phi_deg: 1\n  theta_deg: 1/(t - 5)", 5, "reference.theta_deg", ["is inf at t = 5 s"]),
    ("controller: 5", 3, "controller", ["section"]),
    ("controller: {rate_hz: 0}", 3, "controller.rate_hz", ["at least 1, Hz"]),
    ("controller: {rate_hz: 20000}", 3, "controller.rate_hz", ["at most 10000"]),
    ("controller: {rate_hz: .inf}", 3, "controller.rate_hz", ["finite"]),
    ("controller: {delay_s: -0.1}", 3, "controller.delay_s", ["at least 0, s"]),
    ("controller: {outer: {kind: pid}}", 3, "controller.outer.kind", ["'pid'", "ndi, nndo-ndi"]),
    ("controller: {outer: 5}", 3, "controller.outer", ["section"]),
    ("controller: {outer: {bandwidth: [1, 2]}}", 3, "controller.outer.bandwidth", ["list of three"]),
    ("controller: {outer: {bandwidth: [1, 2, 0]}}", 3, "controller.outer.bandwidth[2]", ["greater than 0"]),
    ("controller: {outer: {bandwidth: [1, 2, true]}}", 3, "controller.outer.bandwidth[2]", ["true", "number"]),
    ("controller: {outer: {kind: ndi, sigma: 1}}", 3, "controller.outer.sigma", ["belongs to kind nndo-ndi"]),
    ("controller: {outer: {rbf: {centres: [1, 2]}}}", 3, "controller.outer.rbf.centres", ["five numbers"]),
    ("controller: {inner: {kind: mrac, filter_bandwidth: 6}}", 3, "controller.inner.filter_bandwidth", ["kind l1"]),
    (
        "controller: {inner: {filter_bandwith: 6}}",
        3,
        "controller.inner.filter_bandwith",
        ["did you mean filter_bandwidth?"],
    ),
    ("controller: {inner: {adaptation_gain: 0}}", 3, "controller.inner.adaptation_gain", ["greater than 0"]),
    ("controller: {inner: {effectiveness_bounds: [1.5, 2]}}", 3, "controller.inner.effectiveness_bounds", ["<= 1 <="]),
    ("controller: {inner: {effectiveness_bounds: [0.1]}}", 3, "controller.inner.effectiveness_bounds", ["list of 1"]),
    ("controller: {inner: {reference_gain: K}}", 3, "controller.inner.reference_gain", ["plant, printed"]),
    ("controller: {inner: {A_m: [[1, 0, 0], [0, 1, 0]]}}", 3, "controller.inner.A_m", ["3x3"]),
    ("controller: {inner: {A_m: [[1, 0, 0], [0, 1, 0], [0, 0, a]]}}", 3, "controller.inner.A_m[2][2]", ["'a'"]),
    (
        "controller: {inner: {K_1: [[9, 0, 0], [0, 9, 0], [0, 0, 9]]}}",
        3,
        "controller.inner.A_m",
        ["not Hurwitz", "A_m + K_1"],
    ),
    (
        "controller: {inner: {A_m: [[-8.5, 1.2, -3.5], [-1.5, -1e+12, -1], [-0.02, 0, -2]]}}",
        3,
        "controller.inner.A_m",
        ["condition number below 1e+08"],
    ),
    ("controller: {inner: {Q: [[1, 1, 0], [0, 1, 0], [0, 0, 1]]}}", 3, "controller.inner.Q", ["not symmetric"]),
    (
        "controller: {inner: {Q: [[1, 0, 0], [0, -1, 0], [0, 0, 1]]}}",
        3,
        "controller.inner.Q",
        ["not positive definite"],
    ),
    ("controller: {inner: {B_m: [[1, 0, 0], [0, 1, 0], [1, 1, 0]]}}", 3, "controller.inner.B_m", ["invertible"]),
    ("saturation: 0.1", 3, "saturation", ["section"]),
    ("saturation: {min_rad: -0.1}", 3, "saturation.max_rad", ["nothing"]),
    ("saturation: {min_rad: 0.1, max_rad: 0.2}", 3, "saturation.min_rad", ["at most 0, rad"]),
    ("saturation: {min_rad: -0.2, max_rad: -0.1}", 3, "saturation.max_rad", ["min <= 0 <= max"]),
    ("saturation: {min_rad: 0, max_rad: 0}", 3, "saturation.max_rad", ["min < max"]),
    ("saturation: {flap: {min_rad: 0.1, max_rad: 1}, rudder: null}", 3, "saturation.flap.min_rad", ["at most 0, rad"]),
    ("saturation: {rudder: {min_rad: -1, max_rad: 1, max: 1}}", 3, "saturation.rudder.max", ["did you mean max_rad?"]),
    ("faults: 5", 3, "faults", ["a list"]),
    ("faults: [5]", 3, "faults[0]", ["section"]),
    ("faults:\n  - {effectiveness: 0.5}", 4, "faults[0].surface", ["nothing"]),
    ("faults:\n  - {surface: left aileron}", 4, "faults[0].surface", ["'left aileron'", "letters, digits and _"]),
    ("faults:\n  - {surface: 3}", 4, "faults[0].surface", ["a text"]),
    (
        "faults: [{surface: rudder, kind: stick}]",
        3,
        "faults[0].kind",
        ["'stick'", "stuck, total-loss", "did you mean stuck?"],
    ),
    ("faults: [{surface: rudder, at_deg: 2}]", 3, "faults[0].at_deg", ["write kind: stuck"]),
    ("faults: [{engine: 1}]", 3, "faults[0].kind", ["nothing", "one of loss, stuck, reduced"]),
    (
        "faults: [{engine: 1, kind: los}]",
        3,
        "faults[0].kind",
        ["'los'", "one of loss, stuck, reduced", "did you mean loss?"],
    ),
    (
        "faults: [{engine: 1, kind: hardover}]",
        3,
        "faults[0].kind",
        ["'hardover'", "one of loss, stuck, reduced", "a fault of a surface: write surface in place of engine"],
    ),
    (
        "faults: [{surface: rudder, kind: loss}]",
        3,
        "faults[0].kind",
        [
            "'loss'",
            "drift, hardover, float, stuck, total-loss",
            "a fault of an engine: write engine in place of surface",
        ],
    ),
    ("faults: [{kind: stuck}]", 3, "faults[0].surface", ["nothing"]),
    (
        "faults: [{engine: 1, surface: rudder, kind: stuck}]",
        3,
        "faults[0].surface",
        [
            "unknown key 'surface'",
            "one of kind, start_s, end_s, known, known_after_s, engine, at",
            "leave one of the two out",
        ],
    ),
    ("faults: [{engine: 1, kind: stuck, at_deg: 2}]", 3, "faults[0].at_deg", ["at, a throttle position from 0 to 1"]),
    ("faults: [{engine: 1, kind: stuck, at: 1.5}]", 3, "faults[0].at", ["at most 1"]),
    ("faults: [{engine: 1, kind: reduced}]", 3, "faults[0].power", ["nothing"]),
    ("faults: [{engine: 0, kind: loss}]", 3, "faults[0].engine", ["0", "1 is the first in the XML, or its name"]),
    ("faults: [{engine: true, kind: loss}]", 3, "faults[0].engine", ["true", "1 is the first in the XML"]),
    ("faults: [{engine: null, kind: loss}]", 3, "faults[0].engine", ["null", "1 is the first in the XML"]),
    ("faults: [{engine: left motor, kind: loss}]", 3, "faults[0].engine", ["'left motor'", "or its name"]),
    (
        "plant: analytic\nfaults: [{engine: 1, kind: loss}]",
        4,
        "faults[0].kind",
        ["loss on plant: analytic", "plant: jsbsim; the rotational model has no engines"],
    ),
    ("faults: [{surface: rudder, start_s: -1}]", 3, "faults[0].start_s", ["at least 0, s"]),
    ("faults: [{surface: rudder, start_s: 5, end_s: 5}]", 3, "faults[0].end_s", ["after start_s, 5 s"]),
    ("faults: [{surface: rudder, effectiveness: -1}]", 3, "faults[0].effectiveness", [">= 0"]),
    (
        "faults: [{surface: rudder, effectiveness: 1 - 0.1*t}]",
        3,
        "faults[0].effectiveness",
        [">= 0", "at t = 10.005 s"],
    ),
    ("faults: [{surface: rudder, bias_deg: 1/t}]", 3, "faults[0].bias_deg", ["is inf at t = 0 s"]),
    ("disturbances: [{p_degps2: 1}]", 3, "disturbances[0].kind", ["nothing", "angular-acceleration"]),
    ("disturbances: [{kind: wnd}]", 3, "disturbances[0].kind", ["did you mean wind?"]),
    ("disturbances: [{kind: [1]}]", 3, "disturbances[0].kind", ["angular-acceleration"]),
    ("disturbances: [{kind: wind, north: 1}]", 3, "disturbances[0].north", ["did you mean north_mps?"]),
    ("disturbances: [{kind: gust}]", 3, "disturbances[0].ramp_s", ["nothing"]),
    ("disturbances: [{kind: gust, ramp_s: 0}]", 3, "disturbances[0].ramp_s", ["greater than 0"]),
    ("disturbances: [{kind: gust, ramp_s: 1, end_s: 9}]", 3, "disturbances[0].end_s", ["ends by itself"]),
    ("disturbances: [{kind: gust, ramp_s: 1, down_mps: 2*t}]", 3, "disturbances[0].down_mps", ["takes no expression"]),
    (
        "disturbances: [{kind: turbulence}]",
        3,
        "disturbances[0].severity",
        ["neither severity nor sigma_mps and length_m", "give severity: light"],
    ),
    (
        "disturbances: [{kind: turbulence, severity: light, sigma_mps: [1, 1, 1]}]",
        3,
        "disturbances[0].severity",
        ["severity and sigma_mps", "one way to say"],
    ),
    ("disturbances: [{kind: turbulence, sigma_mps: [1, 1, 1]}]", 3, "disturbances[0].sigma_mps", ["one way to say"]),
    ("disturbances: [{kind: turbulence, severity: hard}]", 3, "disturbances[0].severity", ["light", "moderate"]),
    ("disturbances: [{kind: turbulence, sigma_mps: 1}]", 3, "disturbances[0].sigma_mps", ["[u, v, w]"]),
    (
        "disturbances: [{kind: turbulence, sigma_mps: [1, 1, 1], length_m: [1, 0, 1]}]",
        3,
        "disturbances[0].length_m[1]",
        ["greater than 0, m"],
    ),
    ("disturbances: [{kind: shear, exponent: -1}]", 3, "disturbances[0].exponent", ["at least 0"]),
    ("disturbances: [{kind: shear, north_mps_per_m: 1}]", 3, "disturbances[0].north_mps_per_m", ["profile: linear"]),
    ("disturbances: [{kind: shear, profile: linear, exponent: 1}]", 3, "disturbances[0].exponent", ["profile: power"]),
    ("disturbances: [{kind: gust-train, ramp_s: 1}]", 3, "disturbances[0].count", ["nothing"]),
    ("disturbances: [{kind: gust-train, ramp_s: 1, count: 0}]", 3, "disturbances[0].count", ["at least 1"]),
    (
        "disturbances: [{kind: gust-train, ramp_s: 1, count: 2, spacing_s: 1.5}]",
        3,
        "disturbances[0].spacing_s",
        ["1.5 s", "at least the length of a gust, 2*ramp_s + hold_s = 2 s"],
    ),
    ("disturbances: [{kind: gust-train, ramp_s: 1, count: 2, end_s: 9}]", 3, "disturbances[0].end_s", ["by itself"]),
    (
        "disturbances: [{kind: attitude-rate, phi_degps: 1}]",
        3,
        "disturbances[0].kind",
        ["exact", "sensors.gyro_bias_degps"],
    ),
    (
        "plant: analytic\ndisturbances: [{kind: wind, north_mps: 1}]",
        4,
        "disturbances[0].kind",
        ["rotational only", "jsbsim"],
    ),
    ("plant: analytic\ndisturbances: [{kind: gust, ramp_s: 1}]", 4, "disturbances[0].kind", ["rotational only"]),
    ("sensors: {gyro_bias_degps: [1, 2]}", 3, "sensors.gyro_bias_degps", ["list of three"]),
    ("sensors: {gyro_bias_degps: [1, 2, t]}", 3, "sensors.gyro_bias_degps[2]", ["'t'", "deg/s"]),
    ("envelope: {bank_deg: 0}", 3, "envelope.bank_deg", ["greater than 0, deg"]),
    (
        "envelope: {min_airspeed_mps: 9, max_airspeed_mps: 8}",
        3,
        "envelope.max_airspeed_mps",
        ["above min_airspeed_mps"],
    ),
    ("simulation: {substeps: 0}", 3, "simulation.substeps", ["at least 1"]),
    ("simulation: {substeps: 2.0}", 3, "simulation.substeps", ["whole number"]),
    ("aircraft: ''", 3, "aircraft", ["at least 1 char"]),
]


@pytest.mark.parametrize(("text", "line", "key", "said"), REFUSED, ids=[r[0].replace("\n", " ")[:70] for r in REFUSED])
def test_refusals_name_file_line_and_key(refused, text, line, key, said):
    message = str(refused(text))
    assert message.splitlines()[0].endswith(f"test.yaml, line {line}, key {key}")
    assert message.count("found:") == 1  # one error for one mistake: nothing of a union's other members
    for words in said:
        assert words in message


@pytest.mark.parametrize(
    ("head", "key", "said"),
    [
        ("duration_s: 1", "name", "nothing"),
        ("name: test", "duration_s", "the key duration_s, s"),
        ("name: a/b\nduration_s: 1", "name", "letters"),
        ("name: -a\nduration_s: 1", "name", "letters"),
        ('name: "a\\n"\nduration_s: 1', "name", "letters"),
        (f"name: {'a' * 101}\nduration_s: 1", "name", "at most 100"),
        ("name: a\nduration_s: 0", "duration_s", "greater than 0"),
        ("name: a\nduration_s: .inf", "duration_s", "finite"),
        ("name: a\nduration_s: '20'", "duration_s", "finite number"),
        ("name: a\nduration_s: true", "duration_s", "true"),
        ("name: a\nduration_s: 0.0101", "duration_s", "nearest is 0.01 s (2 samples)"),
        ("name: a\nduration_s: 1.0e-9", "duration_s", "nearest is 0.005 s"),
        ("name: a\nduration_s: 1e9", "duration_s", "at most 20000000 samples"),
        ("name: a\nduration_s: 1e308\ncontroller: {rate_hz: 1e4}", "duration_s", "at most 20000000"),
    ],
)
def test_name_and_duration(refused, head, key, said):
    message = str(refused(head=head + "\n"))
    assert f"key {key}\n" in message
    assert said in message


def test_several_mistakes_are_reported_at_once(refused):
    error = refused("plant: x\nfaults:\n  - {surface: 3}\n  - {surface: rudder, foo: 1}\n")
    assert [e.where.rpartition("key ")[2] for e in error.errors] == ["plant", "faults[0].surface", "faults[1].foo"]
    assert str(error).startswith("3 errors")


def test_a_thousand_mistakes_fit_on_a_screen(refused):
    error = refused("".join(f"key{i}: 1\n" for i in range(1000)))
    assert len(error.errors) == 9
    assert "992 more errors" in str(error)


def test_overlapping_faults_are_both_named(refused):
    text = """
        faults:
          - {surface: aileron, start_s: 0, end_s: 8}
          - {surface: rudder, start_s: 0}
          - {surface: aileron, start_s: 7.5, end_s: 9}
        """
    message = str(refused(text))
    assert "line 7, key faults[2]" in message
    assert "faults[2] on [7.5, 9) s overlaps faults[0] on [0, 8) s, both on the aileron" in message


def test_an_endless_fault_overlaps_all_that_follow(refused):
    faults = "faults: [{surface: rudder, start_s: 5}, {surface: rudder, start_s: 99}, {surface: rudder, end_s: 5}]"
    assert "faults[1] on [99, end) s overlaps faults[0] on [5, end) s" in str(refused(faults))


def test_a_short_fault_within_a_long_one_does_not_hide_the_next(refused):
    faults = [(0, 10), (1, 2), (5, 6)]
    text = "faults:\n" + "".join(f"  - {{surface: rudder, start_s: {a}, end_s: {b}}}\n" for a, b in faults)
    assert "faults[2] on [5, 6) s overlaps faults[0]" in str(refused(text))


def test_touching_faults_and_overlapping_disturbances_are_allowed(load):
    s = load("""
        faults: [{surface: rudder, end_s: 8}, {surface: rudder, start_s: 8}]
        disturbances: [{kind: wind, north_mps: 1}, {kind: wind, north_mps: sin(t)}, {kind: gust, ramp_s: 1}]
        """)
    assert len(s.faults) == 2
    assert len(s.disturbances) == 3


def test_expressions_are_judged_on_the_samples_of_their_window_only(load):
    # 1/t is infinite at t = 0 alone, and 1/(t - 12) at the end of a window that does not hold its end
    load("faults: [{surface: rudder, start_s: 0.005, end_s: 12, effectiveness: 1/t, bias_deg: 1/(t - 12)}]")
    load("faults: [{surface: rudder, start_s: 25, end_s: 30, bias_deg: 1/(t - 27)}]")  # after the flight
    load("reference: {phi_deg: 1/(t - 0.0025)}")  # between two samples


def test_pole_at_the_last_sample_is_found(refused):
    assert "at t = 20 s" in str(refused("reference: {phi_deg: 1/(t - 20)}"))


def test_effectiveness_over_one_warns(load):
    s = load("faults: [{surface: rudder, start_s: 8, end_s: 12, effectiveness: 0.2*t}]")
    (line,) = warnings(s)
    assert line.startswith("faults[0].effectiveness: 0.2*t reaches 2.4 on 8-12 s")
    assert warnings(load("faults: [{surface: rudder, effectiveness: 1}]")) == []


def test_what_starts_after_the_flight_warns(load):
    (line,) = warnings(load("disturbances: [{kind: gust, start_s: 30, ramp_s: 1}]"))
    assert line.startswith("disturbances[0]: starts at 30 s, after the end")


def test_both_d1_and_d2_on_the_analytic_plant(load):
    s = load("""
        plant: analytic
        disturbances: [{kind: attitude-rate, phi_degps: 1}, {kind: angular-acceleration, p_degps2: 1}]
        """)
    assert [d.kind for d in s.disturbances] == ["attitude-rate", "angular-acceleration"]


def test_made_in_python_a_scenario_is_checked_all_the_same():
    with pytest.raises(ValidationError, match="overlaps"):
        scenario(faults=[{"surface": "rudder"}, {"surface": "rudder"}])


def test_forty_overlaps_fit_on_a_screen(refused):
    # they are one error of the schema, with a problem for each overlap
    faults = "faults:\n" + "".join("  - {surface: rudder, effectiveness: 0.5}\n" for _ in range(41))
    lines = str(refused(faults)).split("\n")
    assert len(lines) <= 40
    assert any("32 more errors" in line for line in lines)


def test_a_section_with_odd_keys_is_shown_on_one_line(refused):
    message = str(refused('reference: {phi_deg: {"a\\nb\\e[31m": 1}}\n'))
    assert all(line.isprintable() for line in message.split("\n"))
