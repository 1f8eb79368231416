"""A flying wing and an aircraft without ailerons, flown on the axes that they have; and what is refused of them."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from flying import flown
from uavftc.aircraft.definition import load_aircraft
from uavftc.cli.app import umbrella
from uavftc.core.signals import AXES, attitude_error
from uavftc.errors import InputError
from uavftc.flight.build import build_flight
from uavftc.flight.condition import authority_of
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.design.fleet import row_of
from uavftc.jobs.fly import fly_mission
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.report.fleet_table import line
from uavftc.report.side_by_side import metric_tables
from uavftc.report.table import metric_table
from uavftc.scenario.load import load_scenario
from wings import rotational, without

CONTROLLERS = ["nndondi-l1", "ndi-l1", "nndondi-mrac", "ndi-mrac", "pid", "lqi"]
FREE = {"rudder": 2, "aileron": 0}
ANGLE = {"rudder": "psi", "aileron": "phi"}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """hale without a rudder, a wing left to its weathercock stability, and without ailerons, left to its dihedral."""
    home = tmp_path_factory.mktemp("fewer")
    return {surface: without(home / f"no-{surface}", surface) for surface in FREE}


def scenario(folder, missing, plant="jsbsim", controller=None, *overrides):
    overrides = [f"reference.{ANGLE[missing]}_deg=0", *overrides]
    return load_scenario("scenario1", plant=plant, aircraft=str(folder), controller=controller, overrides=overrides)


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
@pytest.mark.parametrize("missing", FREE)
def test_steps_on_the_other_axes_are_followed_as_on_three(folders, missing, plant, controller):
    # given steps of 5 deg / then each error decays with the outer loop's bandwidth, 0.5 1/s: IAE 5 deg / 0.5, and into
    # the paper's band of 0.02 deg; the third angle is the airframe's, its command exactly zero
    flight = build_flight(scenario(folders[missing], missing, plant, controller))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    own = np.flatnonzero(flight.given.axes)
    assert list(own) == [i for i in range(3) if i != FREE[missing]]
    error = np.abs(attitude_error(records))[:, own]
    assert np.degrees(error[-1]).max() < 0.02
    if controller != "lqi":
        np.testing.assert_allclose(error.sum(axis=0) / 200.0, np.radians(5.0) / 0.5, rtol=0.07)
    np.testing.assert_array_equal(records["v2"][:, FREE[missing]], 0.0)


def test_a_banked_wing_turns_as_its_authority_counts(folders):
    # Held at 5 deg of bank, the wing settles into a turn: its sideslip and its aileron are those that `authority` finds
    # for balance of side force and moments; r is what side force and weight leave, Y_beta beta + g sin(phi)/V.
    banked = scenario(folders["rudder"], "rudder", "jsbsim", None, "reference={phi_deg: 5}", "duration_s=40")
    flight = build_flight(banked)
    records, _ = fly_to_memory(flight)
    last = records[-1]
    assert flight.model is not None
    counted = authority_of(banked, flight.model)
    assert last["beta"] == pytest.approx(counted.beta, rel=0.05)
    assert abs(last["v2"][0]) == pytest.approx(abs(counted.steady[0]), rel=0.05)
    Y_beta = flight.model.A[4][4]
    r = 9.80665 * np.sin(last["x1"][0]) / last["airspeed"] + Y_beta * last["beta"]
    assert last["x2"][2] == pytest.approx(r, rel=0.02)


def test_without_ailerons_the_dihedral_levels_the_wings(folders):
    # The heading is stepped by the rudder alone: the bank that the sideslip raises goes away by itself.
    records, _ = fly_to_memory(build_flight(scenario(folders["aileron"], "aileron", "jsbsim", None, "duration_s=60")))
    bank = np.degrees(np.abs(records["x1"][:, 0]))
    assert bank.max() > 1.0
    assert bank[-1] < 0.1 * bank.max()


def test_the_measured_model_says_which_axes_there_are(folders):
    model = trimmed_model(load_aircraft(str(folders["rudder"])), 30.0, 1000.0)
    assert list(model.axes) == [True, True, False]
    B = model.B_rates
    np.testing.assert_array_equal(B[:, 2], 0.0)
    np.testing.assert_allclose(B[:, :2], [[10.0, 0.0], [0.0, 7.5], [1.125, 0.0]], atol=1e-5)  # yaw of the aileron


def test_the_design_names_the_axes_and_has_zeros_for_the_others(folders):
    design = build_flight(scenario(folders["rudder"], "rudder")).given.design
    assert design.axes == (True, True, False)
    np.testing.assert_array_equal(design.B[:, 2], 0.0)
    np.testing.assert_array_equal(design.limits_rad[2], 0.0)


CUSTOM = """
import numpy as np

def create(design, h, options):
    inverse = np.linalg.pinv(design.B)
    def step(t, x1_c, x1, x2):
        v2 = inverse @ (2.0 * (0.5 * (x1_c - x1) - x2))
        v2[~np.array(design.axes)] = options["waste"] * np.sin(50.0 * t)
        return v2
    return step
"""


def test_what_a_custom_controller_commands_on_a_missing_axis_has_no_effect(folders, tmp_path):
    module = tmp_path / "wasteful.py"
    module.write_text(CUSTOM, encoding="utf-8")
    flights = []
    for waste in (0.0, 0.3):
        changes = ("duration_s=3", f"controller.options={{waste: {waste}}}")
        flights.append(
            fly_to_memory(build_flight(scenario(folders["rudder"], "rudder", "jsbsim", str(module), *changes)))
        )
    (one, _), (other, outcome) = flights
    assert outcome.completed
    np.testing.assert_array_equal(one["v2"], other["v2"])
    np.testing.assert_array_equal(other["v2"][:, 2], 0.0)
    np.testing.assert_array_equal(one["x1"], other["x1"])


@pytest.mark.parametrize("plant", ["jsbsim", "analytic"])
@pytest.mark.parametrize(
    ("missing", "reference", "found"),
    [
        ("rudder", "{phi_deg: 5, psi_deg: 5}", "5"),
        ("rudder", "{psi_deg: sin(t)}", "sin(t)"),
        ("aileron", "{phi_deg: -2}", "-2"),
    ],
)
def test_a_reference_about_a_missing_axis_is_refused(folders, plant, missing, reference, found):
    flown_by = load_scenario(
        "scenario1", plant=plant, aircraft=str(folders[missing]), overrides=[f"reference={reference}"]
    )
    with pytest.raises(InputError) as error:
        build_flight(flown_by)
    key = f"reference.{ANGLE[missing]}_deg"
    assert error.value.where == f"key {key}"
    assert error.value.found == found
    axis = AXES[FREE[missing]]
    assert error.value.expected == f"0, because no-{missing} has no {missing} (no effector acts about {axis})"
    assert error.value.remedy == f"leave it out (--set {key}=0)"


def test_a_reference_that_is_zero_at_every_sample_is_none(folders):
    assert build_flight(scenario(folders["rudder"], "rudder", "jsbsim", None, "reference.psi_deg=0*t"))


def test_pitch_and_one_of_the_others_are_needed(tmp_path):
    # without an elevator nothing holds the angle of attack, with it alone nothing stops a bank that grows
    for k, surfaces in enumerate([("elevator",), ("aileron", "rudder")]):
        folder = rotational(tmp_path / f"wing{k}", *surfaces)
        with pytest.raises(InputError, match=f"no {surfaces[0]}: ") as error:
            build_flight(load_scenario("scenario1", plant="analytic", aircraft=str(folder)))
        assert error.value.where.endswith("key analytic.B_m")
        assert error.value.expected == "surfaces that act about pitch and about roll or yaw"
    with pytest.raises(InputError, match="no aileron and no rudder: nothing acts"):
        build_flight(scenario(without(tmp_path / "two", "aileron", "rudder"), "rudder"))


def test_the_result_says_which_axis_was_not_controlled(folders, tmp_path):
    out = tmp_path / "out"
    summary, _ = fly_mission(scenario(folders["rudder"], "rudder", "jsbsim", None, "duration_s=2"), out)
    assert summary == json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert set(summary["axes"]["yaw"].values()) == {None}
    assert all(summary["axes"][axis]["iae"] > 0.0 for axis in ("roll", "pitch"))
    assert "no rudder: yaw is left to the airframe (no effector acts about it)" in summary["warnings"]
    assert {path.name for path in (out / "figures").iterdir()} >= {"tracking.png", "control.png", "estimates.png"}
    text = printed(metric_table(summary))
    assert "not controlled" in text
    assert text.count("not within") == 2  # two flown axes have not converged; the third has nothing to converge
    together = printed(*metric_tables({"combinations": [summary], "plants": ["jsbsim"]}))
    assert "yaw, not controlled" in together
    assert "pitch, not" not in together


def printed(*tables):
    console = Console(file=io.StringIO(), width=100)
    console.print(*tables)
    return console.file.getvalue()


def test_the_scenario_as_flown_flies_again_to_the_bit(folders, tmp_path):
    # its B_m has no inverse, and is left to the aircraft
    first, _ = fly_mission(
        scenario(folders["rudder"], "rudder", "jsbsim", None, "duration_s=1"), tmp_path / "a", figures=False
    )
    again = load_scenario(tmp_path / "a" / "scenario.yaml")
    second, _ = fly_mission(again, tmp_path / "b", figures=False)
    assert first["axes"] == second["axes"]
    assert (tmp_path / "a" / "scenario.yaml").read_bytes() == (tmp_path / "b" / "scenario.yaml").read_bytes()


def test_the_design_document_is_that_of_two_axes(folders, tmp_path):
    figure = tmp_path / "design.svg"
    arguments = ["design", str(folders["rudder"]), "--figure", str(figure)]
    done = CliRunner().invoke(umbrella, [*arguments, "--json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert found["verdict"] == "flyable"  # the step in yaw of the scenario that it is designed with is no demand
    assert found["controlled"] == {"roll": True, "pitch": True, "yaw": False}
    assert found["authority"]["yaw"] is None
    assert found["limits_rad"][2] is None
    assert found["trim"]["rudder_rad"] is None
    for name in ("A_m", "A_s", "B_m", "K", "K_0", "K_0_matching_A", "P", "Q"):
        matrix = found[name]
        assert [row[2] for row in matrix] == matrix[2] == [None] * 3
        assert all(value is not None for row in matrix[:2] for value in row[:2])
    assert len(found["eigenvalues_A_m"]) == 2
    assert (found["controllability"]["rank"], found["controllability"]["axes"]) == (2, 2)
    assert found["l1_norm_G"] > 0.0
    assert figure.is_file()
    text = CliRunner().invoke(umbrella, ["design", str(folders["rudder"])]).stdout
    assert "no rudder: yaw is left to the airframe" in text
    assert "rank 2 of 2" in text


def test_the_reference_system_of_two_axes_stays_as_close_as_that_of_three(folders):
    # docs/theory.md: 2.3 % of the largest command on hale's three axes at 200 Hz, the hold between two samples
    done = CliRunner().invoke(
        umbrella,
        ["design", str(folders["rudder"]), "--flight", "scenario1", "--set", "reference.psi_deg=0", "--json"],
    )
    assert done.exit_code == 0, done.output
    _, analytic = json.loads(done.stdout)["flight"]["flights"]
    assert analytic["reference_system"]["A_m"]["share_of_max_r"] < 0.025
    assert analytic["max_r_radps"][2] is None
    assert analytic["reference_system"]["A_m"]["max_x_ref_minus_x2_radps"][2] is None


def test_the_list_of_aircraft_says_what_is_missing(folders):
    row = row_of(str(folders["rudder"]))
    assert row["flyable"]
    assert row["without"] == ["rudder"]
    assert line(row).endswith("times, no rudder)")


def test_three_axes_fly_without_a_block_of_their_own():
    # the block that zeroes a command is part of a flight only where an axis is missing
    flight, _, _ = flown("scenario1", "analytic")
    assert "uncontrolled" not in [block.name for block in flight.program.blocks]
