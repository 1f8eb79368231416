"""Intervals of a share and McNemar's test against scipy, printed values and counted coins."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import binomtest

from uavftc.analysis.proportion import mcnemar, width, wilson


@pytest.mark.parametrize(("k", "n"), [(0, 1), (0, 30), (7, 30), (30, 30), (999, 1000), (5, 10_000)])
def test_the_interval_is_that_of_scipy(k, n):
    theirs = binomtest(k, n).proportion_ci(confidence_level=0.95, method="wilson")
    assert [float(end) for end in wilson(k, n)] == pytest.approx([theirs.low, theirs.high], abs=1e-14)


def test_intervals_of_several_at_once_are_those_of_each():
    low, high = wilson([0, 7, 30], [30, 30, 30])
    assert [(float(a), float(b)) for a, b in zip(low, high, strict=True)] == [
        tuple(float(end) for end in wilson(k, 30)) for k in (0, 7, 30)
    ]


def test_without_a_flight_nothing_is_known():
    assert [float(end) for end in wilson(0, 0)] == [0.0, 1.0]
    assert float(width(0, 0)) == 1.0


def test_where_all_succeed_the_width_is_that_of_the_closed_form():
    # k = n: from n/(n + z^2) to 1, so 0.02 takes z^2 (1/0.02 - 1) = 188.2 flights
    z2 = 1.959963984540054**2
    assert float(width(188, 188)) == pytest.approx(z2 / (188 + z2), rel=1e-12)
    assert float(width(188, 188)) > 0.02 >= float(width(189, 189))


def test_mcnemar_counts_coins():
    # ten cases in which they differ, one of them for the second: two tails of 1 + 10 outcomes of 1024
    assert mcnemar(9, 1) == pytest.approx(2 * 11 / 1024, rel=1e-12)
    assert mcnemar(9, 1) == mcnemar(1, 9)
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(5, 5) == 1.0
    assert math.isclose(mcnemar(20, 0), 2.0**-19, rel_tol=1e-12)


def test_the_interval_covers_the_truth_about_as_often_as_it_says():
    # exactly, over all outcomes of 50 flights that succeed with probability 0.9
    from scipy.stats import binom

    k = np.arange(51)
    low, high = wilson(k, 50)
    covered = float(binom.pmf(k, 50, 0.9)[(low <= 0.9) & (high >= 0.9)].sum())
    assert covered == pytest.approx(0.95, abs=0.03)
