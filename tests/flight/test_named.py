"""What a scenario names of its aircraft: unknown surfaces, and faults of a gang and its members at one time."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.core.layout import OWN_GANGS, Layout
from uavftc.errors import CombinedInputError, InputError
from uavftc.flight.build import build_flight
from uavftc.flight.named import refuse_unknown
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

GANGS = {"aileron": {"left_aileron": 1.0, "right_aileron": -1.0}, "elevator": {"elevator": 1.0}}
NAMES = ("left_aileron", "right_aileron", "elevator")
LAYOUT = Layout(NAMES, np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0]]), GANGS, np.zeros(3), np.ones(3))


def scenario(**changes) -> Scenario:
    return Scenario.model_validate({"name": "named", "duration_s": 20, **changes})


def test_an_unknown_surface_is_refused_with_its_line_and_all_names_that_there_are(tmp_path):
    # a scenario does not know its aircraft, so this is said when the flight is built, with the file all the same
    file = tmp_path / "mine.yaml"
    file.write_text("name: a\nduration_s: 1\nplant: analytic\nfaults:\n  - {surface: ailron}\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        build_flight(load_scenario(file))
    message = str(error.value)
    assert f"{file}, line 5, key faults[0].surface" in message
    assert "'ailron'" in message
    assert "elevator" in message
    assert "rudder" in message
    assert "did you mean aileron?" in message


def test_an_option_that_names_an_unknown_surface_is_named():
    with pytest.raises(InputError) as error:
        build_flight(load_scenario("scenario3", plant="analytic", overrides=["faults[1].surface=flap"]))
    assert error.value.where == "--set faults[1].surface=flap, key faults[1].surface"


def test_all_unknown_names_are_reported_at_once():
    wrong = scenario(
        faults=[{"surface": "flap"}, {"surface": "left_aileron"}, {"surface": "rudder"}],
        saturation={"slat": {"min_rad": -1, "max_rad": 1}, "elevator": None, "spoiler": None},
    )
    with pytest.raises(CombinedInputError) as error:
        refuse_unknown(wrong, LAYOUT)
    where = [e.where.removeprefix("key ") for e in error.value.errors]
    assert where == ["faults[0].surface", "faults[2].surface", "saturation.slat", "saturation.spoiler"]
    assert "one of aileron, elevator, left_aileron, right_aileron, the surfaces of hale" in str(error.value)


@pytest.mark.parametrize(
    ("first", "second", "shared"),
    [("aileron", "left_aileron", "left_aileron"), ("right_aileron", "aileron", "right_aileron")],
)
def test_a_fault_of_a_gang_and_one_of_its_member_at_one_time_are_both_named(first, second, shared):
    # both would set the effectiveness of one effector
    faults = [{"surface": first, "end_s": 8}, {"surface": second, "start_s": 7}]
    with pytest.raises(InputError) as error:
        refuse_unknown(scenario(faults=faults), LAYOUT)
    assert error.value.where == "key faults[1]"
    assert error.value.found == f"faults[1] on [7, end) s overlaps faults[0] on [0, 8) s, both on the {shared}"


def test_two_faults_that_overlap_on_both_members_are_reported_once():
    gangs = {**GANGS, "rudder": {"left_aileron": 1.0, "right_aileron": 1.0}}
    mixing = np.array([[1.0, 0, 1.0], [-1.0, 0, 1.0], [0, 1.0, 0]])
    layout = Layout(NAMES, mixing, gangs, np.zeros(3), np.ones(3))
    with pytest.raises(InputError, match="both on the left_aileron") as error:
        refuse_unknown(scenario(faults=[{"surface": "aileron"}, {"surface": "rudder"}]), layout)
    assert not isinstance(error.value, CombinedInputError)


def test_members_one_after_the_other_and_side_by_side_are_flown():
    faults = [
        {"surface": "left_aileron", "end_s": 8},
        {"surface": "right_aileron", "start_s": 1, "end_s": 9},
        {"surface": "aileron", "start_s": 9},
    ]
    refuse_unknown(scenario(faults=faults), LAYOUT)


def test_where_it_was_written_is_no_part_of_a_scenario(tmp_path):
    # what is read back from a result folder equals what was flown
    file = tmp_path / "again.yaml"
    one = load_scenario("scenario3")
    file.write_text((one.model_dump_json()), encoding="utf-8")
    again = load_scenario(file)
    assert again == one
    assert again.origin.where(("name",)) != one.origin.where(("name",))
    assert scenario().origin.where(("faults", 0)) == "key faults[0]"


def test_one_surface_an_axis_is_what_a_scenario_of_the_paper_names():
    refuse_unknown(load_scenario("scenario3"), Layout())
    assert list(OWN_GANGS) == ["aileron", "elevator", "rudder"]
