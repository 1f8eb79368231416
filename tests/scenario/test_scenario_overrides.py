"""--set, --plant and --controller: what they change, and how they refuse."""

from __future__ import annotations

import pytest

from uavftc.errors import printable
from uavftc.scenario.load import controller_name, load_scenario

NAMES = ["nndondi-l1", "ndi-l1", "nndondi-mrac", "ndi-mrac"]


def flown(*overrides, source="scenario3", **options):
    return load_scenario(source, overrides=overrides, **options)


def test_values_are_yaml():
    assert flown("saturation=null").saturation is None
    assert flown("saturation=").saturation is None
    assert flown("sensors.gyro_bias_degps=[0.3, 0.3, 0.3]").sensors.gyro_bias_degps == (0.3, 0.3, 0.3)
    assert flown("reference.phi_deg=2*sin(t)").reference.phi_deg.written == "2*sin(t)"
    assert flown("description='a: b = c'").description == "a: b = c"
    assert flown("controller.inner.adaptation_gain=1e4").controller.inner.adaptation_gain == 1e4
    assert flown("faults=[]").faults == ()


@pytest.mark.parametrize("key", ["faults[4].effectiveness", "faults.4.effectiveness"])
def test_entries_of_a_list(key):
    faults = flown(f"{key}=0.2").faults
    assert [f.effectiveness.written for f in faults] == [0.5, 0.7, 0.8, 0.3, 0.2]


def test_entries_of_a_list_within_a_list():
    bias = flown("sensors.gyro_bias_degps=[0, 0, 0]", "sensors.gyro_bias_degps[1]=2").sensors.gyro_bias_degps
    assert bias == (0, 2, 0)


def test_missing_sections_are_made():
    assert flown("envelope.bank_deg=60").envelope.bank_deg == 60
    assert flown("controller.outer.rbf.width=0.5").controller.outer.rbf.width == 0.5
    limits = flown("saturation.min_rad=-0.1", "saturation.max_rad=0.1", source="scenario1-unsaturated").saturation
    assert (limits.min_rad, limits.max_rad) == (-0.1, 0.1)


def test_a_loop_without_its_kind_keeps_the_default_kind(load):
    s = load(overrides=["controller.inner.filter_bandwidth=30", "controller.outer.sigma=1"])
    assert controller_name(s) == "nndondi-l1"
    assert (s.controller.inner.filter_bandwidth, s.controller.outer.sigma) == (30, (1, 1, 1))


def test_the_last_override_holds_and_overrides_beat_options():
    assert flown("seed=1", "seed=2").seed == 2
    assert flown("plant=jsbsim", plant="analytic").plant == "jsbsim"


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("seed", "--set KEY=VALUE"),
        ("=1", "a dotted key"),
        ("a..b=1", "a dotted key"),
        ("faults[-1].bias_deg=1", "a dotted key"),
        ("faults[5].bias_deg=1", "index 5; faults has 5 entries"),
        ("faults[99999999999999999999].bias_deg=1", "faults has 5 entries"),
        ("faults.first.bias_deg=1", "faults is a list"),
        ("reference[0]=1", "reference holds no list"),
        ("controller.outer.bandwidth[0]=1", "set the whole list: --set 'controller.outer.bandwidth=[...]'"),
        ("duration_s.x=1", "duration_s, which is neither"),
        ("reference.phi_deg=[1", "--set reference.phi_deg=[1\n"),
        ("reference.phi_deg=a: b: c", "one YAML document"),
        ("reference.phi_deg=!!python/name:os.system", "the tag"),
        ("reference.phi_deg=__import__('os')", "key reference.phi_deg"),
        ("faults[0].effectiveness=-1", "key faults[0].effectiveness"),
        ("saturation={min_rad: 1, max_rad: 2}", "key saturation.min_rad"),
        ("saturation={max_rad: 2}", "key saturation.min_rad"),
        ("foo.bar=1", "unknown key 'foo'"),
        ("x=\udcff", "special characters"),
    ],
)
def test_refusals_name_the_option(refused, override, said):
    scenario3 = "saturation: null\nreference: {}\nfaults:\n" + "".join(
        f"  - {{surface: rudder, start_s: {i}, end_s: {i + 1}}}\n" for i in range(5)
    )
    message = str(refused(scenario3, overrides=[override]))
    assert message.startswith(f"--set {printable(override)}"[:40])
    assert said in message


def test_an_error_next_to_an_override_keeps_its_line(refused):
    message = str(refused("reference:\n  phi_deg: x\n  psi_deg: 1\n", overrides=["reference.psi_deg=2"]))
    assert "line 4, key reference.phi_deg" in message


def test_plant_is_checked_like_the_file(refused):
    assert str(refused(plant="x-plane")).startswith("--plant x-plane, key plant")
    wind = "disturbances: [{kind: wind, north_mps: 1}]"
    assert "line 3, key disturbances[0].kind" in str(refused(wind, plant="analytic"))


@pytest.mark.parametrize("name", NAMES)
def test_controller_sets_both_kinds(name):
    s = flown(controller=name)
    assert controller_name(s) == name
    assert s.model_copy(update={"controller": None}) == flown().model_copy(update={"controller": None})


def test_controller_keeps_what_the_new_kinds_know_and_drops_the_rest(load):
    text = """
        controller:
          outer: {kind: nndo-ndi, bandwidth: 0.7, sigma: 2}
          inner: {kind: l1, adaptation_gain: 1.0e4, filter_bandwidth: 30}
          rate_hz: 100
        """
    c = load(text, controller="ndi-mrac").controller
    assert c.outer.model_dump() == {"kind": "ndi", "bandwidth": (0.7, 0.7, 0.7)}
    assert (c.inner.adaptation_gain, c.rate_hz) == (1e4, 100)
    assert load(text, controller="nndondi-l1") == load(text)


def test_controller_does_not_hide_a_misspelt_key(refused):
    message = str(refused("controller: {inner: {kind: l1, filter_bandwith: 3}}", controller="ndi-mrac"))
    assert "unknown key 'filter_bandwith'" in message


def test_controller_on_a_file_without_the_section(load):
    assert controller_name(load(controller="ndi-mrac")) == "ndi-mrac"
    assert controller_name(load("controller:\n  outer:\n", controller="ndi-l1")) == "ndi-l1"


def test_unknown_controllers_are_reported_with_the_known(refused):
    message = str(refused(controller="pdi"))
    assert message.startswith("--controller pdi")
    for name in NAMES:
        assert name in message


@pytest.mark.parametrize(("section", "key"), [("5", "controller"), ("{inner: 5}", "controller.inner")])
def test_a_broken_controller_section_is_reported_by_the_schema(refused, section, key):
    assert f"line 3, key {key}\n" in str(refused(f"controller: {section}", controller="ndi-l1"))


@pytest.mark.parametrize("override", ["\x1b[31m=1", "name=\x00", "faults[99].x=\ufeff", "\u202ename=x"])
def test_what_would_steer_a_terminal_is_shown_as_its_escape(refused, override):
    message = str(refused("", overrides=[override]))
    assert all(line.isprintable() for line in message.split("\n"))
    assert repr(override)[1:-1] in message
