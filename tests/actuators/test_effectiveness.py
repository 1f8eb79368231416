"""Loss of effectiveness and additive fault, eq. (6)."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.actuators import effectiveness
from uavftc.config.values import Signal
from uavftc.core.program import Program
from uavftc.core.signals import SURFACES, as_records, empty_rows

V2 = np.array([0.08, -0.03, 0.05])
EACH = np.zeros(3, effectiveness.PARAMS)


@pytest.mark.parametrize(
    ("omega", "v2a"),
    [
        ([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]),  # 1 no fault
        ([0.5, 0.7, 0.2], [0.0, 0.0, 0.0]),  # 2 loss of effectiveness
        ([1.0, 1.0, 1.0], [0.02, -0.1, 0.3]),  # 3 additive fault
        ([0.5, 0.3, 2.4], [0.02, -0.1, 0.3]),  # 4 both; the paper's rudder exceeds 1
        ([0.0, 0.0, 0.0], [0.02, 0.0, 0.0]),  # a surface that no longer answers
    ],
)
def test_all_cases_of_the_fault_are_one_formula(omega, v2a):
    # u2 = omega v2 + v_2a on each surface
    rows = empty_rows(1)
    effectors = as_records(rows)[0]["effectors"]
    effectors["deflection"], effectors["effectiveness"], effectors["bias"] = V2, omega, v2a
    Program([], [effectiveness.stage.block(EACH)]).run(rows, 0, 1)
    np.testing.assert_allclose(effectors["deflection"], np.array(omega) * V2 + v2a, rtol=1e-15)


def test_fault_follows_its_signals_in_time():
    # each row has its own omega and v_2a; nothing is remembered from the row before
    t = np.arange(100) * 0.1
    rows = empty_rows(100)
    effectors = as_records(rows)["effectors"]
    effectors["deflection"] = V2
    effectors["effectiveness"] = 1.0 - 0.05 * t[:, None] * [1.0, 0.5, 2.0]
    effectors["bias"] = np.sin(t)[:, None] * [0.1, 0.2, 0.3]
    Program([], [effectiveness.stage.block(EACH)]).run(rows, 0, 100)
    expected = (1.0 - 0.05 * np.outer(t, [1.0, 0.5, 2.0])) * V2 + np.outer(np.sin(t), [0.1, 0.2, 0.3])
    np.testing.assert_allclose(effectors["deflection"], expected, rtol=0, atol=1e-16)


@pytest.mark.parametrize("surface", SURFACES)
def test_a_fault_is_prescribed_to_its_axis_and_to_the_effectors_of_its_name(surface):
    # the history has omega and v_2a of each axis, the law those of each effector: the two must not drift apart
    t = np.array([1.0, 2.0])
    records = as_records(empty_rows(2, 4))
    entry = effectiveness.Config(surface=surface, effectiveness=Signal.of("0.1*t"), bias_deg=Signal.of("t"))
    effectiveness.prescribe(entry, t, records, ("rudder", "aileron", "elevator", "flap"))
    i, j = SURFACES.index(surface), ("rudder", "aileron", "elevator", "flap").index(surface)
    for field, expected in (("effectiveness", 0.1 * t), ("bias", np.radians(t))):
        np.testing.assert_allclose(records[field][:, i], expected, rtol=1e-15)
        np.testing.assert_array_equal(records["effectors"][field][:, j], records[field][:, i])
        assert np.count_nonzero(records[field]) == np.count_nonzero(records["effectors"][field]) == 2
