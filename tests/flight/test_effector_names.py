"""Names of effectors in a companion file that the history could not tell from its other columns."""

from __future__ import annotations

import pytest

from uavftc.aircraft.effectors import Effector, problems


@pytest.mark.parametrize(
    ("name", "column"),
    [("alpha", "alpha_rad"), ("phi_ref", "phi_ref_rad"), ("bias_rudder", "bias_rudder_rad"),
     ("rudder_position", "rudder_position_rad"), ("aileron_cmd", "aileron_cmd_rad")],
)  # fmt: skip
def test_a_name_whose_column_is_taken_is_refused(name, column):
    (problem,) = problems({name: Effector(command="fcs/a")}, {}, {"effectors"})
    assert problem.key == ("effectors", name)
    assert f"the history has a column {column} already" in problem.found


@pytest.mark.parametrize("name", ["left_aileron", "elevator", "flap", "beta_vane"])
def test_other_names_are_allowed(name):
    assert problems({name: Effector(command="fcs/a")}, {}, {"effectors"}) == []
