"""Flights, comparisons, designs and scenarios as values: `import uavftc`."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uavftc
from flying import flown
from uavftc.core.axes import ALL
from uavftc.scenario.schema import Scenario

SHORT = {"duration_s": 2, "faults": [], "disturbances": []}


@pytest.fixture(scope="module")
def flight() -> uavftc.Flight:
    return uavftc.fly("scenario3", plant="analytic", set=SHORT)


@pytest.fixture(scope="module")
def comparison() -> uavftc.Comparison:
    return uavftc.compare("scenario3", controllers=["nndondi-l1", "pid"], set={**SHORT, "plant": "analytic"})


def test_the_public_names_are_all_that_dir_shows_and_each_is_there() -> None:
    assert set(dir(uavftc)) == set(uavftc.__all__)
    assert {"fly", "compare", "design", "load", "Flight", "load_scenario", "InputError"} <= set(dir(uavftc))
    for name in uavftc.__all__:
        assert getattr(uavftc, name) is not None


def test_importing_costs_nothing_until_a_name_is_used() -> None:
    code = "import sys, uavftc; sys.exit(any(m in sys.modules for m in ('numpy', 'numba', 'pydantic', 'jsbsim')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_flight_has_the_bits_of_the_same_flight_by_its_parts() -> None:
    _, records, _ = flown("scenario1", "analytic")
    assert np.array_equal(uavftc.fly("scenario1", plant="analytic")["phi_rad"], records["x1"][:, 0])


def test_values_are_set_by_key_and_reach_the_flight() -> None:
    changed = uavftc.fly("scenario1", plant="analytic", set={"reference.phi_deg": np.float64(2), "duration_s": 1})
    assert changed.scenario.duration_s == 1.0
    assert np.degrees(changed["phi_ref_rad"][-1]) == pytest.approx(2.0, abs=1e-12)


def test_metrics_are_items_and_attributes(flight: uavftc.Flight) -> None:
    pitch = flight.metrics["pitch"]
    t, error = flight["time_s"], np.abs(flight["theta_ref_rad"] - flight["theta_rad"])
    assert pitch.iae == pitch["iae"] == pytest.approx(np.trapezoid(error, t), rel=1e-9)
    with pytest.raises(AttributeError, match="no metric aie"):
        _ = pitch.aie


def test_a_column_that_is_not_there_is_refused_with_the_nearest(flight: uavftc.Flight) -> None:
    with pytest.raises(KeyError, match="did you mean phi_rad"):
        _ = flight["ph_rad"]


def test_a_saved_flight_is_loaded_as_it_was(flight: uavftc.Flight, tmp_path: Path) -> None:
    again = uavftc.load(flight.save(tmp_path / "mine", figures=False))
    assert isinstance(again, uavftc.Flight)
    assert again.summary == flight.summary
    assert again.scenario == flight.scenario
    assert list(again.history) == list(flight.history)
    assert all(np.array_equal(again[name], flight[name], equal_nan=True) for name in flight.history)


def test_a_saved_flight_is_the_folder_that_the_command_writes(tmp_path: Path) -> None:
    options = ["--plant", "analytic", "--set", "duration_s=2", "--no-plots", "--quiet", "--out", str(tmp_path / "a")]
    subprocess.run([sys.executable, "-m", "uavftc", "fly", "scenario1", *options], check=True)
    uavftc.fly("scenario1", plant="analytic", set={"duration_s": 2}).save(tmp_path / "b", figures=False)
    for name in ("history.parquet", "scenario.yaml"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_flight_and_a_scenario_can_be_pickled(flight: uavftc.Flight) -> None:
    again = pickle.loads(pickle.dumps(flight))
    assert again.summary == flight.summary
    assert np.array_equal(again["q_radps"], flight["q_radps"])
    assert pickle.loads(pickle.dumps(flight.scenario)) == flight.scenario


def test_a_flight_is_flown_anew_each_time(flight: uavftc.Flight) -> None:
    again = uavftc.fly(flight.scenario)
    assert all(np.array_equal(again[name], flight[name], equal_nan=True) for name in flight.history)


def gains(options: dict[str, Any]) -> Any:
    def step(t: float, x1_c: np.ndarray, x1: np.ndarray, x2: np.ndarray) -> np.ndarray:
        return options.get("k", 0.4) * (0.5 * (x1_c - x1) - x2)

    return step


def test_a_function_is_a_controller_and_so_is_one_that_makes_it() -> None:
    def create(design: Any, h: float, options: dict[str, Any]) -> Any:
        assert design.axes == ALL
        return gains(options)

    class Regulator:
        def __init__(self, design: Any, h: float, options: dict[str, Any]) -> None:
            self._step = gains(options)

        def __call__(self, t: float, x1_c: np.ndarray, x1: np.ndarray, x2: np.ndarray) -> np.ndarray:
            result: np.ndarray = self._step(t, x1_c, x1, x2)
            return result

    asked: dict[str, Any] = {"plant": "analytic", "set": {"duration_s": 1}}
    plain = uavftc.fly("scenario1", controller=gains({}), **asked)
    assert plain.summary["controller"] == "step"
    assert np.degrees(plain["phi_rad"][-1]) > 0.4  # towards the 5 deg of its reference
    for other in (create, Regulator):
        assert np.array_equal(uavftc.fly("scenario1", controller=other, **asked)["phi_rad"], plain["phi_rad"])


def test_a_controller_of_another_process_is_refused_in_words() -> None:
    with pytest.raises(uavftc.InputError, match="given as a Python object to another process"):
        uavftc.fly("scenario1", controller="python:nobody")


def test_what_the_code_of_a_function_raises_is_said_with_its_line() -> None:
    def step(t: float, x1_c: np.ndarray, x1: np.ndarray, x2: np.ndarray) -> np.ndarray:
        return x1 / nowhere  # type: ignore[name-defined, no-any-return]  # noqa: F821

    with pytest.raises(uavftc.InputError, match=r"name 'nowhere' is not defined[^.]*test_values\.py"):
        uavftc.fly("scenario1", controller=step, plant="analytic")


def test_a_comparison_has_its_flights_by_controller(comparison: uavftc.Comparison) -> None:
    assert list(comparison) == ["nndondi-l1", "pid"]
    alone = uavftc.fly("scenario3", controller="pid", set={**SHORT, "plant": "analytic"})
    assert np.array_equal(comparison["pid"]["phi_rad"], alone["phi_rad"])
    with pytest.raises(KeyError, match="no flight 'lqi'"):
        _ = comparison["lqi"]


def test_a_comparison_is_saved_and_loaded(comparison: uavftc.Comparison, tmp_path: Path) -> None:
    again = uavftc.load(comparison.save(tmp_path / "both", figures=False))
    assert isinstance(again, uavftc.Comparison)
    assert again.summary == comparison.summary


def test_two_plants_are_named_with_the_controller() -> None:
    both = uavftc.compare("scenario1", plants=["jsbsim", "analytic"], set={"duration_s": 1})
    assert list(both) == [("jsbsim", "nndondi-l1"), ("analytic", "nndondi-l1")]
    assert both["analytic", "nndondi-l1"].scenario.plant == "analytic"


def test_a_variant_is_flown_next_to_its_controller() -> None:
    asked = {"fast": {"controller.inner.filter_bandwidth": 120}}
    both = uavftc.compare("scenario1", variants=asked, set={"duration_s": 1, "plant": "analytic"})
    assert both["fast"].scenario.controller.inner.filter_bandwidth == 120


def test_a_campaign_is_flown_into_a_folder_and_loaded(tmp_path: Path) -> None:
    base = "{base: scenario1, name: few, cases: 3, plants: [analytic], vary: {reference.phi_deg: {uniform: [1, 5]}}}"
    (tmp_path / "few.yaml").write_text(base, encoding="utf-8")
    flown = uavftc.sweep(tmp_path / "few.yaml", set={"seed": np.int64(3)}, workers=1, out=tmp_path / "out")
    assert flown.flights.num_rows == 3
    again = uavftc.load(tmp_path / "out")
    assert isinstance(again, uavftc.CampaignResult)
    assert again.flights.equals(flown.flights)
    assert again.to_pandas()["margin"].between(-2, 1).all()
    with pytest.raises(uavftc.InputError, match="did you mean cases"):
        uavftc.sweep(tmp_path / "few.yaml", set={"cases_": 3})


def test_a_design_has_matrices_as_arrays() -> None:
    # the control matrix of hale about its trim is the B_m that its companion file claims, within 1e-6
    design = uavftc.design("hale")
    assert np.array(design.B) == pytest.approx(np.array([[10, 0, 0.225], [0, 7.5, 0], [1.125, 0, 6.75]]), abs=1e-6)
    assert design.trim["airspeed_mps"] == pytest.approx(30.0)
    with pytest.raises(AttributeError, match="no C in this design"):
        _ = design.C


def test_a_scenario_is_made_and_changed_with_the_checks_of_a_file() -> None:
    made = uavftc.make_scenario({"name": "mine"}, duration_s=3, reference={"phi_deg": 5})
    assert isinstance(made, Scenario)
    assert made.changed({"reference.phi_deg": "5*t"}, duration_s=2).reference.phi_deg.text == "5*t"
    assert made.duration_s == 3.0  # it is left as it is
    with pytest.raises(uavftc.InputError, match="did you mean phi_deg"):
        made.changed({"reference.phi_dg": 1})
    with pytest.raises(uavftc.InputError, match=r"index 0; faults has 0 entries"):
        made.changed({"faults[0].effectiveness": 1})


def test_the_text_of_a_scenario_is_its_file(tmp_path: Path) -> None:
    made = uavftc.make_scenario(name="mine", duration_s=3)
    (tmp_path / "mine.yaml").write_text(str(made), encoding="utf-8")
    assert uavftc.load_scenario(tmp_path / "mine.yaml") == made


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: uavftc.fly("scenario9"), "did you mean scenario"),
        (lambda: uavftc.fly("scenario1", controller=3), "an object of type int"),
        (lambda: uavftc.fly("scenario1", plant="real"), "real"),
        (lambda: uavftc.load("nowhere"), "no such folder"),
        (lambda: uavftc.make_scenario(name="a"), "add duration_s"),
        (lambda: uavftc.compare("scenario1", controllers=["pid", "pid"]), "pid twice"),
    ],
)
def test_what_is_wrong_is_refused_in_words(call: Any, words: str) -> None:
    with pytest.raises(uavftc.InputError, match=words):
        call()


def test_figures_are_matplotlib_figures_and_a_wrong_name_is_refused(
    flight: uavftc.Flight, comparison: uavftc.Comparison
) -> None:
    assert len(flight.plot("tracking").axes) == 7  # six panels, and the list of windows
    assert len(comparison.plot().axes) >= 3
    with pytest.raises(uavftc.InputError, match="tracking, control, estimates, overview"):
        flight.plot("speed")


def test_a_notebook_shows_a_flight_as_a_figure_and_metrics_as_a_table(flight: uavftc.Flight) -> None:
    assert "data:image/png;base64," in flight._repr_html_()
    table = flight.metrics._repr_html_()
    assert f"{flight.metrics['roll'].iae:.4g}" in table
    assert table.count("<tr>") == 8  # a heading and the seven metrics
