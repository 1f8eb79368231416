"""Authority of the surfaces against closed forms, and each obstacle with its words."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.analysis.authority import (
    COUPLING_MAX,
    NONLINEAR_MAX,
    RESPONSE_MIN,
    authority,
    can_be_held,
    controlled_axes,
    obstacles,
)

B_OWN = np.array([10.0, 7.5, 5.0])  # 1/s^2 per rad
LIMITS = np.array([[-0.3, 0.4], [-0.5, 0.2], [-0.4, 0.4]])  # rad
A_M = np.array([[-8.5, 1.2, -3.5], [-1.5, -1.5, -1.0], [-0.02, 0.0, -2.0]])  # 1/s
DESIGN = {"A_m": A_M, "bandwidth": np.array([0.5, 0.6, 0.7]), "step": np.radians([5.0, 4.0, 3.0])}
Y_BETA, Y_PHI = -0.25, 0.16  # 1/s
N_BETA = {5: -20.0, 2: 0.3, 6: 6.0}  # 1/s^2 on p, q, r, by their row of A


def plane(own=B_OWN, coupling=0.0):
    """Return (A, B) of an aircraft with a dihedral, a weathercock and, on request, coupled surfaces."""
    A = np.zeros((8, 8))
    A[4, 4], A[4, 7] = Y_BETA, Y_PHI
    for row, value in N_BETA.items():
        A[row, 4] = value
    B = np.zeros((6, 3))
    B[3:] = np.diag(own) + coupling * (np.ones((3, 3)) - np.eye(3))
    return A, B


def test_first_moment_of_a_step_is_the_worst_axis_over_the_surfaces_own_response():
    # u = B^-1 A_m r with r = D step on one axis at a time; with B diagonal each row divides by its own response.
    A, B = plane()
    found = authority(A, B, LIMITS, **DESIGN).first
    r = 0.5 * np.radians(5.0), 0.6 * np.radians(4.0), 0.7 * np.radians(3.0)
    roll = max(8.5 * r[0], 1.2 * r[1], 3.5 * r[2]) / 10.0
    pitch = max(1.5 * r[0], 1.5 * r[1], 1.0 * r[2]) / 7.5
    yaw = max(0.02 * r[0], 0.0, 2.0 * r[2]) / 5.0
    np.testing.assert_allclose(found, [roll, pitch, yaw], rtol=1e-14)


@pytest.mark.parametrize("coupling", [0.0, 1.5])
def test_steady_bank_balances_side_force_and_moments(coupling):
    # At the reported sideslip 0 = Y_beta beta + Y_phi phi; with the reported deflections 0 = N beta + B u on each axis.
    A, B = plane(coupling=coupling)
    found = authority(A, B, LIMITS, **DESIGN)
    phi = np.radians(5.0)
    assert found.beta == pytest.approx(Y_PHI / 0.25 * phi, rel=1e-14)
    assert Y_BETA * found.beta + Y_PHI * phi == pytest.approx(0.0, abs=1e-15)
    moments = np.array(list(N_BETA.values())) * found.beta
    np.testing.assert_allclose(moments + B[3:] @ found.steady, 0.0, atol=1e-14)


def test_without_a_side_force_there_is_no_sideslip_to_hold():
    # A body that feels no sideslip (or a model without one) must not divide by zero.
    A, B = plane()
    A[4, 4] = 0.0
    found = authority(A, B, LIMITS, **DESIGN)
    assert found.beta == 0.0
    np.testing.assert_array_equal(found.steady, 0.0)


def test_available_is_the_way_to_the_nearer_limit():
    # Which way the surface must go is not known before: the nearer limit counts, and none is left beyond one.
    A, B = plane()
    np.testing.assert_allclose(authority(A, B, LIMITS, **DESIGN).available, [0.3, 0.2, 0.4])
    beyond = np.array([[0.05, 0.4], [-0.5, -0.1], [-0.4, 0.0]])  # a trim outside its range, or at its end
    np.testing.assert_array_equal(authority(A, B, beyond, **DESIGN).available, 0.0)


def test_ratio_is_supply_over_the_sum_of_both_demands():
    A, B = plane()
    found = authority(A, B, LIMITS, **DESIGN)
    demand = np.abs(found.first) + np.abs(found.steady)
    np.testing.assert_allclose(found.ratio, np.array([0.3, 0.2, 0.4]) / demand, rtol=1e-14)
    nothing = authority(A, B, LIMITS, **(DESIGN | {"step": np.zeros(3)}))
    assert np.all(nothing.ratio > 1e6)  # nothing demanded, no division by zero


def test_ratio_falls_with_the_step():
    # Both demands are linear in the step: twice the step, half the ratio.
    A, B = plane(coupling=1.0)
    once = authority(A, B, LIMITS, **DESIGN).ratio
    twice = authority(A, B, LIMITS, **(DESIGN | {"step": 2.0 * DESIGN["step"]})).ratio
    np.testing.assert_allclose(once, 2.0 * twice, rtol=1e-12)


AMPLE, LINEAR = np.full(3, 5.0), np.zeros(3)


def test_a_good_aircraft_has_no_obstacles():
    _, B = plane(coupling=1.0)
    assert obstacles(B[3:], LIMITS, LINEAR, AMPLE) == []
    assert obstacles(B[3:], LIMITS, LINEAR, None) == []


@pytest.mark.parametrize(("surface", "name"), [(0, "aileron"), (1, "elevator"), (2, "rudder")])
def test_each_obstacle_names_its_surface(surface, name):
    axis = ("roll", "pitch", "yaw")[surface]
    dead = B_OWN.copy()
    dead[surface] = 0.9 * RESPONSE_MIN / np.max(np.abs(LIMITS[surface]))
    found = obstacles(np.diag(dead), LIMITS, LINEAR, AMPLE)
    # without pitch nothing can be flown; without one of the others the aircraft is flown on two axes
    assert found == ([f"no small-signal {name} response: 0.0009 rad/s^2 at full deflection"] if surface == 1 else [])
    bent = LINEAR.copy()
    bent[surface] = NONLINEAR_MAX
    assert obstacles(np.diag(B_OWN), LIMITS, bent, AMPLE) == [
        f"the {name} response is not linear in the small: 30 % apart between steps of 0.2 and 1 % of its range"
    ]
    little = AMPLE.copy()
    little[surface] = 0.5
    assert obstacles(np.diag(B_OWN), LIMITS, LINEAR, little) == [
        f"too little {name} for the reference: {axis} has 0.50 times the deflection it needs"
    ]


def test_coupling_counts_in_units_of_each_surfaces_own_axis():
    # Two surfaces that do the same: reported with the condition number; scaling a surface's unit changes nothing.
    B = np.array([[1.0, 0.0, 0.99], [0.0, 1.0, 0.0], [0.99, 0.0, 1.0]])
    condition = 1.99 / 0.01  # of the symmetric 2 by 2 block
    found = [f"B is ill-conditioned: condition number {condition:.0f}, each surface scaled to its axis"]
    assert condition > COUPLING_MAX
    assert obstacles(B, LIMITS, LINEAR, AMPLE) == found
    assert obstacles(B * [1.0, 50.0, 1.0], LIMITS, LINEAR, AMPLE) == found
    assert obstacles(np.diag([1.0, 1000.0, 0.1]), LIMITS, LINEAR, AMPLE) == []


def test_what_is_no_number_is_an_obstacle():
    # A comparison with nan is false: none may pass for want of a number.
    B = np.diag(B_OWN)
    B[1, 1] = np.nan
    assert "elevator" in obstacles(B, LIMITS, LINEAR, AMPLE)[0]
    assert "rudder" in obstacles(np.diag(B_OWN), LIMITS, np.array([0.0, 0.0, np.nan]), AMPLE)[0]
    assert "too little aileron" in obstacles(np.diag(B_OWN), LIMITS, LINEAR, np.array([np.nan, 5.0, 5.0]))[0]


def test_what_does_not_respond_is_reported_alone():
    # Of a surface without response every other number is noise: only the cause is reported, for all such surfaces.
    found = obstacles(np.diag([0.0, 0.0, 5.0]), LIMITS, LINEAR, np.zeros(3))
    assert [t.split(":")[0] for t in found] == [
        "no small-signal aileron response",
        "no small-signal elevator response",
    ]


WITHOUT = {"aileron": (False, True, True), "rudder": (True, True, False)}


@pytest.mark.parametrize(("surface", "axes"), WITHOUT.items())
def test_an_axis_without_a_surface_is_left_out(surface, axes):
    # B with a column of zeros has no inverse: what is demanded of the others is their own part's, and of it nothing
    A, B = plane(coupling=1.0)
    B[:, np.logical_not(axes)] = 0.0
    assert controlled_axes(B[3:], LIMITS) == axes
    found = authority(A, B, LIMITS, **DESIGN, axes=axes)
    own = np.flatnonzero(axes)
    part = np.ix_(own, own)
    asked = (A_M * (DESIGN["bandwidth"] * DESIGN["step"]))[part]
    np.testing.assert_allclose(found.first[own], np.abs(np.linalg.inv(B[3:][part]) @ asked).max(axis=1), rtol=1e-12)
    for values in (found.first, found.steady, found.available, found.ratio):
        np.testing.assert_array_equal(np.isnan(values), np.logical_not(axes))
    assert obstacles(B[3:], LIMITS, np.where(axes, 0.0, np.nan), found.ratio) == []


def test_without_ailerons_no_bank_is_held():
    A, B = plane()
    B[:, 0] = 0.0
    found = authority(A, B, LIMITS, **DESIGN, axes=WITHOUT["aileron"])
    assert found.beta == 0.0
    np.testing.assert_array_equal(found.steady[1:], 0.0)


def test_without_a_rudder_the_bank_is_a_turn():
    # At the reported sideslip and deflections there is one r for which side force and all three moments balance.
    A, B = plane(coupling=1.5)
    A[4, 6], A[[5, 2, 6], 6], A[6, 5], A[7, 6] = -1.0, [0.8, 0.1, -0.5], -0.3, 0.05
    B[:, 2] = 0.0
    found = authority(A, B, LIMITS, **DESIGN, axes=WITHOUT["rudder"])
    r = Y_PHI * np.radians(5.0) + Y_BETA * found.beta
    rates = A[[5, 2, 6], 6] - 0.05 * A[[5, 2, 6], 5]
    left = np.array(list(N_BETA.values())) * found.beta + rates * r + B[3:, :2] @ found.steady[:2]
    np.testing.assert_allclose(left, 0.0, atol=1e-13)


@pytest.mark.parametrize(
    ("axes", "held"),
    [((True, True, True), True), ((True, True, False), True), ((False, True, True), True),
     ((True, False, True), False), ((False, True, False), False), ((False, False, False), False)],
)  # fmt: skip
def test_pitch_and_a_lateral_axis_hold_an_attitude(axes, held):
    assert can_be_held(axes) is held


def test_the_least_response_is_at_full_deflection_or_at_1_rad_without_a_stop():
    B = np.diag([1.0, 1.0, 1.01 * RESPONSE_MIN])
    unlimited = np.array([[-np.inf, np.inf]] * 3)
    assert controlled_axes(B, unlimited) == (True, True, True)
    assert controlled_axes(0.98 * B, unlimited) == (True, True, False)
    assert controlled_axes(B, LIMITS) == (True, True, False)  # 0.4 rad of it
