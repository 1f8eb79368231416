"""The as-flown text: reading it gives the same scenario, bit for bit."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from uavftc.config import shipped as resources
from uavftc.scenario.load import load_scenario, scenario_text
from uavftc.scenario.schema import Scenario


def again(scenario, folder):
    path = folder / "as-flown.yaml"
    path.write_text(scenario_text(scenario), encoding="utf-8")
    return load_scenario(path)


@pytest.mark.parametrize("name", resources.scenario_names())
@pytest.mark.parametrize("controller", ["nndondi-l1", "ndi-mrac"])
def test_shipped_scenarios_come_back(name, controller, tmp_path):
    scenario = load_scenario(name, controller=controller)
    assert again(scenario, tmp_path) == scenario
    assert scenario_text(again(scenario, tmp_path)) == scenario_text(scenario)


def test_every_default_is_written_out():
    text = scenario_text(Scenario(name="a", duration_s=1.0))
    keys = {*Scenario.model_fields, "kind", "A_m", "B_m", "offset_bound", "centres", "gyro_bias_degps", "bank_deg"}
    for key in keys | {"airspeed_mps", "substeps", "delay_s"}:
        assert f"{key}:" in text
    assert "saturation: null" in text


def test_the_text_reads_like_a_scenario_a_person_wrote():
    lines = scenario_text(load_scenario("scenario3")).splitlines()
    assert lines[0] == "name: scenario3"
    assert "saturation: {min_rad: -0.05, max_rad: 0.1}" in lines
    rudder = '  - {surface: rudder, start_s: 8.0, end_s: 12.0, effectiveness: "0.2*t", bias_deg: "3*cos(0.1*t)"}'
    assert rudder in lines
    assert max(map(len, lines)) <= 120


numbers = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(1e-300, 1e300)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    description=st.text(st.characters(exclude_categories=["Cs"]), max_size=40),
    reference=st.one_of(numbers, st.sampled_from(["t", "2*sin(t)", " 1\n+ t", "5"])),
    gains=st.tuples(positive, positive, positive),
    bias=st.tuples(numbers, numbers, numbers),
    limit=positive,
)
def test_any_scenario_comes_back_bit_for_bit(tmp_path, *, description, reference, gains, bias, limit):
    scenario = Scenario.model_validate(
        {
            "name": "a",
            "duration_s": 1,
            "description": description,
            "seed": 2**63 - 1,
            "reference": {"psi_deg": reference},
            "controller": {"outer": {"bandwidth": gains}},
            "sensors": {"gyro_bias_degps": bias},
            "saturation": {"rudder": {"min_rad": -limit, "max_rad": limit / 3}},
        }
    )
    back = again(scenario, tmp_path)
    assert back == scenario
    assert back.model_dump_json() == scenario.model_dump_json()  # also distinguishes -0.0 from 0.0


@pytest.mark.parametrize(
    "text", ["null", "true", "No", "~", "1e5", "- a", "a: b", "a #b", " a", "a ", "", "'", "😀", "\x85"]
)
def test_texts_that_yaml_would_take_for_something_else(text, tmp_path):
    scenario = Scenario(name="a", duration_s=1.0, description=text)
    assert again(scenario, tmp_path).description == text


@pytest.mark.parametrize("name", ["null", "true", "1", "1e5", "0x1", "1.5", "A", "No"])
def test_names_that_yaml_would_take_for_something_else(name, tmp_path):
    assert again(Scenario(name=name, duration_s=1.0), tmp_path).name == name
