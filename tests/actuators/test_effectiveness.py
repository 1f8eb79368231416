"""Loss of effectiveness and additive fault, eq. (6)."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.actuators import effectiveness
from uavftc.config.values import Signal
from uavftc.core.layout import OWN_GANGS, targets_of
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
def test_a_fault_is_prescribed_to_the_effector_of_its_name(surface):
    # omega as it is written, the bias in rad; no other effector has any of it
    t = np.array([1.0, 2.0])
    records = as_records(empty_rows(2, 4))
    entry = effectiveness.Config(surface=surface, effectiveness=Signal.of("0.1*t"), bias_deg=Signal.of("t"))
    names = ("rudder", "aileron", "elevator", "flap")
    effectiveness.prescribe(entry, t, records, targets_of(names, OWN_GANGS))
    j = names.index(surface)
    for field, expected in (("effectiveness", 0.1 * t), ("bias", np.radians(t))):
        np.testing.assert_allclose(records["effectors"][field][:, j], expected, rtol=1e-15)
        assert np.count_nonzero(records["effectors"][field]) == 2


def test_a_bias_of_a_gang_moves_each_member_by_its_weight():
    # ailerons move against each other: what rolls by 2 deg of aileron is left up and right down
    records = as_records(empty_rows(1, 2))
    gangs = {"aileron": {"left": 1.0, "right": -0.5}}
    entry = effectiveness.Config(surface="aileron", effectiveness=Signal.of(0.3), bias_deg=Signal.of(2.0))
    effectiveness.prescribe(entry, np.zeros(1), records, targets_of(("left", "right"), gangs))
    np.testing.assert_array_equal(records["effectors"]["effectiveness"], [[0.3, 0.3]])
    np.testing.assert_allclose(records["effectors"]["bias"], np.radians([[2.0, -1.0]]), rtol=1e-15)
