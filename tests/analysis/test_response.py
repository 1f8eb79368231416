"""The time to 63 % of a step, against the closed form of a loop of first order."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.analysis.response import response_s, unequal

t = np.arange(0.0, 20.0, 0.005)


def history(x: np.ndarray, reference: np.ndarray) -> dict[str, np.ndarray]:
    return {"time_s": t, "phi_rad": x, "phi_ref_rad": reference}


@pytest.mark.parametrize("time_constant", [0.3, 2.0, 9.0])
@pytest.mark.parametrize("step", [0.1, -0.05])
def test_a_loop_of_first_order_has_63_percent_after_its_time_constant(time_constant: float, step: float) -> None:
    # interpolated between samples of 5 ms: the curvature over one leaves less than (h/T)^2 T/8 of error
    x = 0.02 + step * (1.0 - np.exp(-t / time_constant))
    found = response_s(history(x, np.full_like(t, 0.02 + step)), "roll")
    assert found == pytest.approx(time_constant, abs=0.005**2 / time_constant / 8.0 + 1e-12)


def test_what_is_no_step_at_the_start_has_no_time() -> None:
    x = 0.1 * (1.0 - np.exp(-t))
    assert response_s(history(x, 0.1 * np.ones_like(t) * (1.0 + 0.01 * np.sin(t))), "roll") is None  # it moves
    assert response_s(history(np.zeros_like(t), np.zeros_like(t)), "roll") is None  # no step
    assert response_s(history(0.5 * x, 0.1 * np.ones_like(t)), "roll") is None  # never so far


def test_loops_of_other_speed_are_named_on_the_axis_where_they_differ_most() -> None:
    line = unequal({"a": {"roll": 2.0, "pitch": 1.0, "yaw": None}, "b": {"roll": 1.5, "pitch": 3.0, "yaw": 1.0}})
    assert line is not None
    assert "pitch has 63 % of its step after a 1.00 s, b 3.00 s" in line
    assert unequal({"a": {"roll": 2.0}, "b": {"roll": 1.7}}) is None
