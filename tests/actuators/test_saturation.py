"""Input saturation, eq. (20)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc.actuators import saturation
from uavftc.core.program import Program
from uavftc.core.signals import EFFECTOR, SURFACES, as_records, empty_rows
from uavftc.core.stage import records_of

LOW, HIGH = np.array([-0.05, -0.02, -np.inf]), np.array([0.1, 0.3, np.inf])


def limited(v):
    rows = empty_rows(1)
    row = as_records(rows)[0]
    row["effectors"]["deflection"] = v
    params = records_of(saturation.PARAMS, 3, u_min=LOW, u_max=HIGH)
    Program([], [saturation.stage.block(params)]).run(rows, 0, 1)
    return row["effectors"]


@settings(deadline=None)  # the first example compiles
@given(v=st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3))
def test_each_surface_is_limited_to_its_own_unbalanced_range(v):
    # eq. (20) piece by piece; infinite limits are none; nothing else of the effector changes
    effectors = limited(v)
    np.testing.assert_array_equal(effectors["deflection"], np.clip(v, LOW, HIGH))
    assert not any(effectors[name].any() for name in EFFECTOR.names if name != "deflection")


@pytest.mark.parametrize("surface", [0, 1, 2])
def test_nan_is_not_limited_away(surface):
    # a broken command must reach the watch, not become a plausible deflection
    v = np.full(3, 0.01)
    v[surface] = np.nan
    np.testing.assert_array_equal(np.isnan(limited(v)["deflection"]), np.isnan(v))


def test_infinite_command_is_limited():
    # infinity is a command beyond the limit like any other
    np.testing.assert_array_equal(limited([np.inf, -np.inf, 0.0])["deflection"], [0.1, -0.02, 0.0])


def test_limits_go_to_the_effectors_of_their_name():
    # the aircraft's order of effectors counts, not that of the scenario's keys; one pair of limits is for all
    one = saturation.Limits(min_rad=-0.1, max_rad=0.2)
    each = saturation.SurfaceLimits(rudder=saturation.Limits(min_rad=-0.3, max_rad=0.4), aileron=one)
    free = [-np.inf, np.inf]
    np.testing.assert_array_equal(saturation.limits_rad(None), [free] * 3)
    np.testing.assert_array_equal(saturation.limits_rad(one), [[-0.1, 0.2]] * 3)
    np.testing.assert_array_equal(saturation.limits_rad(each), [[-0.1, 0.2], free, [-0.3, 0.4]])
    np.testing.assert_array_equal(saturation.limits_rad(each, SURFACES[::-1]), [[-0.3, 0.4], free, [-0.1, 0.2]])
