"""Trains of gusts: the sum of single ones, at the moments and of the signs that the equations say."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.core.signals import as_records, empty_rows
from uavftc.environment import gust_train
from uavftc.environment.gust import one_minus_cosine
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.inputs import Inputs
from uavftc.scenario.schema import Scenario

TRAIN = {"kind": "gust-train", "start_s": 1.5, "count": 4, "spacing_s": 3, "ramp_s": 0.5, "hold_s": 0.25}
PEAK = {"north_mps": 1, "east_mps": -2, "down_mps": 4}


def wind(*entries, seconds=20, seed=0):
    """Return t and the wind that a scenario prescribes."""
    given = {"name": "train", "duration_s": seconds, "seed": seed, "disturbances": [*entries]}
    inputs = Inputs(Scenario.model_validate(given), np.zeros(3))
    records = as_records(empty_rows(200 * seconds + 1))
    inputs.fill(records, 0)
    return records["t"], records["wind_n"].copy()


def sum_of(starts, signs, t):
    shape = sum(s * one_minus_cosine(t, start=at, ramp=0.5, hold=0.25) for at, s in zip(starts, signs, strict=True))
    return np.outer(shape, [1.0, -2.0, 4.0])


@pytest.mark.parametrize(("signs", "expected"), [("same", [1, 1, 1, 1]), ("alternating", [1, -1, 1, -1])])
def test_a_regular_train_is_the_sum_of_its_gusts(signs, expected):
    # each by the closed form, spacing_s after the one before
    t, found = wind({**TRAIN, **PEAK, "signs": signs})
    np.testing.assert_allclose(found, sum_of(1.5 + 3.0 * np.arange(4), expected, t), atol=1e-12)
    assert not found[t >= 1.5 + 9.0 + 1.25].any()


def test_without_a_spacing_they_are_back_to_back():
    # alternating, that is a wave of period 2 (2 ramp_s + hold_s) without a mean
    t, found = wind({**TRAIN, **PEAK, "spacing_s": None, "signs": "alternating"})
    np.testing.assert_allclose(found, sum_of(1.5 + 1.25 * np.arange(4), [1, -1, 1, -1], t), atol=1e-12)
    np.testing.assert_allclose(found.sum(axis=0), 0.0, atol=1e-9)


RANDOM = {**TRAIN, **PEAK, "count": 6, "onset": "random", "signs": "random"}


class TestRandom:
    def test_there_is_one_in_each_interval(self):
        # whole, so that none overlaps the next, and somewhere else in each
        config = gust_train.Config.model_validate(RANDOM)
        shifts = []
        for seed in range(200):
            train = gust_train.drawn(config, seed, 0)
            assert (train.start_s, train.end_s) == (1.5, 19.5)
            for i, one in enumerate(train.gusts):
                assert 1.5 + 3.0 * i <= one.start_s <= one.end_s <= 1.5 + 3.0 * (i + 1) + 1e-12
                shifts.append((one.start_s - 1.5 - 3.0 * i) / 1.75)
        # uniform on [0, 1): mean and variance of 1200 of them, four standard errors
        assert np.mean(shifts) == pytest.approx(0.5, abs=4 * np.sqrt(1 / 12 / 1200))
        assert np.var(shifts) == pytest.approx(1 / 12, abs=0.01)

    def test_signs_are_even(self):
        # 1200 of them: four standard errors of a fair coin
        config = gust_train.Config.model_validate(RANDOM)
        up = [one.down_mps > 0.0 for seed in range(200) for one in gust_train.drawn(config, seed, 0).gusts]
        assert np.mean(up) == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(1200))

    def test_the_same_seed_is_the_same_train_and_another_entry_is_another(self):
        # an entry has numbers of its own: a second one changes nothing of the first
        _, first = wind(RANDOM, seed=3)
        _, again = wind(RANDOM, seed=3)
        _, other = wind(RANDOM, seed=4)
        _, two = wind(RANDOM, {**RANDOM, "start_s": 1.0}, seed=3)
        np.testing.assert_array_equal(first, again)
        assert np.abs(first - other).max() > 1.0
        second = two - first
        assert np.abs(second - first).max() > 1.0
        config = gust_train.Config.model_validate({**RANDOM, "start_s": 1.0})
        starts = [one.start_s for one in gust_train.drawn(config, 3, 1).gusts]
        signs = [one.north_mps for one in gust_train.drawn(config, 3, 1).gusts]
        np.testing.assert_allclose(second, sum_of(starts, signs, np.arange(len(second)) / 200.0), atol=1e-12)


def test_it_is_flown():
    # from the scenario to the rows, in the flight's chunks
    train = {**TRAIN, "down_mps": -3, "count": 2, "signs": "alternating"}
    flight = build_flight(Scenario.model_validate({"name": "train", "duration_s": 8, "disturbances": [train]}))
    records, outcome = fly_to_memory(flight)
    assert outcome.completed
    t = records["t"]
    np.testing.assert_allclose(records["wind_n"], sum_of([1.5, 4.5], [1, -1], t) * [0, 0, -0.75], atol=1e-12)
    assert np.ptp(np.degrees(records["alpha"])) > 0.5
