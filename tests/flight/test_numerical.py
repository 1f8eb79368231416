"""The outcome `numerical`: a flight that is lost to its plant step, told from one that is lost."""

import json

import numpy as np
import pytest

from stiff import stiff
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.flight import condition, numerical
from uavftc.flight.build import build_flight, make_plant
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.fly import fly_mission
from uavftc.plants.interface import Timing
from uavftc.scenario.load import load_scenario

NO_AILERON = "faults=[{surface: aileron, effectiveness: 0, bias_deg: 10}]"


@pytest.fixture(scope="module")
def fast_roll(tmp_path_factory):
    """An aircraft whose roll mode, 324 1/s, is unstable at 5 ms and at 2.5 ms."""
    return str(stiff(tmp_path_factory.mktemp("aircraft") / "stiff", 20.0))


def flown(scenario, *overrides, aircraft="hale", **given):
    flight = build_flight(load_scenario(scenario, overrides=overrides, aircraft=aircraft, **given))
    return flight, *fly_to_memory(flight)


def test_finer_steps_are_taken_and_fly(fast_roll):
    flight, rows, outcome = flown("scenario1", aircraft=fast_roll)
    assert (flight.given.plant_step, outcome.completed, outcome.numerical) == (1e-3, True, False)
    assert abs(np.degrees(rows["x1"][-1, 0]) - 5.0) < 0.1


@pytest.mark.parametrize("controller", ["ndi-l1", "nndondi-mrac", "pid"])
def test_the_step_is_the_same_for_every_controller(fast_roll, controller):
    flight = build_flight(load_scenario("scenario1", aircraft=fast_roll, controller=controller))
    assert flight.given.plant_step == 1e-3


@pytest.mark.parametrize("substeps", [1, 3, 10])
def test_the_scenarios_own_substeps_are_never_changed(fast_roll, substeps):
    scenario = load_scenario("scenario1", aircraft=fast_roll, overrides=[f"simulation.substeps={substeps}"])
    assert build_flight(scenario).given.plant_step == pytest.approx(5e-3 / substeps)


def test_lost_to_its_step(fast_roll, tmp_path):
    scenario = load_scenario("scenario1", aircraft=fast_roll, overrides=["simulation.substeps=1"])
    document, outcome = fly_mission(scenario, tmp_path / "out", figures=False)
    assert not outcome.completed
    assert outcome.numerical
    for part in (
        "numerical: lost at plant steps of 5 ms (departed in roll from ",
        "; ended by attitude outside the envelope: bank",
        "), and not at 2.5 ms and 1.25 ms with the same commands; set simulation.substeps to 5 or more",
    ):
        assert part in outcome.ended_because
    written = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert (written["completed"], written["numerical"]) == (False, True)
    assert written["ended_because"] == outcome.ended_because
    check = written["provenance"]["plant_settings"]["step_check"]
    assert (check["frame_s"], check["passed"]) == (1e-3, True)
    assert [t["frame_s"] for t in check["tried"]] == [5e-3, 2.5e-3, 1e-3]
    assert any("simulation.substeps: 1 makes plant steps of 5 ms, where stiff needs at most 1 ms" in line
               for line in document["warnings"])  # fmt: skip


@pytest.mark.parametrize(("aircraft", "airspeed"), [("hale", 30), ("jsbsim:c172p", 62)])
def test_really_lost(aircraft, airspeed):
    _, rows, outcome = flown("scenario3", NO_AILERON, f"initial.airspeed_mps={airspeed}", aircraft=aircraft)
    assert (outcome.completed, outcome.numerical, outcome.remarks) == (False, False, ())
    assert "; ended by attitude outside the envelope: bank 90" in outcome.ended_because
    assert abs(rows["x1"][-1, 0]) > np.pi / 2.0


def test_really_lost_too_slow():
    # 15.00 m/s at a limit of 15 m/s: at another step it comes a frame later, and is no other flight for that
    _, _, outcome = flown("scenario2", "faults=[{surface: elevator, effectiveness: 0, bias_deg: 4}]")
    assert "; ended by airspeed outside the envelope" in outcome.ended_because
    assert not outcome.numerical


def test_the_commands_of_a_flight_replayed_are_the_flight():
    # at the same step the replay must be the flight to the bit, d2 and wind and all; otherwise it would prove nothing
    flight, rows, _ = flown(
        "scenario3",
        "duration_s=9",
        "initial.airspeed_mps=62",
        "disturbances=[{kind: wind, north_mps: 3}, {kind: angular-acceleration, p_degps2: 'sin(t)'}]",
        aircraft="jsbsim:c172p",
    )
    plant = make_plant(flight.scenario, flight.aircraft, flight.model, Timing(5e-3, 1), flight.inputs, flight.layout)
    again = as_records(given := empty_rows(len(rows), flight.shape), flight.shape)
    for name in ("t", "d2", "wind_n"):
        again[name] = rows[name]
    again["effectors"]["deflection"] = rows["effectors"]["deflection"]
    plant.run(Program([*plant.before(), *plant.given()], plant.after()), given, 0, len(rows))
    for name in ("x1", "x2", "airspeed", "alpha", "beta", "throttle"):
        np.testing.assert_array_equal(again[name], rows[name])


def test_no_step_is_fine_enough(monkeypatch):
    # nothing is flown then, unless the scenario says at which steps
    failed = {"frame_s": 5e-5, "passed": False, "worst": "thrust", "first_difference": 0.2, "second_difference": 0.1,
              "ratio": 0.5, "tried": []}  # fmt: skip
    monkeypatch.setattr(condition, "stepped", lambda _, model: model._replace(step=failed))
    _, rows, outcome = flown("scenario1")
    assert len(rows) == 1
    assert (outcome.completed, outcome.numerical, outcome.ended_at_s) == (False, True, 0.0)
    assert outcome.ended_because.startswith("numerical: the step check passes at no plant step down to")
    assert "thrust differs by 0.2 of its motion from half that step, and that by 0.1 from a quarter" in (
        outcome.ended_because
    )
    _, rows, outcome = flown("scenario1", "simulation.substeps=1")
    assert (len(rows), outcome.completed) == (4001, True)


def test_what_is_too_long_is_said(monkeypatch):
    monkeypatch.setattr(numerical, "MAX_PLANT_STEPS", 100)
    _, _, outcome = flown("scenario3", NO_AILERON)
    assert not outcome.numerical
    (remark,) = outcome.remarks
    assert "too long to be flown again at finer steps (2030 rows)" in remark


def test_a_tape_that_is_full_keeps_nothing(monkeypatch):
    monkeypatch.setattr(numerical, "MAX_ROWS", 1000)
    _, _, outcome = flown("scenario3", NO_AILERON)
    assert not outcome.numerical
    assert len(outcome.remarks) == 1


def test_the_analytic_plant_has_no_replay():
    _, _, outcome = flown("scenario3", NO_AILERON, plant="analytic")
    assert (outcome.completed, outcome.numerical, outcome.remarks) == (False, False, ())
