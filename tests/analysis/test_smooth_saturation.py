"""The tanh form of the saturation: eqs. (20) to (24), on all limits and arguments."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavftc.analysis.smooth_saturation import saturated, slope, smooth, smoothing_error, smoothing_error_bound

limit = st.floats(1e-3, 1e3)
command = st.floats(-1e4, 1e4)


def printed_h(v, u_min, u_max):
    """Eq. (21), as printed with exponentials."""
    u = u_max if v >= 0.0 else abs(u_min)
    return u * (np.exp(v / u) - np.exp(-v / u)) / (np.exp(v / u) + np.exp(-v / u))


@given(v=st.floats(-20.0, 20.0), u_min=st.floats(0.1, 10.0), u_max=st.floats(0.1, 10.0))
def test_it_is_the_printed_form(v, u_min, u_max):
    assert smooth(v, -u_min, u_max) == pytest.approx(printed_h(v, -u_min, u_max), rel=1e-12, abs=1e-14)


@given(v=command, u_min=limit, u_max=limit)
def test_value_and_error_stay_within_their_bounds(v, u_min, u_max):
    # |h| never exceeds the limit on its side, and sat - h never the bound below eq. (24), with the sign of v.
    h = float(smooth(v, -u_min, u_max))
    error = float(smoothing_error(v, -u_min, u_max))
    slack = 1e-14 * max(u_min, u_max)
    assert -u_min - slack <= h <= u_max + slack
    own = (u_max if v >= 0.0 else u_min) * (1.0 - np.tanh(1.0))
    assert abs(error) <= own + slack
    assert abs(error) <= smoothing_error_bound(-u_min, u_max) + slack
    assert error * v >= -slack * abs(v)


@given(u_min=limit, u_max=limit)
def test_the_bound_is_met_at_the_limit(u_min, u_max):
    # d/dv (v - u tanh(v/u)) = tanh^2 > 0 up to the limit; beyond it h alone still grows: the largest error is there.
    assert float(smoothing_error(u_max, -u_min, u_max)) == pytest.approx(u_max * (1.0 - np.tanh(1.0)), rel=1e-12)
    assert float(smoothing_error(-u_min, -u_min, u_max)) == pytest.approx(-u_min * (1.0 - np.tanh(1.0)), rel=1e-12)
    largest = max(abs(float(smoothing_error(v, -u_min, u_max))) for v in (u_max, -u_min))
    assert largest == pytest.approx(smoothing_error_bound(-u_min, u_max), rel=1e-12)


@given(a=command, b=command, u_min=limit, u_max=limit)
def test_it_never_falls(a, b, u_min, u_max):
    low, high = min(a, b), max(a, b)
    assert smooth(low, -u_min, u_max) <= smooth(high, -u_min, u_max) + 1e-13 * max(u_min, u_max)


@given(v=command, u_min=limit, u_max=limit)
def test_h_star_is_a_gain_between_zero_and_one(v, u_min, u_max):
    # Eq. (23), the factor that the analysis takes for a loss of effectiveness; sat(v) = h* v + e_h is eq. (24).
    gain = float(slope(v, -u_min, u_max))
    assert 0.0 < gain <= 1.0
    again = gain * v + float(smoothing_error(v, -u_min, u_max))
    assert again == pytest.approx(float(saturated(v, -u_min, u_max)), rel=1e-12, abs=1e-14)


@given(u_min=limit, u_max=limit)
def test_it_is_continuous_at_zero_with_slope_one(u_min, u_max):
    # Unbalanced limits meet at 0 in value and slope: h(v) = v - v^3/(3 u^2) + ...
    assert float(slope(0.0, -u_min, u_max)) == 1.0
    assert float(smooth(0.0, -u_min, u_max)) == 0.0
    v = 1e-4 * min(u_min, u_max)
    for sign, u in ((1.0, u_max), (-1.0, u_min)):
        assert float(smooth(sign * v, -u_min, u_max)) == pytest.approx(sign * (v - v**3 / (3.0 * u**2)), rel=1e-12)


def test_figure_2_of_the_paper():
    # u_max = 1, u_min = -0.5: the curves meet far out, and are farthest apart at the limits.
    v = np.array([[-50.0, -0.5, 0.0], [0.3, 1.0, 50.0]])
    np.testing.assert_array_equal(saturated(v, -0.5, 1.0), [[-0.5, -0.5, 0.0], [0.3, 1.0, 1.0]])
    h = smooth(v, -0.5, 1.0)
    assert h.shape == v.shape
    np.testing.assert_allclose(h, [[-0.5, -0.5 * np.tanh(1.0), 0.0], [np.tanh(0.3), np.tanh(1.0), 1.0]], rtol=1e-12)
    for u_min, u_max in ((-0.5, 1.0), (-0.05, 0.1)):  # u - u tanh(1) at the larger limit
        assert smoothing_error_bound(u_min, u_max) == pytest.approx(u_max * (1.0 - np.tanh(1.0)), rel=1e-12)


def test_no_limit_is_no_saturation():
    v = np.array([-3.0, 0.0, 7.0])
    np.testing.assert_array_equal(smooth(v, -np.inf, np.inf), v)
    np.testing.assert_array_equal(smoothing_error(v, -np.inf, np.inf), 0.0)


@pytest.mark.parametrize("limits", [(0.0, 1.0), (-1.0, 0.0), (0.1, 0.2), (np.nan, 1.0)])
def test_limits_on_one_side_of_zero_are_refused(limits):
    with pytest.raises(ValueError, match="u_min < 0 < u_max"):
        smooth(0.1, *limits)
