"""The controller section with a kind: where a module is looked for, what options may hold, and how it is written."""

from __future__ import annotations

import math

import pytest

from uavftc.errors import InputError
from uavftc.scenario.controllers import Controller, CustomController
from uavftc.scenario.load import controller_name, load_scenario, scenario_text
from uavftc.scenario.overrides import custom_name

MODULE = "def create(design, h, options):\n    return lambda t, x1_c, x1, x2: (0, 0, 0)\n"
OPTIONS = """
controller:
  kind: pid
  rate_hz: 100
  options:
    z: 1
    kind: not first
    "a key: with, {signs}": [1, {b: 2, surface: x}, [3.5e-7, -1.0e+22]]
    "yes": [true, false, null, "true", "5", "", "line\\nline", ünï]
    "1": {empty: {}, none: []}
    records: [{a: 1}, 5]
    long: [{first: aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa, second: bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb, third: 3}]
"""


def test_a_kind_makes_it_a_custom_controller_and_its_absence_a_pair(load):
    own = load("controller: {kind: pid, options: {rate_bandwidth: 2}, rate_hz: 100, delay_s: 0.01}").controller
    assert own == CustomController(kind="pid", options={"rate_bandwidth": 2}, rate_hz=100.0, delay_s=0.01)
    assert isinstance(load("controller: {rate_hz: 100}").controller, Controller)
    assert load("controller: {kind: pid}").controller.options == {}
    assert load("controller: {kind: pid, options: }").controller.options == {}


def test_options_come_back_as_they_were(load, tmp_path):
    # what the module is given decides the flight: value, type and order
    first = load(OPTIONS)
    (tmp_path / "again.yaml").write_text(scenario_text(first), encoding="utf-8")
    again = load_scenario(tmp_path / "again.yaml")
    assert again == first
    assert repr(again.controller.options) == repr(first.controller.options)
    assert next(iter(first.controller.options)) == "z"
    assert scenario_text(again) == scenario_text(first)


def test_a_file_is_looked_for_next_to_the_scenario_then_here(load, tmp_path, monkeypatch):
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    (here / "one.py").write_text(MODULE)
    assert load("controller: {kind: one.py}").controller.kind == str(here / "one.py")
    (tmp_path / "one.py").write_text(MODULE)
    assert load("controller: {kind: ./one.py}").controller.kind == str(tmp_path / "one.py")
    assert load(controller="./one.py").controller.kind == str(here / "one.py")  # an option counts from here
    assert load(overrides=["controller.kind=./one.py"]).controller.kind == str(here / "one.py")


def test_a_module_is_looked_for_in_the_environment_and_here_and_not_run(load, tmp_path, monkeypatch):
    (tmp_path / "pack_of_mine").mkdir()
    (tmp_path / "pack_of_mine" / "__init__.py").write_text("raise SystemExit('run')\n")
    with pytest.raises(InputError, match="pack_of_mine"):
        load(controller="pack_of_mine.law")
    monkeypatch.chdir(tmp_path)
    assert load(controller="pack_of_mine.law").controller.kind == "pack_of_mine.law"


def test_the_option_takes_the_place_of_the_whole_section_but_for_rate_and_delay(load):
    pair = "controller: {outer: {kind: ndi}, inner: {kind: mrac}, rate_hz: 100, delay_s: 0.01}"
    assert load(pair, controller="pid").controller == CustomController(kind="pid", rate_hz=100.0, delay_s=0.01)
    own = "controller: {kind: pid, options: {rate_bandwidth: 2}, rate_hz: 100}"
    assert load(own, controller="pid").controller.options == {"rate_bandwidth": 2}
    assert load(own, controller="lqi").controller == CustomController(kind="lqi", rate_hz=100.0)
    timed = "controller: {kind: pid, timeout_s: 2}"
    assert load(timed, controller="lqi").controller.timeout_s == 2.0
    assert controller_name(load(timed, controller="ndi-l1")) == "ndi-l1"  # compiled laws are not timed: it is dropped
    back = load(own, controller="ndi-l1")
    assert controller_name(back) == "ndi-l1"
    assert back.controller.rate_hz == 100.0
    options = load(controller="lqi", overrides=["controller.options.attitude_deg=3"]).controller.options
    assert options == {"attitude_deg": 3}


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("pid", "pid"),
        ("my_package.my_module", "my_module"),
        ("/somewhere/my_controller.py", "my_controller"),
        ("/somewhere/v1.2 (new).py", "v1_2__new_"),
        ("/somewhere/pid.py", "own-pid"),  # not the one of this project
        ("mine.lqi", "own-lqi"),
        ("/somewhere/ndi-l1.py", "own-ndi-l1"),
        ("/somewhere/_.py", "own-_"),
        ("/somewhere/" + "x" * 200 + ".py", "x" * 100),
    ],
)
def test_the_short_name_is_fit_for_a_folder_and_nobody_elses(kind, name):
    assert custom_name(kind) == name


WRONG = [
    ("controller: {kind: nowhere.py}", 3, "controller.kind", ["'nowhere.py'", "not a file", "looked in"]),
    ("controller: {kind: pdi}", 3, "controller.kind", ["'pdi'", "did you mean pid?", "ndi-l1", "./my_controller.py"]),
    ("controller: {kind: no-module}", 3, "controller.kind", ["'no-module'", "my_package.my_module"]),
    ("controller: {kind: ndi-l1}", 3, "controller.kind", ["pair of laws", "outer: {kind: ndi} and inner: {kind: l1}"]),
    ("controller: {kind: 5}", 3, "controller.kind", ["5", "a text"]),
    ("controller: {kind: ''}", 3, "controller.kind", ["at least 1"]),
    (
        "controller:\n  kind: pid\n  gains: 1",
        5,
        "controller.gains",
        ["unknown key 'gains'", "kind, options, rate_hz"],
    ),
    ("controller:\n  kind: pid\n  inner: {kind: l1}", 5, "controller.inner", ["takes the place of both loops"]),
    (
        "controller:\n  rate_hz: 100\n  options: {}",
        5,
        "controller.options",
        ["unknown key", "custom controller"],
    ),
    ("controller: {kind: pid, options: 5}", 3, "controller.options", ["5", "section"]),
    ("controller: {kind: pid, options: {a: [.inf]}}", 3, "controller.options.a[0]", ["inf", "finite number"]),
    ("controller: {kind: pid, options: {a: 9223372036854775808}}", 3, "controller.options.a", ["64 bits"]),
    ("controller: {kind: pid, rate_hz: 0}", 3, "controller.rate_hz", ["at least 1"]),
    ("controller: {kind: pid, rate_hz: 0.5}", 3, "controller.rate_hz", ["at least 1"]),
    ("controller: {kind: pid, timeout_s: 0}", 3, "controller.timeout_s", ["at least 0.001"]),
    ("controller: {kind: pid, timeout_s: 1e6}", 3, "controller.timeout_s", ["at most 86400"]),
    ("controller: {timeout_s: 5}", 3, "controller.timeout_s", ["unknown key"]),
    ("controller: {kind: pid, delay_s: -1}", 3, "controller.delay_s", ["at least 0"]),
]


@pytest.mark.parametrize(("text", "line", "key", "words"), WRONG)
def test_what_is_wrong_is_reported_with_its_line_and_nothing_of_the_other_form(refused, text, line, key, words):
    error = refused(text)
    message = str(error)
    assert f"line {line}, key {key}\n" in message
    assert not hasattr(error, "errors")  # one fault, one error
    for word in words:
        assert word in message, message


def test_a_name_given_as_an_option_is_reported_as_one(refused):
    assert str(refused(controller="pdi")).startswith("--controller pdi, key controller.kind")
    assert "looked in" in str(refused(controller="./nowhere.py"))


def test_numbers_that_are_no_numbers_are_refused_in_code_too():
    with pytest.raises(ValueError, match="finite"):
        CustomController(kind="pid", options={"a": {"b": math.nan}})
