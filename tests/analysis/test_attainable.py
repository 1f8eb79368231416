"""What surfaces can still do, against closed forms and against sums of their deflections."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from uavftc.analysis.attainable import extremes, kept, left, outline, share_of


def test_of_decoupled_surfaces_each_axis_has_its_own():
    # B diagonal: what is left of axis i is B_ii times the way of surface i
    B, low, high = np.diag([10.0, 7.5, -6.75]), np.array([-0.1, -0.2, -0.3]), np.array([0.2, 0.1, 0.05])
    expected = [[-1.0, 2.0], [-1.5, 0.75], [-6.75 * 0.05, 6.75 * 0.3]]
    np.testing.assert_allclose(left(B, low, high), expected, rtol=1e-9)


def test_of_coupled_surfaces_it_is_what_the_inverse_allows():
    # with B square, B du = s e_i has the one solution du = s B^-1 e_i: s ends where the first surface is at its end
    rng = np.random.default_rng(1)
    for _ in range(50):
        B = rng.normal(size=(3, 3)) + 4.0 * np.eye(3)
        low, high = -rng.uniform(0.01, 0.4, 3), rng.uniform(0.01, 0.4, 3)
        ways = np.linalg.inv(B)
        for i in range(3):
            up = np.min(np.where(ways[:, i] > 0.0, high, low) / ways[:, i])
            down = np.min(np.where(ways[:, i] > 0.0, low, high) / -ways[:, i])
            np.testing.assert_allclose(left(B, low, high)[i], [-down, up], rtol=1e-7)


def test_a_share_is_the_demand_over_the_most_in_its_direction():
    B, low, high = np.diag([2.0, 4.0, 1.0]), np.full(3, -0.5), np.full(3, 0.5)
    assert share_of(B, low, high, np.array([0.5, 0.0, 0.0])) == pytest.approx(0.5)
    assert share_of(B, low, high, np.array([-2.0, 0.5, 0.0])) == pytest.approx(2.0)  # more than there is
    assert share_of(B, low, high, np.zeros(3)) == 0.0
    assert share_of(B[:, :2], low[:2], high[:2], np.array([0.0, 0.0, 1e-3])) == np.inf  # nothing acts there
    assert share_of(B, np.full(3, -np.inf), np.full(3, np.inf), np.ones(3)) == 0.0  # nothing limits
    assert share_of(np.zeros((3, 0)), np.zeros(0), np.zeros(0), np.ones(3)) == np.inf


def test_an_outline_has_all_sums_inside_and_its_corners_are_sums():
    rng = np.random.default_rng(2)
    for n in (1, 2, 3, 6):
        B, low, high = rng.normal(size=(2, n)), -rng.uniform(0.0, 1.0, n), rng.uniform(0.0, 1.0, n)
        corners = outline(B, low, high)
        sums = np.array([B @ u for u in itertools.product(*zip(low, high, strict=True))])
        for corner in corners:
            assert np.min(np.linalg.norm(sums - corner, axis=1)) < 1e-12
        around = np.roll(corners, -1, axis=0) - corners
        for point, edge in zip(corners, around, strict=True):  # anticlockwise: all are on the left of each edge
            assert np.all(edge[0] * (sums[:, 1] - point[1]) - edge[1] * (sums[:, 0] - point[0]) > -1e-12)
        assert np.ptp(corners, axis=0) == pytest.approx(np.ptp(sums, axis=0))


def test_an_outline_of_nothing_that_moves_is_a_point():
    np.testing.assert_allclose(outline(np.ones((2, 2)), np.array([1.0, 2.0]), np.array([1.0, 2.0])), [[3.0, 3.0]])


def test_without_the_rudder_yaw_is_lost_though_ailerons_yaw_a_little():
    # hale: ailerons roll, and yaw by a tenth of that; elevator pitches
    B = np.array([[5.0, -5.0, 0.0], [0.0, 0.0, 7.6], [0.56, -0.56, 0.0]])
    size = np.array([4.4, 3.3, 3.4])
    assert kept(B, size) == [0, 1]
    assert kept(np.column_stack([B, [-1.4, 0.0, 6.75]]), size) == [0, 1, 2]
    assert kept(np.zeros((3, 0)), size) == []


def test_extremes_are_those_samples_that_any_linear_measure_along_26_directions_finds():
    samples = np.random.default_rng(3).normal(size=(1000, 3))
    found = extremes(samples)
    assert len(found) <= 26
    for i in range(3):
        assert samples[:, i].max() == found[:, i].max()
        assert samples[:, i].min() == found[:, i].min()
    assert np.max(samples @ [1, -1, 1]) == pytest.approx(np.max(found @ [1, -1, 1]))
