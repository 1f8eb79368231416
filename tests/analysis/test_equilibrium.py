"""Equilibria within bounds, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.analysis.equilibrium import System, differences, least, nearest, reach, solve

B_M = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])  # of the paper, 1/s^2


def linear(d: np.ndarray, stop: float = 0.4) -> System:
    """B_m u + d = 0 with u between stops."""
    ones = np.ones(3)
    return System(lambda u: B_M @ u + d, -stop * ones, stop * ones, 0.1 * ones, 0.1 * ones, 1e-9 * ones)


def circle(radius: float = 1.0) -> System:
    """x^2 + y^2 = radius^2 between -2 and 2."""
    two = np.full(2, 2.0)
    return System(
        lambda x: np.array([x @ x - radius**2, x[0] - 5.0]), -two, two, np.ones(2), np.ones(2), np.full(2, 1e-9)
    )


def test_a_linear_balance_is_the_inverse():
    d = np.array([0.5, -1.0, 0.7])
    found = solve(linear(d), [np.zeros(3)], [0, 1, 2], [0, 1, 2])
    assert found.met
    np.testing.assert_allclose(found.x, -np.linalg.solve(B_M, d), rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(differences(linear(d), found.x, [0, 2]), B_M[:, [0, 2]], rtol=1e-9)


def test_beyond_a_stop_there_is_none_and_what_is_left_is_the_closed_form():
    # pitch stands alone: 7.5 u = 5 needs 0.667 rad of 0.4, and 2 rad/s^2 are left
    d = np.array([0.3, -5.0, 0.2])
    system = linear(d)
    assert not solve(system, [np.zeros(3)], [0, 1, 2], [0, 1, 2]).met
    start = solve(system, [np.zeros(3)], [0, 1, 2], [0, 2])
    assert start.met
    rest = least(system, start.x, [0, 1, 2], [0, 2], 1)
    assert rest.met
    assert rest.residual[1] == pytest.approx(-2.0, abs=1e-6)


def test_a_held_surface_leaves_what_the_others_cannot_do():
    # rudder at 0.1: yaw by the aileron alone is tied to roll; of yaw 0.675 - 1.125 (0.0225)/10 is left at least
    system = linear(np.zeros(3))
    start = solve(system, [np.array([0.0, 0.0, 0.1])], [0, 1], [0, 1])
    rest = least(system, start.x, [0, 1], [0, 1], 2)
    assert rest.residual[2] == pytest.approx(0.675 - 1.125 * 0.0225 / 10.0, abs=1e-8)


def test_of_several_surfaces_the_least_deflections_are_taken():
    # two alike share a moment evenly
    system = System(lambda u: np.array([u[0] + u[1] - 0.2]), -np.ones(2), np.ones(2), np.ones(2), np.ones(1),
                    np.full(1, 1e-9))  # fmt: skip
    np.testing.assert_allclose(solve(system, [np.zeros(2)], [0, 1], [0]).x, [0.1, 0.1], atol=1e-9)


def test_a_start_that_leads_nowhere_is_left_for_the_next():
    # x^3 - 3 x + 4 has a valley of 2 at x = 1, where the first start ends, and one root
    three = np.full(1, 3.0)
    system = System(lambda x: x**3 - 3.0 * x + 4.0, -three, three, np.ones(1), np.ones(1), np.full(1, 1e-9))
    (root,) = (r.real for r in np.roots([1.0, 0.0, -3.0, 4.0]) if abs(r.imag) < 1e-9)
    alone = solve(system, [np.array([1.2])], [0], [0])
    assert not alone.met
    assert alone.residual[0] == pytest.approx(2.0, abs=1e-6)
    found = solve(system, [np.array([1.2]), np.array([-1.5]), np.array([3.0])], [0], [0])
    assert found.met
    assert found.x[0] == pytest.approx(root, abs=1e-9)


def test_what_is_not_a_number_is_a_bad_place_and_not_the_end():
    system = System(np.log, np.array([-1.0]), np.array([9.0]), np.ones(1), np.ones(1), np.full(1, 1e-9))
    with np.errstate(invalid="ignore"):
        found = solve(system, [np.array([-0.5]), np.array([0.5])], [0], [0])
    assert found.x[0] == pytest.approx(1.0, abs=1e-8)


def test_the_nearest_of_a_circle_to_a_point_is_on_the_ray_to_it():
    found = nearest(circle(), np.array([0.0, 1.0]), [0, 1], [0], [0, 1], np.array([1.5, 1.5]))
    assert found.met
    np.testing.assert_allclose(found.x, np.full(2, np.sqrt(0.5)), atol=1e-5)


@pytest.mark.parametrize("guess", [None, 0.3, 0.999, 1.5])
def test_how_far_it_reaches_is_where_the_circle_ends(guess):
    # x as far as y = sqrt(1 - x^2) exists
    found = reach(circle(), np.array([0.0, 0.9]), [1], [0], 0, towards=2.0, step=0.2, accuracy=1e-3, guess=guess)
    assert found.met
    assert 1.0 - 2e-3 <= found.x[0] <= 1.0


def test_cheap_differences_serve_as_well_where_they_differ_by_a_constant():
    d = np.array([0.5, -1.0, 0.7])
    calls = []

    def near(u):
        calls.append(1)
        return B_M @ u + 17.0

    found = solve(linear(d)._replace(near=near, slow=(1,)), [np.zeros(3)], [0, 1, 2], [0, 1, 2])
    assert found.met
    assert len(calls) >= 3
    np.testing.assert_allclose(found.x, -np.linalg.solve(B_M, d), rtol=0.0, atol=1e-9)
