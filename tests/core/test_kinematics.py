"""Attitude kinematics of eq. (1) against rotation matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from uavftc.core.kinematics import attitude_rates, body_rates, wrapped

RATES = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)
ATTITUDES = st.tuples(st.floats(-np.pi, np.pi), st.floats(-1.4, 1.4), st.floats(-10.0, 10.0)).map(np.array)


def body_to_earth(x1):
    """Rotation of the 3-2-1 Euler angles."""
    return Rotation.from_euler("ZYX", [x1[2], x1[1], x1[0]])


@settings(deadline=None)  # the first example compiles
@given(x1=ATTITUDES, x2=RATES)
def test_attitude_rates_are_those_of_the_rotation(x1, x2):
    # a rotation turned by x2 for +-h, seen as Euler angles: central differences, error of the order of h^2
    h = 1e-5
    ends = []
    for sign in (-1.0, 1.0):
        angles = (body_to_earth(x1) * Rotation.from_rotvec(sign * h * x2)).as_euler("ZYX")[::-1]
        ends.append(x1 + (angles - x1 + np.pi) % (2 * np.pi) - np.pi)
    expected = (ends[1] - ends[0]) / (2 * h)
    np.testing.assert_allclose(attitude_rates(x1, x2), expected, atol=1e-5)


@settings(deadline=None)  # the first example compiles
@given(x1=ATTITUDES, x2=RATES)
def test_the_two_directions_are_inverse(x1, x2):
    # body_rates is g1^-1: both ways round give back what was put in
    scale = 1.0 / np.cos(x1[1]) ** 2
    np.testing.assert_allclose(body_rates(x1, np.array(attitude_rates(x1, x2))), x2, atol=1e-13 * scale)
    np.testing.assert_allclose(attitude_rates(x1, np.array(body_rates(x1, x2))), x2, atol=1e-13 * scale)


def test_body_rates_exist_where_attitude_rates_do_not():
    # at theta = 90 deg g1 is singular and its inverse is not; the other one must not raise (IEEE arithmetic)
    up = np.array([0.3, np.pi / 2, 0.0])
    np.testing.assert_allclose(body_rates(up, np.array([0.1, 0.0, 0.1])), 0.0, atol=1e-15)
    assert abs(attitude_rates(up, np.array([0.0, 0.0, 1.0]))[2]) > 1e15


@settings(deadline=None)  # the first example compiles
@given(angle=st.floats(-1e4, 1e4))
def test_wrapped_moves_by_whole_turns_into_half_a_turn_either_side(angle):
    # same direction, at most half a turn
    result = wrapped(angle)
    assert -np.pi <= result <= np.pi
    turns = (angle - result) / (2 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)


def test_wrapped_at_its_ends():
    # exactly half a turn has one representative
    assert wrapped(np.pi) == -np.pi
    assert wrapped(-np.pi) == -np.pi
    assert wrapped(0.0) == 0.0
    assert np.isnan(wrapped(np.nan))
