"""Input saturation, eq. (20)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc.actuators import saturation
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import Program, params_of

LOW, HIGH = np.array([-0.05, -0.02, -np.inf]), np.array([0.1, 0.3, np.inf])


def limited(v, late=0.0):
    rows = empty_rows(1)
    row = as_records(rows)[0]
    row["u2"], row["u2_late"] = v, late
    Program([saturation.stage.block(params_of(saturation.PARAMS, u_min=LOW, u_max=HIGH))]).run(rows, 0, 1)
    return row


@settings(deadline=None)  # the first example compiles
@given(v=st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3), late=st.floats(-1.0, 1.0))
def test_each_surface_is_limited_to_its_own_unbalanced_range(v, late):
    # eq. (20) piece by piece; infinite limits are none
    row = limited(v, late)
    np.testing.assert_array_equal(row["u2"], np.clip(v, LOW, HIGH))
    np.testing.assert_array_equal(row["u2_late"], np.clip([late] * 3, LOW, HIGH))


@pytest.mark.parametrize("surface", [0, 1, 2])
def test_nan_is_not_limited_away(surface):
    # a broken command must reach the watch, not become a plausible deflection
    v = np.full(3, 0.01)
    v[surface] = np.nan
    row = limited(v, v)
    np.testing.assert_array_equal(np.isnan(row["u2"]), np.isnan(v))
    np.testing.assert_array_equal(np.isnan(row["u2_late"]), np.isnan(v))


def test_infinite_command_is_limited():
    # infinity is a command beyond the limit like any other
    np.testing.assert_array_equal(limited([np.inf, -np.inf, 0.0])["u2"], [0.1, -0.02, 0.0])
