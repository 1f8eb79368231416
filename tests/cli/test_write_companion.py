"""`uavftc design FOLDER --write-companion`: what was found, as a file that gives the same aircraft."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import v_tail
from uavftc.aircraft.definition import load_aircraft, stock_dir
from uavftc.aircraft.effectors import mixing_of
from uavftc.analysis.metrics import metrics_of
from uavftc.cli.app import umbrella
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.design import companion
from uavftc.jobs.design.trimmed import design_model
from uavftc.plants.jsbsim.rig import arrange
from uavftc.scenario.load import load_scenario


def run(*arguments: object) -> Result:
    return CliRunner().invoke(umbrella, ["design", *map(str, arguments)])


def designed(folder, *options: str) -> dict:
    done = run(folder, "--json", *options)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def twice(tmp_path_factory):
    """Return the folder, the design without the companion file, and the design with it."""
    folder = v_tail.write(tmp_path_factory.mktemp("aircraft"))
    without = designed(folder)
    done = run(folder, "--write-companion")
    assert done.exit_code == 0, done.output
    assert f"companion: {folder / 'uavftc.yaml'}" in done.stderr
    return folder, without, designed(folder)


def test_the_written_file_gives_the_same_design(twice):
    _, without, found = twice
    assert found["trim"]["airspeed_mps"] == without["trim"]["airspeed_mps"]
    assert found["verdict"] == without["verdict"] == "flyable"
    for key in ("A_full", "B", "limits_rad", "K"):
        scale = np.max(np.abs(without[key]))
        np.testing.assert_allclose(found[key], without[key], rtol=0.0, atol=1e-9 * scale, err_msg=key)
    assert found["gangs"] == without["gangs"]
    assert [e["command"] for e in found["effectors"]] == [e["command"] for e in without["effectors"]]
    assert found["propulsion"] == without["propulsion"]


def test_it_says_what_was_found(twice):
    folder, _, _ = twice
    aircraft = load_aircraft(str(folder))
    assert aircraft.strict  # nothing was wrong with its files
    assert list(aircraft.named_effectors()) == list(v_tail.EFFECTORS)
    assert aircraft.engines() == {"engine_1": "fcs/throttle-cmd-norm[0]"}
    assert aircraft.gangs["rudder"] == {"tail_l": -1.0, "tail_r": 1.0}
    text = aircraft.companion.read_text(encoding="utf-8")
    assert "servo: lag 40 rad/s, delay 20 ms, backlash 1 deg" in " ".join(text.replace("#", "").split())
    assert "stops -28.65 and 28.65 deg" in text  # 0.5 rad
    assert max(map(len, text.splitlines())) <= 120


def test_it_flies(twice):
    folder, _, _ = twice
    flight = build_flight(load_scenario("scenario1", aircraft=str(folder), overrides=["saturation=null"]))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed, outcome.ended_because
    # half a degree either way is the backlash of one surface; the loop brings the attitude well inside it
    assert all(axis["steady_state_error_deg"] < 0.5 for axis in metrics_of(records).values())


def test_a_file_that_is_there_stays(twice):
    folder, _, _ = twice
    before = (folder / "uavftc.yaml").read_bytes()
    done = run(folder, "--write-companion")
    assert done.exit_code == 2
    assert "is there already" in done.stderr
    assert (folder / "uavftc.yaml").read_bytes() == before


def test_jsbsims_own_aircraft_are_to_be_copied():
    done = run("jsbsim:c172p", "--write-companion")
    assert done.exit_code == 2
    assert done.stdout == ""
    assert "copy" in done.stderr
    assert not (stock_dir() / "c172p" / "uavftc.yaml").exists()


def test_one_surface_an_axis_is_written_short_and_is_the_same_to_the_bit(tmp_path):
    # JSBSim's own trim is tried first with the file and without, so that the same steps are taken.
    folder, stock = tmp_path / "trainer", stock_dir()
    (folder / "engine").mkdir(parents=True)
    shutil.copy(stock / "c172p" / "c172p.xml", folder / "trainer.xml")
    for name in ("eng_io320.xml", "prop_75in2f.xml"):
        shutil.copy(stock.parent / "engine" / name, folder / "engine")
    scenario = load_scenario("scenario1", aircraft=str(folder), overrides=["initial.airspeed_mps=62"])
    written = companion.write(scenario, load_aircraft(str(folder)))
    assert (written.model, written.limits) == (0.0, 0.0)
    aircraft = load_aircraft(str(folder))
    assert not aircraft.effectors
    assert aircraft.surfaces.elevator.command == "fcs/elevator-cmd-norm"
    assert aircraft.throttle is not None
    assert aircraft.initial is not None
    assert aircraft.initial.airspeed_mps == 62.0


def test_what_strict_would_refuse_is_allowed_with_the_reason(tmp_path):
    channel = "<channel name='x'><summer name='fcs/x'><input>/controls/made/elsewhere</input></summer></channel>"
    folder = v_tail.write(tmp_path, "flightgear", extra=channel)
    done = run(folder, "--write-companion", "--airspeed-mps", "20")
    assert done.exit_code == 0, done.output
    assert load_aircraft(str(folder)).warnings == "allow"
    *_, reason, last = (folder / "uavftc.yaml").read_text(encoding="utf-8").splitlines()
    assert "controls/made/elsewhere" in reason
    assert last == "warnings: allow"


def test_nothing_is_left_where_the_file_cannot_be_read_back(twice, tmp_path, monkeypatch):
    folder = tmp_path / "vtail"
    shutil.copytree(twice[0], folder)
    (folder / "uavftc.yaml").unlink()
    scenario = load_scenario("scenario1", aircraft=str(folder), overrides=["initial.airspeed_mps=20"])

    def refused(*_):
        raise InputError("aircraft", found="a crash", expected="none", remedy="none")

    monkeypatch.setattr(companion, "trimmed_model", refused)
    with pytest.raises(InputError):
        companion.write(scenario, load_aircraft(str(folder)))
    assert sorted(p.name for p in folder.iterdir()) == ["engine", "vtail.xml"]


def test_weights_that_are_no_whole_numbers_are_read_back_to_the_bit(twice, tmp_path):
    folder = tmp_path / "vtail"
    shutil.copytree(twice[0], folder)
    aircraft = load_aircraft(str(folder))
    scenario = load_scenario("scenario1", aircraft=str(folder))
    model = design_model(scenario, aircraft)
    mixing = np.random.default_rng(1).normal(size=(4, 3))
    mixing[0, 1] = 1e-17
    text = companion.text(aircraft, model._replace(mixing=mixing.tolist()), [], [])
    aircraft.companion.write_text(text, encoding="utf-8")
    gangs = load_aircraft(str(folder)).gangs
    np.testing.assert_array_equal(mixing_of(model.names, gangs), mixing)
    # and such weights are used as they are written, where those that were found are found anew at each trim
    used, _ = arrange(model.names, np.ones((6, 4)), np.ones(4), gangs)
    np.testing.assert_array_equal(used, mixing)


def test_names_that_yaml_takes_for_something_else_are_quoted(tmp_path):
    folder = v_tail.write(tmp_path, "737")
    scenario = load_scenario("scenario1", aircraft=str(folder), overrides=["initial.airspeed_mps=20"])
    companion.write(scenario, load_aircraft(str(folder)))
    assert load_aircraft(str(folder)).name == "737"


def test_engines_that_give_no_thrust_are_said(twice, tmp_path):
    folder = tmp_path / "vtail"
    shutil.copytree(twice[0], folder)
    aircraft = load_aircraft(str(folder))
    model = design_model(load_scenario("scenario1", aircraft=str(folder)), aircraft)
    text = companion.text(aircraft, model._replace(engines=0), [], [])
    assert "No throttle moves the thrust of its engines" in text
    assert "throttle:" not in text
