"""State space of the inner loop against transfer matrices written down by hand at complex frequencies."""

from __future__ import annotations

import numpy as np
import pytest

from control.paper import A_M, A_S, B_M, BANDWIDTH
from uavftc.analysis.linear import (
    C_over_H,
    G_of,
    H_of,
    HCK_of,
    StateSpace,
    complement,
    filter_C,
    initial_response,
    product,
    response,
    static,
    times_first_order,
)

OMEGA = np.array([0.5, 0.7, 1.0])
K = np.linalg.solve(B_M, A_M)
FREQUENCIES = [0.0, 0.3 + 0.2j, 5j, 60.0, 1000j]


def H(s, A):
    return np.linalg.inv(s * np.eye(3) - A) @ B_M


def C(s):
    return np.diag(BANDWIDTH * OMEGA / (s + BANDWIDTH * OMEGA))


@pytest.mark.parametrize("A", [A_S, A_M], ids=["A_s", "A_m"])
@pytest.mark.parametrize("s", FREQUENCIES)
def test_each_system_is_its_formula(s, A):
    # Eqs. (33) to (35), evaluated as written, with three different factors of effectiveness.
    own_H, own_C, eye = H_of(A, B_M), filter_C(BANDWIDTH, OMEGA), np.eye(3)
    cases = {
        "H": (own_H, H(s, A)),
        "C": (own_C, C(s)),
        "I - C": (complement(own_C), eye - C(s)),
        "G": (G_of(own_H, own_C), H(s, A) @ (eye - C(s))),
        "HCK": (HCK_of(own_H, own_C, K), H(s, A) @ C(s) @ K),
        "s (sI - A)^-1": (initial_response(A), s * np.linalg.inv(s * eye - A)),
        "C / H": (C_over_H(own_C, A, B_M), C(s) @ np.linalg.inv(B_M) @ (s * eye - A)),
    }
    for name, (system, expected) in cases.items():
        np.testing.assert_allclose(response(system, s), expected, rtol=1e-9, atol=1e-12, err_msg=name)


def test_a_product_is_in_the_order_of_matrices():
    # C and H do not commute, and a static factor has no state to hide behind.
    first, second = H_of(A_S, B_M), filter_C(BANDWIDTH, OMEGA)
    s = 2.0 + 3.0j
    np.testing.assert_allclose(response(product(first, second), s), H(s, A_S) @ C(s))
    np.testing.assert_allclose(response(product(second, first), s), C(s) @ H(s, A_S))
    np.testing.assert_allclose(response(product(static(K), second), s), K @ C(s))
    assert np.max(np.abs(H(s, A_S) @ C(s) - C(s) @ H(s, A_S))) > 0.01


def test_steady_state_gains_are_the_papers():
    # K_2 = (A_s^-1 B_m)^-1 is designed for -H(0) K_2 = I with A_s; on the plant, which has A_m, it gives A_m^-1 A_s.
    K_2 = np.linalg.solve(B_M, A_S)
    np.testing.assert_allclose(-response(H_of(A_S, B_M), 0.0) @ K_2, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(-response(H_of(A_M, B_M), 0.0) @ K, np.eye(3), atol=1e-12)
    share = np.diag(-response(H_of(A_M, B_M), 0.0) @ K_2).real
    np.testing.assert_allclose(share, np.diag(np.eye(3) + np.linalg.inv(A_M)), rtol=1e-12)  # A_s = A_m + I
    assert share[1] < 0.5  # pitch would get less than half of its command


def test_an_improper_product_is_refused():
    # s times a feed-through is a differentiator, which has no state space of this kind.
    with pytest.raises(ValueError, match="not proper"):
        times_first_order(complement(filter_C(BANDWIDTH, OMEGA)), np.eye(3), np.eye(3))
    with pytest.raises(ValueError, match="not proper"):
        times_first_order(StateSpace(*static(np.eye(3))), np.eye(3), np.eye(3))
