"""Loss of effectiveness and additive fault, eq. (6)."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.actuators import effectiveness
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import Program

V2 = np.array([0.08, -0.03, 0.05])


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
    # u2 = omega v2 + v_2a on each surface, on both commands of a sample
    rows = empty_rows(1)
    row = as_records(rows)[0]
    row["u2"], row["u2_late"], row["effectiveness"], row["bias"] = V2, -2.0 * V2, omega, v2a
    Program([effectiveness.stage.block()]).run(rows, 0, 1)
    np.testing.assert_allclose(row["u2"], np.array(omega) * V2 + v2a, rtol=1e-15)
    np.testing.assert_allclose(row["u2_late"], -2.0 * np.array(omega) * V2 + v2a, rtol=1e-15)


def test_fault_follows_its_signals_in_time():
    # each row has its own omega and v_2a; nothing is remembered from the row before
    t = np.arange(100) * 0.1
    rows = empty_rows(100)
    records = as_records(rows)
    records["u2"] = records["u2_late"] = V2
    records["effectiveness"] = 1.0 - 0.05 * t[:, None] * [1.0, 0.5, 2.0]
    records["bias"] = np.sin(t)[:, None] * [0.1, 0.2, 0.3]
    Program([effectiveness.stage.block()]).run(rows, 0, 100)
    expected = (1.0 - 0.05 * np.outer(t, [1.0, 0.5, 2.0])) * V2 + np.outer(np.sin(t), [0.1, 0.2, 0.3])
    np.testing.assert_allclose(records["u2"], expected, rtol=0, atol=1e-16)
