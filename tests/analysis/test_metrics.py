"""The metrics against closed forms, and chunk by chunk against the whole."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc.analysis.metrics import CONVERGENCE_BAND_DEG, INTEGRALS, Metrics, controlled_of, metrics_of
from uavftc.core.signals import AXES, as_records, empty_rows

BAND = np.radians(CONVERGENCE_BAND_DEG)
RATE = 200.0


def flight(error, t=None, v2=None):
    """Rows with a given attitude error, (n, 3) or (n,) for all axes, rad."""
    error = np.asarray(error, float)
    error = error if error.ndim == 2 else np.repeat(error[:, None], 3, axis=1)
    records = as_records(empty_rows(len(error)))
    records["t"] = np.arange(len(error)) / RATE if t is None else t
    records["x1_c"] = 0.1
    records["x1"] = records["x1_c"] - error
    if v2 is not None:
        records["v2"] = v2
    return records


def chunked(records, cuts):
    metrics = Metrics()
    for part in np.split(records, sorted(cuts)):
        metrics.take(part)
    return metrics.axes()


def test_integrals_of_an_exponential_are_the_closed_forms():
    # e = e0 exp(-D t) on [0, T]; sampled at 200 Hz the trapezoidal rule is off by (D h)^2/12, 1e-6
    e0, D, T = np.radians([5.0, -3.0, 1.0]), np.array([0.5, 0.8, 0.3]), 20.0
    t = np.arange(round(T * RATE) + 1) / RATE
    result = metrics_of(flight(e0 * np.exp(-np.outer(t, D))))
    for i, axis in enumerate(AXES):
        a, d = abs(e0[i]), D[i]

        def first(k, scale):  # int_0^T scale exp(-k t) dt
            return scale / k * (1.0 - math.exp(-k * T))

        def moment(k, scale):  # int_0^T scale t exp(-k t) dt
            return scale / k**2 * (1.0 - (1.0 + k * T) * math.exp(-k * T))

        expected = [first(d, a), first(2 * d, a**2), moment(d, a), moment(2 * d, a**2)]
        np.testing.assert_allclose([result[axis][name] for name in INTEGRALS], expected, rtol=2e-5)
        assert result[axis]["steady_state_error_deg"] == pytest.approx(math.degrees(a) * math.exp(-d * T), rel=1e-9)
        crossing = math.log(math.degrees(a) / CONVERGENCE_BAND_DEG) / d
        if crossing < T:
            assert result[axis]["convergence_time_s"] == pytest.approx(math.ceil(crossing * RATE) / RATE, abs=1e-12)
        else:
            assert result[axis]["convergence_time_s"] is None
    assert [result[a]["convergence_time_s"] is None for a in AXES] == [False, False, False]


def test_IAE_of_the_papers_step_is_e0_over_D():
    # 5 deg and D = 0.5 give 0.1745 rad s: the reading on which Table 2 can be met at all
    t = np.arange(100 * 200 + 1) / RATE
    iae = metrics_of(flight(np.radians(5.0) * np.exp(-0.5 * t)))["roll"]["iae"]
    assert iae == pytest.approx(np.radians(5.0) / 0.5, rel=1e-6)


def test_trapezoid_is_exact_on_piecewise_linear_errors_and_uneven_times():
    # |e| linear between rows of one sign: IAE has no error at all, whatever the spacing of the rows
    t = np.array([0.0, 0.1, 0.5, 0.6, 2.0])
    e = np.array([1.0, 0.0, -0.5, -0.25, 0.0])
    expected = 0.1 * 0.5 + 0.4 * 0.25 + 0.1 * 0.375 + 1.4 * 0.125
    assert metrics_of(flight(e, t=t))["pitch"]["iae"] == pytest.approx(expected, rel=1e-14)
    # a constant error makes ISE exact, and t e, t e^2 linear: ITAE and ITSE exact as well
    constant = metrics_of(flight(np.full(5, -0.5), t=t))["yaw"]
    np.testing.assert_allclose([constant[name] for name in INTEGRALS], [1.0, 0.5, 1.0, 0.5], rtol=1e-14)


RNG = np.random.default_rng(13)
WHOLE = flight(RNG.normal(size=(300, 3)) * np.exp(-0.05 * np.arange(300))[:, None] * 0.01, v2=RNG.normal(size=(300, 3)))


@settings(deadline=None)
@given(cuts=st.lists(st.integers(0, 300), max_size=40))
def test_chunks_give_what_the_whole_gives(cuts):
    # long flights are handed on in chunks, empty ones and single rows included
    whole, parts = metrics_of(WHOLE), chunked(WHOLE, cuts)
    for axis in AXES:
        assert parts[axis]["convergence_time_s"] == whole[axis]["convergence_time_s"]
        for name, value in whole[axis].items():
            assert parts[axis][name] == pytest.approx(value, rel=1e-12), name
    assert all(whole[axis]["convergence_time_s"] for axis in AXES)  # neither None nor zero


@settings(deadline=None)
@given(outside=st.lists(st.booleans(), min_size=1, max_size=12), cuts=st.lists(st.integers(0, 12), max_size=5))
def test_convergence_time_is_that_of_the_first_row_after_the_last_one_outside(outside, cuts):
    # 0 if never outside, None if outside in the last row: for any pattern of leaving and coming back, in any chunks
    records = flight(np.where(outside, 1.5 * BAND, 0.5 * BAND) * np.resize([1.0, -1.0], len(outside)))
    expected: float | None
    if not any(outside):
        expected = 0.0
    elif outside[-1]:
        expected = None
    else:
        expected = (len(outside) - outside[::-1].index(True)) / RATE
    result = chunked(records, [c for c in cuts if c <= len(outside)])
    assert [result[axis]["convergence_time_s"] for axis in AXES] == [expected] * 3


def test_band_is_two_hundredths_of_a_degree():
    # the unit in which the printed convergence times fit
    inside, outside = flight(np.radians([0.0199] * 3)), flight(np.radians([0.0201] * 3))
    assert metrics_of(inside)["roll"]["convergence_time_s"] == 0.0
    assert metrics_of(outside)["roll"]["convergence_time_s"] is None


def test_axes_are_kept_apart():
    # one axis outside says nothing about the others
    error = np.zeros((10, 3))
    error[:6, 1] = error[:, 2] = 2.0 * BAND
    result = metrics_of(flight(error))
    assert [result[a]["convergence_time_s"] for a in AXES] == [0.0, 6 / RATE, None]
    assert result["roll"]["iae"] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("turns", [-2, 0, 1, 5])
def test_heading_error_is_wrapped_and_bank_is_not(turns):
    # psi is continuous: a vehicle that has turned a whole circle is not a circle off
    records = flight(np.full((3, 3), np.radians(1.0)))
    records["x1"][:, 2] += 2.0 * np.pi * turns
    result = metrics_of(records)
    assert result["yaw"]["steady_state_error_deg"] == pytest.approx(1.0, abs=1e-9)
    records["x1"][:, 0] += 2.0 * np.pi
    assert metrics_of(records)["roll"]["steady_state_error_deg"] == pytest.approx(359.0, abs=1e-9)


def test_heading_across_south_is_two_degrees_not_358():
    # commanded 179 deg, flown -179 deg
    records = flight(np.zeros((3, 3)))
    records["x1_c"][:, 2], records["x1"][:, 2] = np.radians(179.0), np.radians(-179.0)
    assert metrics_of(records)["yaw"]["steady_state_error_deg"] == pytest.approx(2.0, abs=1e-9)


def test_lost_flight_has_no_steady_state_and_no_convergence_time():
    # what it did until then counts; what it would have reached is unknown
    metrics = Metrics()
    metrics.take(flight(np.full(5, 0.1)))
    result = metrics.axes(completed=False)["pitch"]
    assert result["steady_state_error_deg"] is None
    assert result["convergence_time_s"] is None
    assert result["iae"] == pytest.approx(0.1 * 4 / RATE, rel=1e-14)


def test_what_is_not_finite_is_none():
    # JSON has no nan
    error = np.zeros((3, 3))
    error[1, 0] = np.nan
    result = metrics_of(flight(error))
    assert [result["roll"][name] for name in INTEGRALS] == [None] * 4
    assert result["roll"]["steady_state_error_deg"] == pytest.approx(0.0, abs=1e-12)
    assert result["pitch"]["iae"] == pytest.approx(0.0, abs=1e-12)


def test_control_activity_is_the_total_variation_of_the_command():
    # sum of |steps| of v2, before saturation: 4 x amplitude a period of a sine, |end - start| of a ramp
    t = np.arange(2001) / RATE
    v2 = np.stack([0.1 * np.sin(2 * np.pi * t), 0.02 * t, np.zeros_like(t)], axis=1)
    result = metrics_of(flight(np.zeros(2001), v2=v2))
    measured = [result[axis]["control_activity_rad"] for axis in AXES]
    np.testing.assert_allclose(measured, [4 * 0.1 * 10, 0.02 * 10, 0.0], rtol=1e-12)


def test_no_row_at_all_is_no_result_but_no_error():
    # a flight lost in its first row has no error to measure
    metrics = Metrics()
    metrics.take(flight(np.zeros((0, 3))))
    assert metrics.axes(completed=False)["roll"]["steady_state_error_deg"] is None
    assert metrics.axes(completed=True)["roll"]["steady_state_error_deg"] is None


def test_taking_leaves_the_rows_alone():
    # the rows belong to the flight, other recorders read them too
    before = WHOLE.copy()
    metrics_of(WHOLE)
    np.testing.assert_array_equal(WHOLE, before)


def test_an_axis_that_is_not_controlled_has_no_metric():
    # and the others are what they are without it
    records = flight(0.1 * np.exp(-np.arange(200) / RATE), v2=0.0)
    axes = metrics_of(records, controlled=(True, True, False))
    assert set(axes["yaw"].values()) == {None}
    assert {axis: axes[axis] for axis in AXES[:2]} == {axis: metrics_of(records)[axis] for axis in AXES[:2]}
    assert controlled_of(axes) == (True, True, False)
    assert controlled_of(metrics_of(records)) == (True, True, True)
    lost_at_once = metrics_of(records[:1], completed=False)
    assert controlled_of(lost_at_once) == (True, True, True)  # nothing was flown: no axis is missing for that
