"""Reading the file: YAML as users write it, places of errors, names of shipped scenarios, paths."""

from __future__ import annotations

import os
import pickle

import pytest
from pydantic import ValidationError

from uavftc.config import shipped as resources
from uavftc.config.document import Document, parse
from uavftc.config.explain import explain
from uavftc.config.values import Model, Positive
from uavftc.errors import CombinedInputError, InputError
from uavftc.scenario import load as module
from uavftc.scenario.checks import warnings
from uavftc.scenario.load import controller_name, load_scenario


@pytest.mark.parametrize("written", ["1e5", "1.0e5", "1E+5", "100000", "+100000.", "1.e5"])
def test_numbers_of_every_spelling_are_numbers(load, written):
    # under YAML 1.1 the first of them would be a text
    assert load(f"controller: {{inner: {{adaptation_gain: {written}}}}}").controller.inner.adaptation_gain == 1e5


def test_yaml_1_2_rules_hold_whatever_the_file_claims(refused):
    old = "%YAML 1.1\n---\nname: a\nduration_s: 1\ndescription: yes\nreference: {phi_deg: 1:30}\n"
    # under YAML 1.1 yes is a boolean and 1:30 is ninety
    assert "the character ':' is not allowed" in str(refused(head=old))


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        (b"", 1, "an empty file"),
        (b"# nothing\n", 1, "an empty file"),
        (b"- a\n", 1, "a list of 1"),
        (b"hello\n", 1, "'hello'"),
        (b"name: a\nname: b\n", 2, "second time; the first is at"),
        (b"name: a\ncontroller:\n  outer: {kind: ndi, kind: ndi}\n", 3, "second time"),
        (b"name: a\n\tduration_s: 1\n", 2, "a tab"),
        (b"name: a\n---\nname: b\n", 2, "a second document"),
        (b"name: 'a\nb: c\n", 3, "begun on line 1"),
        (b"name: [a\n", 2, "','"),
        (b"a: b: c\n", 1, "mapping values are not allowed"),
        (b"name: a\nx: *y\n", 2, "undefined alias 'y'"),
        (b"name: a\nx: &y [*y]\n", 2, "more values"),
        (b"name: a\nx: !!python/object/apply:os.system ['true']\n", 2, "the tag"),
        (b"name: a\nx: !foo 1\n", 2, "the tag"),
        (b"name: a\n? [1]\n: 2\n", 2, "list or map as a key"),
        (b"name: a\nx: \xe9\n", 2, "0xe9, which is not UTF-8"),
        ("name: a\n".encode("utf-16"), 1, "not UTF-8"),
        (b"name: a\nx: \x01\n", 2, "#x0001"),
        (b'name: a\ndescription: "\\ud800"\n', 2, "surrogate"),
    ],
)
def test_what_is_no_scenario_at_all(refused, text, line, said):
    message = str(refused(text))
    assert f"test.yaml, line {line}\n" in message
    assert said in message
    assert "remedy:" in message


@pytest.mark.parametrize("text", ["[" * 50_000, "{a: " * 5_000, "- " * 50_000, "{a: " * 60 + "1" + "}" * 60])
def test_nesting_does_not_exhaust_the_stack(refused, text):
    assert "50 l" in str(refused(text.encode()))


def test_aliases_may_not_grow_without_bound(refused, load):
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 10)]
    assert "aliases" in str(refused("\n".join(lines).encode()))  # 10^10 values if followed
    s = load("faults:\n  - {surface: rudder, bias_deg: &b 2*t}\n  - {surface: aileron, bias_deg: *b}\n")
    assert s.faults[0].bias_deg == s.faults[1].bias_deg


def test_size_is_bounded(refused):
    assert "at most 1000000 bytes" in str(refused(b"#" * 1_000_001))


def test_a_byte_order_mark_and_dos_line_ends_are_no_obstacle(write):
    assert load_scenario(write("\ufeffname: a\r\nduration_s: 1\r\n".encode())).name == "a"


def test_a_folder_and_a_missing_file(tmp_path):
    with pytest.raises(InputError, match="a folder"):
        load_scenario(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        load_scenario(tmp_path / "none.yaml")


@pytest.mark.parametrize("source", ["", "a\0b", "x" * 5000])
def test_names_no_file_can_have(source):
    with pytest.raises(InputError, match="expected: a scenario file, or one of"):
        load_scenario(source)


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="permissions do not bind here")
def test_an_unreadable_file(write):
    path = write()
    path.chmod(0)
    with pytest.raises(InputError, match="cannot be read"):
        load_scenario(path)


def test_a_file_that_fails_while_read(write, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied")

    path = write()
    monkeypatch.setattr(module.Path, "open", fail)
    with pytest.raises(InputError, match="cannot be read: Permission denied"):
        load_scenario(path)


def test_shipped_scenarios_are_found_by_name_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_scenario("scenario3") == load_scenario("scenario3.yaml")
    (tmp_path / "scenario3").mkdir()  # a results folder of that name is not in the way
    assert load_scenario("scenario3").name == "scenario3"
    (tmp_path / "scenario3.yaml").write_text("name: mine\nduration_s: 1\n")  # the user's file is
    assert load_scenario("scenario3.yaml").name == "mine"


def test_a_misspelt_name_gets_a_hint(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"did you mean scenario\d\?"):
        load_scenario("scenrio2")


def test_every_shipped_scenario_loads_and_only_the_literal_rudder_warns():
    lines_of = {name: warnings(load_scenario(name)) for name in resources.scenario_names()}
    assert set(lines_of) >= {"scenario1", "scenario1-unsaturated", "scenario2", "scenario3", "gust"}
    assert {name for name, lines in lines_of.items() if lines} == {"scenario3"}
    for name in lines_of:
        assert load_scenario(name).name == name
        assert controller_name(load_scenario(name)) == "nndondi-l1"


def test_the_papers_scenario_3():
    s = load_scenario("scenario3")
    assert (s.duration_s, s.aircraft, s.plant) == (20.0, "hale", "jsbsim")
    assert s.limits_rad().tolist() == [[-0.05, 0.1]] * 3
    assert [r.written for r in (s.reference.phi_deg, s.reference.theta_deg, s.reference.psi_deg)] == [5.0] * 3
    assert [(f.surface, f.start_s, f.end_s, f.effectiveness.written, f.bias_deg.written) for f in s.faults] == [
        ("aileron", 0, 8, 0.5, 0),
        ("elevator", 0, 8, 0.7, 0),
        ("aileron", 8, 12, 0.8, "0.1 + 0.5*sin(t)"),
        ("elevator", 8, 12, 0.3, "0.5 - 0.1*t"),
        ("rudder", 8, 12, "0.2*t", "3*cos(0.1*t)"),
    ]
    assert s.disturbances == load_scenario("scenario2").disturbances
    assert [(d.start_s, d.end_s) for d in s.disturbances] == [(0, 10), (10, 13), (13, None)]


def test_unsaturated_differs_from_scenario_1_in_the_limits_alone():
    saturated, free = load_scenario("scenario1"), load_scenario("scenario1-unsaturated")
    plain = {"name": "x", "description": "", "saturation": None}
    assert saturated.model_copy(update=plain) == free.model_copy(update=plain)
    assert free.saturation is None


def test_the_gust_ends_within_the_flight():
    (gust,) = load_scenario("gust").disturbances
    assert (gust.start_s, gust.end_s, gust.down_mps, gust.east_mps) == (10, 12.4, -15, 3)


def test_aircraft_paths_start_at_the_file_and_options_at_the_working_folder(write, tmp_path, monkeypatch):
    by_file, by_folder = tmp_path / "mine", tmp_path / "elsewhere" / "mine"
    for folder in (by_file, by_folder):
        folder.mkdir(parents=True)
    monkeypatch.chdir(by_folder.parent)
    path = write("aircraft: ./mine\n")
    assert load_scenario(path).aircraft == str(by_file)
    assert load_scenario(path, aircraft="./mine").aircraft == str(by_folder)
    assert load_scenario(path, overrides=["aircraft=./mine"]).aircraft == str(by_folder)
    assert load_scenario(path, aircraft="mine").aircraft == str(by_folder)  # an existing folder
    assert load_scenario(path, aircraft=str(by_file)).aircraft == str(by_file)


def test_aircraft_names_stay_names(write, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hale").mkdir()  # a shipped name means the shipped aircraft
    for name in ("hale", "jsbsim:c172p", "unheard-of"):
        assert load_scenario(write(f"aircraft: {name}\n")).aircraft == name


def test_a_path_that_leads_nowhere(refused):
    message = str(refused("seed: 1\naircraft: ../none\n"))
    assert "line 4, key aircraft" in message
    assert "shipped: hale" in message


def test_the_same_words_for_files_of_another_schema():
    class Bolt(Model):
        width_m: Positive

    document = Document({"width": 1}, "bolt.yaml", {("width",): "bolt.yaml, line 7"})
    with pytest.raises(ValidationError) as error:
        Bolt.model_validate(document.data)
    texts = {str(e) for e in explain(error.value, document, Bolt)}
    assert any("bolt.yaml, line 7, key width" in t and "did you mean width_m?" in t for t in texts)


def test_errors_survive_the_way_back_from_a_worker_process(refused):
    one, many = refused("foo: 1"), refused("foo: 1\nbar: 2")
    assert isinstance(many, CombinedInputError)
    for error in (one, many):
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error)
        assert str(again) == str(error)


def test_nesting_is_refused_at_its_fifty_first_level_with_its_line(refused):
    # the parser's work grows with the square of the depth: it is stopped there, not at the end of its stack
    text = "name: x\nduration_s: 1\ndescription: " + "[\n" * 20_000
    message = str(refused(text.encode()))
    assert "test.yaml, line 53\n" in message  # 50 levels below the third line, which is the first of them
    assert "50 levels deep" in message
    parse("[" * 50 + "]" * 50, "a file")


def test_more_values_than_a_scenario_needs_are_refused(refused):
    message = str(refused(b"description: [" + b"0, " * 30_000 + b"0]\n"))
    assert "at most 20000 values" in message
