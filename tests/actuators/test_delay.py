"""Delay between command and surface."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc.actuators import delay
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import Block, Program, params_of

N = 40
COMMANDS = np.random.default_rng(11).normal(size=(N, 3))


def block_of(whole, part) -> Block:
    return delay.stage.block(params_of(delay.PARAMS, whole=whole, partial=part), delay.memory(whole))


def delayed(whole, part, cuts=()):
    """u2 and u2_late of all rows; the flight is run in pieces between the cuts."""
    rows = empty_rows(N)
    records = as_records(rows)
    records["v2"] = COMMANDS
    records["u2"] = records["u2_late"] = np.nan  # whatever was there before must be overwritten
    program = Program([block_of(whole, part)])
    edges = [0, *sorted(cuts), N]
    for first, last in pairwise(edges):
        assert program.run(rows, first, last) == last
    return records["u2"].copy(), records["u2_late"].copy()


def shifted(samples):
    """Commands as they were `samples` earlier; before the first, zero."""
    return np.concatenate([np.zeros((samples, 3)), COMMANDS])[:N]


def test_zero_delay_passes_straight():
    # without delay the surface follows the command of the same sample, in the whole of it
    u2, late = delayed(0, 0.0)
    np.testing.assert_array_equal(u2, COMMANDS)
    np.testing.assert_array_equal(late, COMMANDS)


@pytest.mark.parametrize("whole", [1, 2, 7, 39, 45])
def test_whole_samples_shift_the_command(whole):
    # n samples: the command of sample k - n, zero (trim) before the start; nothing changes inside a sample
    u2, late = delayed(whole, 0.0)
    np.testing.assert_array_equal(u2, shifted(whole))
    np.testing.assert_array_equal(late, shifted(whole))


@pytest.mark.parametrize("whole", [0, 1, 5])
@pytest.mark.parametrize("part", [0.2, 0.999])
def test_part_of_a_sample_holds_the_older_command_first(whole, part):
    # n + f samples: from t_k the command of k - n - 1, from t_k + f h that of k - n
    u2, late = delayed(whole, part)
    np.testing.assert_array_equal(u2, shifted(whole + 1))
    np.testing.assert_array_equal(late, shifted(whole))


@settings(deadline=None)  # the first example compiles
@given(whole=st.integers(0, 12), part=st.sampled_from([0.0, 0.5]), cuts=st.sets(st.integers(1, N - 1)))
def test_line_carries_over_between_slices(whole, part, cuts):
    # the flight is run in slices: the line must not notice
    for got, expected in zip(delayed(whole, part, cuts), delayed(whole, part), strict=True):
        np.testing.assert_array_equal(got, expected)


def test_memory_has_the_room_the_law_writes_to():
    # the law lays out its own memory: what it touches must be what `memory` allocates
    for whole in (0, 1, 6):
        guarded = np.full(delay.memory(whole).size + 100, 7.0)
        line = guarded[50:-50]
        line[:] = 0.0
        rows = empty_rows(N)
        as_records(rows)["v2"] = 1.0
        Program([delay.stage.block(params_of(delay.PARAMS, whole=whole, partial=0.5), line)]).run(rows, 0, N)
        np.testing.assert_array_equal(guarded[:50], 7.0)
        np.testing.assert_array_equal(guarded[-50:], 7.0)
        np.testing.assert_array_equal(line[3:], 1.0)  # all of it is in use
