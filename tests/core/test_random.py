"""Random numbers inside a law: the published answers of the generator, distributions, and streams that stay apart."""

from __future__ import annotations

import itertools

import numba
import numpy as np
import pytest
from scipy import stats

from uavftc.core import random
from uavftc.core.program import Program
from uavftc.core.random import key, normal, philox, philox_words, stream, uniform
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import Stage, law, params_of

N = 200_000


@numba.njit
def drawn(k, first, n, is_normal):
    found = np.empty(n)
    for i in range(n):
        found[i] = normal(k, first + i) if is_normal else uniform(k, first + i)
    return found


def words(text: str) -> list[np.uint64]:
    return [np.uint64(int(word, 16)) for word in text.split()]


ANSWERS = {  # kat_vectors of the Random123 library: philox4x32 10, counter, key -> words
    "zeros": ("0 0 0 0", "0 0", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    "ones": ("ffffffff " * 4, "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    "pi": ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
}


@pytest.mark.parametrize("name", ANSWERS)
@pytest.mark.parametrize("function", [philox_words, getattr(philox_words, "py_func", philox_words)])
def test_the_words_are_the_published_answers(name, function):
    # compiled and in plain Python
    counter, k, expected = (words(text) for text in ANSWERS[name])
    assert list(function(*counter, *k)) == expected


def test_key_and_counter_are_words_of_the_generator_low_one_first():
    k, counter = 0x123456789ABCDEF0, 0x0FEDCBA987654321
    low, high = 0xFFFFFFFF, 32
    halves = [np.uint64(x) for x in (counter & low, counter >> high, 0, 0, k & low, k >> high)]
    assert philox(np.uint64(k), np.uint64(counter)) == philox_words(*halves)


def test_normal_numbers_are_normal():
    # four moments to four standard errors, the whole distribution, and no memory from one to the next
    x = drawn(key(7, "test"), 0, N, True)
    assert abs(x.mean()) < 4.0 / np.sqrt(N)
    assert abs(x.var() - 1.0) < 4.0 * np.sqrt(2.0 / N)
    assert abs(stats.skew(x)) < 4.0 * np.sqrt(6.0 / N)
    assert abs(stats.kurtosis(x)) < 4.0 * np.sqrt(24.0 / N)
    assert stats.kstest(x, "norm").pvalue > 0.01
    for lag in (1, 2, 3, 4, 7):
        assert abs(np.mean(x[lag:] * x[:-lag])) < 4.0 / np.sqrt(N)


def test_uniform_numbers_are_uniform_and_never_an_end():
    u = drawn(key(7, "test"), 0, N, False)
    assert stats.kstest(u, "uniform").pvalue > 0.01
    assert 0.0 < u.min() < 1e-4
    assert 1.0 - 1e-4 < u.max() < 1.0
    # the ends of what two words can give: the logarithm of it is finite
    unit = getattr(random._unit, "py_func", random._unit)
    ends = unit(np.uint64(0), np.uint64(0)), unit(np.uint64(0xFFFFFFFF), np.uint64(0xFFFFFFFF))
    assert ends[0] == 2.0**-53
    assert ends[1] == 1.0 - 2.0**-53


@pytest.mark.parametrize("other", [(8, "test", 0), (7, "tesu", 0), (7, "test", 1), (7 + 2**32, "test", 0)])
def test_another_seed_effect_or_index_is_another_stream(other):
    # keys differ in every half, numbers are uncorrelated; the numpy streams too
    x, y = drawn(key(7, "test"), 0, N, True), drawn(key(*other), 0, N, True)
    assert abs(np.mean(x * y)) < 4.0 / np.sqrt(N)
    a, b = stream(7, "test").normal(size=N), stream(*other).normal(size=N)
    assert abs(np.mean(a * b)) < 4.0 / np.sqrt(N)
    np.testing.assert_array_equal(stream(*other).normal(size=9), stream(*other).normal(size=9))


def test_the_streams_are_these_and_stay_these():
    # a flight of last year is repeated by its seed
    assert int(key(0, "gyro noise", 2)) == KEY
    np.testing.assert_allclose([normal(np.uint64(KEY), n) for n in range(3)], NORMAL, rtol=1e-13)


KEY, NORMAL = 7243560485361554434, [1.1948672570711658, 0.5202906214872502, 0.7301098178256643]


PARAMS, STATE = np.dtype([("key", "u8")]), np.dtype([("n", "i8")])


@law
def noise(p, s, row):
    """Write the next number of a stream into the row, as a law does."""
    row.x2_meas[0] = normal(p.key, s.n)
    s.n += 1


def test_a_law_draws_the_same_in_one_run_in_pieces_and_in_plain_python():
    stage = Stage(noise, PARAMS, STATE)
    found = []
    for pieces in ([0, 100], [0, 1, 37, 100]):
        rows = empty_rows(100)
        program = Program([stage.block(params_of(PARAMS, key=key(3, "x")))])
        for first, last in itertools.pairwise(pieces):
            program.run(rows, first, last)
        found.append(as_records(rows)["x2_meas"][:, 0].copy())
    np.testing.assert_array_equal(found[0], found[1])
    plain = [getattr(normal, "py_func", normal)(key(3, "x"), n) for n in range(100)]
    np.testing.assert_allclose(found[0], plain, rtol=1e-13)
