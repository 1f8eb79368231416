"""The basis functions of eq. (10)."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import paper
from uavftc.control.rbf import NODES, basis

ANGLES = st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3).map(np.array)


def evaluated(x1, x2, psi_0=0.0, centres=paper.CENTRES, width=paper.WIDTH):
    Phi = np.full(NODES, np.nan)
    basis(np.asarray(x1, float), np.asarray(x2, float), psi_0, np.ones(3), np.asarray(centres, float), width, Phi)
    return Phi


@settings(deadline=None)  # the first example compiles
@given(x1=ANGLES, x2=ANGLES, psi_0=st.floats(-7.0, 7.0))
def test_basis_is_the_formula(x1, x2, psi_0):
    # every one of the six inputs counts, the heading relative to the start
    np.testing.assert_allclose(evaluated(x1, x2, psi_0), paper.phi(x1, x2, psi_0), rtol=1e-12, atol=1e-300)


def test_heading_counts_from_the_start():
    # on another heading the network must see the same inputs, or it would vanish there
    x1, x2 = np.array([0.1, -0.05, 0.02]), np.array([0.01, 0.02, -0.03])
    turned = x1 + np.array([0.0, 0.0, 2.5])
    np.testing.assert_allclose(evaluated(turned, x2, 2.5), evaluated(x1, x2, 0.0), rtol=1e-13)
    assert evaluated(turned, x2, 0.0).max() < 1e-6  # what would happen without


def test_value_is_one_at_a_centre_and_falls_with_the_width():
    # value 1 at z = l_i; one width away in one input exp(-1/2)
    for i, centre in enumerate(paper.CENTRES):
        assert evaluated([centre] * 3, [centre] * 3)[i] == 1.0
    assert evaluated([0.4, 0, 0], [0, 0, 0])[2] == np.exp(-0.5)
    np.testing.assert_allclose(evaluated([0, 0, 0], [0, 0, 1.0], width=2.0)[2], np.exp(-1 / 8), rtol=1e-15)
    assert np.isnan(evaluated([np.nan, 0, 0], [0, 0, 0])).all()  # a broken sensor is not hidden
