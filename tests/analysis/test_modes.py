"""Naming of modes, on matrices and modes printed in textbooks.

Navion: R. C. Nelson, Flight Stability and Automatic Control, 2nd ed., examples 4.3 and 5.1 (ft, s).
Boeing 747 at Mach 0.8, 40 000 ft: B. Etkin and L. D. Reid, Dynamics of Flight, 3rd ed., sections 6.2 and 6.7 (ft, s).
Both print w and v, ft/s, where this project has alpha and beta: the naming must not depend on the units.
"""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.analysis.modes import lateral, longitudinal, modes, participation

NAVION_LONG = [[-0.045, 0.036, 0, -32.2], [-0.369, -2.02, 176, 0], [0.0019, -0.0396, -2.948, 0], [0, 0, 1, 0]]
NAVION_LAT = [[-0.254, 0, -1.0, 0.182], [-16.02, -8.40, 2.19, 0], [4.488, -0.350, -0.760, 0], [0, 1, 0, 0]]
B747_LONG = [
    [-0.006868, 0.01395, 0, -32.2], [-0.09055, -0.3151, 773.98, 0], [0.0001187, -0.001026, -0.4285, 0], [0, 0, 1, 0]
]  # fmt: skip
B747_LAT = [
    [-0.0558, 0, -774, 32.2], [-0.003865, -0.4342, 0.4136, 0], [0.001086, -0.006112, -0.1458, 0], [0, 1, 0, 0]
]  # fmt: skip
PRINTED = {
    "navion longitudinal": (
        longitudinal, NAVION_LONG, {"short period": (-2.5 + 2.59j, 0.02), "phugoid": (-0.017 + 0.213j, 0.002)}
    ),
    "navion lateral": (
        lateral, NAVION_LAT,
        {"dutch roll": (-0.487 + 2.335j, 0.02), "roll": (-8.435, 0.02), "spiral": (-0.00877, 0.0005)},
    ),
    "747 longitudinal": (
        longitudinal, B747_LONG,
        {"short period": (-0.3719 + 0.8875j, 0.0005), "phugoid": (-0.003289 + 0.06723j, 0.0001)},
    ),
    "747 lateral": (
        lateral, B747_LAT,
        {"dutch roll": (-0.033011 + 0.94655j, 0.001), "roll": (-0.56248, 0.001), "spiral": (-0.0072973, 0.0001)},
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", PRINTED)
def test_modes_are_those_of_the_textbook(case):
    function, A, printed = PRINTED[case]
    found = {mode.name: mode for mode in function(np.array(A, dtype=float))}
    assert set(found) == set(printed)
    for name, (value, tolerance) in printed.items():
        assert abs(found[name].eigenvalue - value) < tolerance, name


def test_frequency_damping_and_time_constant():
    # 747, Etkin and Reid, tables 6.1 and 6.5: phugoid period 93.4 s and damping 0.0489, roll falls to half in 1.23 s.
    phugoid = next(m for m in longitudinal(np.array(B747_LONG)) if m.name == "phugoid")
    assert 2 * np.pi / phugoid.eigenvalue.imag == pytest.approx(93.4, rel=0.01)
    assert phugoid.damping == pytest.approx(0.0489, rel=0.02)
    assert phugoid.natural_frequency == pytest.approx(abs(phugoid.eigenvalue))
    roll = next(m for m in lateral(np.array(B747_LAT)) if m.name == "roll")
    assert roll.time_constant * np.log(2.0) == pytest.approx(1.23, rel=0.01)
    assert roll.damping == 1.0


def test_the_units_of_the_states_do_not_matter():
    # Speeds in m/s, angles in deg, rates in deg/s: T A T^-1 has the same modes with the same names.
    A, T = np.array(NAVION_LAT), np.diag([57.3, 0.01, 40.0, 3.0])
    for a, b in zip(lateral(A), lateral(T @ A @ np.linalg.inv(T)), strict=True):
        assert a.name == b.name
        assert a.eigenvalue == pytest.approx(b.eigenvalue)
    np.testing.assert_allclose(participation(A)[1].sum(axis=0), 1.0)


def test_a_pair_that_became_two_real_modes_says_so():
    # The Navion's short period with a centre of gravity so far aft that M_w > 0: one mode grows.
    A = np.array(NAVION_LONG)
    A[2, 1] = 0.04
    names = [mode.name for mode in longitudinal(A)]
    assert names.count("short period (aperiodic)") == 2
    # and with much damping in pitch both decay
    A = np.array(NAVION_LONG)
    A[2, 2] = -12.0
    found = longitudinal(A)
    assert [mode.name for mode in found] == ["short period (aperiodic)"] * 2 + ["phugoid"]
    assert all(mode.eigenvalue.real < 0 for mode in found)


def test_an_unstable_mode_has_a_negative_time_constant():
    A = np.array(NAVION_LAT)
    A[1, 0] = -2.0  # little dihedral
    spiral = next(mode for mode in lateral(A) if mode.name == "spiral")
    assert spiral.eigenvalue.real > 0
    assert spiral.time_constant < 0
    assert spiral.damping == -1.0


def test_roll_and_spiral_may_merge():
    # Strong dihedral with little roll damping: the lateral phugoid of Etkin and Reid, section 6.8.
    A = np.array(NAVION_LAT)
    A[1, 0], A[1, 1], A[1, 2] = -30.0, -0.05, 6.0
    names = {mode.name for mode in lateral(A)}
    assert names <= {"dutch roll", "roll-spiral", "roll", "spiral", "dutch roll (aperiodic)"}
    A = np.zeros((4, 4))
    A[:2, :2] = [[-0.5, 2.0], [-2.0, -0.5]]  # beta, p coupled ...
    A[2:, 2:] = [[-0.1, 0.3], [-0.3, -0.1]]  # ... and r, phi: neither is pure
    assert len(lateral(A)) == 2


def test_of_zeros_there_are_modes_too():
    found = modes(np.zeros((8, 8)))
    assert len(found) == 8
    assert all(mode.time_constant is None and mode.damping is None for mode in found)
