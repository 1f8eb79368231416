"""Limits of a controller: the search, the quantities, what was flown against the linear loop, and the command."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from uavftc.cli.app import umbrella
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.margin.limits import find_limits, targets_of
from uavftc.jobs.margin.linear import linear_margins
from uavftc.jobs.margin.quantities import chosen
from uavftc.jobs.margin.search import Judged, find, scan
from uavftc.scenario.changed import changed, remade
from uavftc.scenario.load import load_scenario


def judge(edge, above=True):
    return lambda value: Judged(edge - value, (value < edge) == above, "calm")


@pytest.mark.parametrize("edge", [0.003, 0.2, 0.47, 0.999])
def test_the_bracket_holds_the_edge_and_is_one_percent_wide(edge):
    limit = find(judge(edge), scan(0.0, 1.0))
    assert limit.held < edge <= limit.broke
    assert limit.broke - limit.held <= 0.01 * limit.broke
    assert (limit.criterion, limit.monotone) == ("calm", True)
    assert set(limit.flown) >= set(scan(0.0, 1.0))


def test_a_falling_range_and_one_over_decades_are_bracketed_too():
    limit = find(judge(3.7, above=False), scan(1000.0, 1.0))
    assert limit.broke < 3.7 <= limit.held
    assert limit.held - limit.broke <= 0.01 * limit.held


def test_what_survives_everywhere_or_nowhere_has_no_limit():
    everywhere, nowhere = find(judge(2.0), scan(0.0, 1.0)), find(judge(-1.0), scan(0.0, 1.0))
    assert (everywhere.held, everywhere.broke, everywhere.criterion) == (1.0, None, None)
    assert (nowhere.held, nowhere.broke, nowhere.criterion) == (None, 0.0, "calm")


def test_what_survives_again_is_said_not_to_be_monotone():
    limit = find(lambda v: Judged(0.0, not 0.3 < v < 0.6, "calm"), scan(0.0, 1.0))
    assert limit.held <= 0.3 < limit.broke
    assert not limit.monotone


def limits(names, controllers, *overrides, scenario="scenario2", plant="analytic"):
    scenarios = {
        name: load_scenario(scenario, plant=plant, controller=name, overrides=overrides) for name in controllers
    }
    found = find_limits(scenarios, chosen(names, [], []))
    return {(one.controller, one.quantity.name): one for one in found}


def test_the_delay_limit_of_l1_is_20_to_35_ms_and_that_of_mrac_below_10_ms():
    found = limits(["delay"], ["nndondi-l1", "nndondi-mrac"])
    l1, mrac = found["nndondi-l1", "delay"].limit, found["nndondi-mrac", "delay"].limit
    assert 0.020 < l1.held < l1.broke < 0.035
    assert mrac.broke < 0.010
    assert (l1.criterion, mrac.criterion) == ("calm", "calm")


@pytest.mark.parametrize(
    ("controller", "overrides"),
    [
        ("pid", ("saturation=null",)),  # its limits would hold an unstable loop in a limit cycle that breaks nothing
        ("lqi", ()),  # its weights follow from the limits
    ],
)
def test_delay_and_gain_limits_are_within_ten_percent_of_the_linear_margins(controller, overrides):
    found = limits(["delay", "gain"], [controller], *overrides)
    for name in ("delay", "gain"):
        one = found[controller, name]
        assert one.limit.held == pytest.approx(one.linear, rel=0.1)


@pytest.mark.slow
def test_on_jsbsim_the_delay_limit_is_within_ten_percent_of_that_of_its_linear_model():
    one = limits(["delay"], ["pid"], "saturation=null", plant="jsbsim")["pid", "delay"]
    assert one.limit.held == pytest.approx(one.linear, rel=0.1)


def test_a_law_that_is_not_linear_has_no_linear_margins():
    assert linear_margins(load_scenario("scenario2")) == {}


def flown_with(name, value, scenario):
    (quantity,) = chosen([name], [], targets_of(build_flight(scenario)))
    return remade(scenario, lambda document: quantity.put(document, value), name)


def test_effectiveness_and_bias_are_on_top_of_the_faults_of_the_scenario_and_all_the_time():
    scenario = load_scenario("scenario3")
    records, _ = fly_to_memory(build_flight(flown_with("effectiveness:aileron", 0.5, scenario)))
    before, _ = fly_to_memory(build_flight(scenario))
    np.testing.assert_array_equal(records["effectiveness"][:, 0], 0.5 * before["effectiveness"][:, 0])
    np.testing.assert_array_equal(records["effectiveness"][:, 1:], before["effectiveness"][:, 1:])
    np.testing.assert_allclose(records["bias"][:, 0], before["bias"][:, 0], atol=1e-15)
    records, _ = fly_to_memory(build_flight(flown_with("bias:aileron", 2.0, scenario)))
    np.testing.assert_allclose(records["bias"][:, 0], before["bias"][:, 0] + np.radians(2.0), atol=1e-15)
    np.testing.assert_array_equal(records["effectiveness"][:, 0], before["effectiveness"][:, 0])


def test_the_gain_of_the_loop_is_on_every_command():
    scenario = flown_with("gain", 1.5, load_scenario("scenario1", overrides=["saturation=null"]))
    records, _ = fly_to_memory(build_flight(scenario))
    np.testing.assert_allclose(records["u2"][:100], 1.5 * records["v2"][:100], rtol=1e-12)


def test_a_scenario_is_changed_by_values_with_the_messages_of_a_file():
    scenario = load_scenario("scenario3")
    assert changed(scenario, {"faults[0].effectiveness": 0.2}).faults[0].effectiveness.constant == 0.2
    assert changed(scenario, {}) == scenario
    with pytest.raises(InputError, match="effectiveness"):
        changed(scenario, {"faults[0].effectiveness": -1.0})
    with pytest.raises(InputError, match="index 9"):
        changed(scenario, {"faults[9].effectiveness": 1.0})


def run(*arguments):
    return CliRunner().invoke(umbrella, ["margin", *arguments])


def test_the_command_prints_json_of_the_contract_and_writes_its_folder(tmp_path):
    done = run(
        "scenario1", "--plant", "analytic", "--quantity", "delay", "--over", "reference.phi_deg=1..60",
        "--out", str(tmp_path / "m"), "--json", "--quiet", "--set", "duration_s=8",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    entries = json.loads(done.stdout)
    assert [entry["quantity"] for entry in entries] == ["delay", "reference.phi_deg"]
    for entry in entries:
        assert set(entry) >= {"controller", "quantity", "value", "unit", "criterion", "bracket", "flights"}
        assert entry["bracket"][0] == entry["value"]
    assert entries[0]["unit"] == "s"
    assert entries[1]["unit"] == "deg"
    assert json.loads((tmp_path / "m" / "margin.json").read_text()) == entries
    assert (tmp_path / "m" / "figures" / "margin.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--quantity", "dely"], "one of delay"),
        (["--quantity", "effectiveness:flap"], "one of"),
        (["--over", "reference.phi_deg"], "KEY=LOW..HIGH"),
        (["--over", "reference.phi_deg=a..b"], "KEY=LOW..HIGH"),
        (["--over", "reference.phi_deg=1..1"], "different numbers"),
        (["--over", "reference.phi_degg=1..2"], "phi_degg"),
        (["--over", "faults[7].effectiveness=1..0"], "index 7"),
        (["--set", "requirements=[]"], "at least one requirement"),
        (["--controllers", "pidd"], "pid"),
    ],
)
def test_wrong_input_is_refused_and_nothing_is_written(tmp_path, arguments, words):
    done = run("scenario1", *arguments, "--out", str(tmp_path / "m"))
    assert done.exit_code == 2, done.output
    assert words in done.output
    assert list(tmp_path.iterdir()) == []
