"""Delay between command and surface."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uavftc.actuators import delay
from uavftc.core.program import Program
from uavftc.core.signals import EFFECTOR, ROW_WIDTH, as_records, empty_rows
from uavftc.core.stage import Block, Stage, law, records_of
from uavftc.flight.timing import timing_of
from uavftc.scenario.schema import Scenario

N = 40
COMMANDS = np.random.default_rng(11).normal(size=(N, 3))
SEEN = np.dtype([("next", "i8"), ("deflection", "f8", (8 * N,))])


@law
def pass_on(p, s, e, row):
    """Begin the plant step as the allocation does."""
    e.deflection = e.command


@law
def look(p, s, e, row):
    """Keep the deflection of each plant step, of which the row has the first only."""
    s.deflection[s.next] = e.deflection
    s.next += 1


begins, ends = Stage(pass_on), Stage(look, state=SEEN)
EACH = np.zeros(3, begins.params)


def block_of(whole, part) -> Block:
    return delay.stage.block(records_of(delay.PARAMS, 3, whole=[whole] * 3, part=[part] * 3), np.zeros((3, whole + 3)))


def delayed(whole, part, cuts=(), substeps=1):
    """Deflections at each plant step, shape (N substeps, 3); the flight is run in pieces between the cuts."""
    rows = empty_rows(N)
    effectors = as_records(rows)["effectors"]
    effectors["command"] = COMMANDS
    effectors["deflection"] = np.nan  # whatever was there before must be overwritten
    seen = np.zeros(3, SEEN)
    program = Program(
        [],
        [begins.block(EACH, name="begin"), block_of(whole, part), ends.block(state=seen, name="look")],
        substeps=substeps,
    )
    edges = [0, *sorted(cuts), N]
    for first, last in pairwise(edges):
        assert program.run(rows, first, last) == last
    every = seen["deflection"][:, : N * substeps].T
    np.testing.assert_array_equal(effectors["deflection"], every[::substeps])  # the row keeps what holds from t_k on
    return every


def shifted(steps, substeps=1):
    """Commands as they were `steps` plant steps earlier; before the first, zero."""
    held = np.repeat(COMMANDS, substeps, axis=0)
    return np.concatenate([np.zeros((steps, 3)), held])[: len(held)]


def test_zero_delay_passes_straight():
    # without delay the surface follows the command of the same sample
    np.testing.assert_array_equal(delayed(0, 0.0), COMMANDS)


@pytest.mark.parametrize("whole", [1, 2, 7, 39, 45])
def test_whole_samples_shift_the_command(whole):
    # n samples: the command of sample k - n, zero (trim) before the start
    np.testing.assert_array_equal(delayed(whole, 0.0), shifted(whole))


@pytest.mark.parametrize("steps", [1, 2, 3, 5, 8])
def test_part_of_a_sample_holds_the_older_command_first(steps):
    # three plant steps a sample: the change falls between two of them, inside the sample where 3 does not divide
    got = delayed(steps, 0.0, substeps=3)
    np.testing.assert_array_equal(got, shifted(steps, 3))
    whole, late = divmod(steps, 3)
    older, newer = (np.concatenate([np.zeros((n, 3)), COMMANDS])[:N] for n in (whole + 1, whole))
    for i in range(3):
        np.testing.assert_array_equal(got[i::3], older if i < late else newer)


@pytest.mark.parametrize("whole", [0, 1, 5])
@pytest.mark.parametrize("part", [0.2, 0.999])
@pytest.mark.parametrize("substeps", [1, 2])
def test_part_of_a_plant_step_gives_the_mean_of_the_two_commands(whole, part, substeps):
    # over a plant step the older command holds for the part f and the newer for the rest: the mean of the two
    expected = part * shifted(whole + 1, substeps) + (1.0 - part) * shifted(whole, substeps)
    np.testing.assert_allclose(delayed(whole, part, substeps=substeps), expected, rtol=1e-15, atol=1e-16)


@pytest.mark.parametrize(("whole", "part"), [(0, 0.3), (2, 0.75), (4, 0.0)])
def test_no_command_is_lost_or_counted_twice(whole, part):
    # the sum of what came out and of what is still in the line is that of the commands, also where two are blended
    still_inside = COMMANDS[N - whole :].sum(axis=0) + part * COMMANDS[N - whole - 1]
    got = delayed(whole, part).sum(axis=0)
    np.testing.assert_allclose(got + still_inside, COMMANDS.sum(axis=0), rtol=0, atol=1e-13)


@settings(deadline=None)  # the first example compiles
@given(whole=st.integers(0, 12), part=st.sampled_from([0.0, 0.5]), cuts=st.sets(st.integers(1, N - 1)))
def test_line_carries_over_between_slices(whole, part, cuts):
    # the flight is run in slices: the line must not notice
    np.testing.assert_array_equal(delayed(whole, part, cuts), delayed(whole, part))


def test_memory_has_the_room_the_law_writes_to():
    # the law lays out its own memory: what it touches must be what `blocks` allocates, a line for each effector
    for whole in (0, 1, 6):
        h = 0.005
        flight = SimpleNamespace(effectors=("a", "b", "c"), steps=N, h=h, plant_step=h)
        (block,) = delay.blocks(delay.Config(delay_s=(whole + 0.5) * h), flight)
        assert (block.params["whole"] == whole).all()
        np.testing.assert_allclose(block.params["part"], 0.5, rtol=1e-9)
        assert block.state.shape == (3, whole + 3)
        guarded = np.full(block.state.size + 100, 7.0)
        lines = guarded[50:-50].reshape(block.state.shape)
        lines[:] = 0.0
        rows = empty_rows(N)
        as_records(rows)["effectors"]["command"] = 1.0
        Program([], [begins.block(EACH, name="begin"), delay.stage.block(block.params, lines)]).run(rows, 0, N)
        np.testing.assert_array_equal(guarded[:50], 7.0)
        np.testing.assert_array_equal(guarded[-50:], 7.0)
        np.testing.assert_array_equal(lines[:, 1:], 1.0)  # all of it is in use


def test_a_delay_longer_than_the_flight_needs_no_more_memory_than_the_flight():
    # an hour of delay in a flight of a second must not ask for an hour of line, and nothing reaches the surface
    flight = SimpleNamespace(effectors=("a", "b", "c"), steps=N - 1, h=0.005, plant_step=0.005 / 2)
    (block,) = delay.blocks(delay.Config(delay_s=3600.0), flight)
    assert block.state.shape[1] <= 2 * N + 3
    rows = empty_rows(N)
    as_records(rows)["effectors"]["command"] = COMMANDS
    Program([], [begins.block(EACH, name="begin"), block], substeps=2).run(rows, 0, N)
    assert not as_records(rows)["effectors"]["deflection"].any()


def scenario(delay_s, rate_hz, substeps=None):
    return Scenario.model_validate(
        {
            "name": "d",
            "duration_s": 1,
            "controller": {"delay_s": delay_s, "rate_hz": rate_hz},
            "simulation": {"substeps": substeps},
        }
    )


@pytest.mark.parametrize(
    ("delay_s", "rate_hz", "substeps"),
    [
        (0.0, 200, 1),  # no delay
        (0.015, 200, 1),  # three samples
        (0.0025, 200, 2),  # half a sample
        (0.0125, 200, 2),  # two samples and a half
        (0.001, 200, 5),  # a fifth
        (0.024, 50, 5),  # a sample and a fifth: already four steps of 5 ms, five put the change between two
        (0.005, 50, 4),  # a quarter of a sample falls on the four steps that there are
        (0.0001, 200, 8),  # a fiftieth: no eight times finer step meets it, the finest blends
    ],
)
def test_plant_steps_are_chosen_so_that_a_delay_falls_on_them(delay_s, rate_hz, substeps):
    # then the delay is a whole number of plant steps, f = 0, and no step blends two commands
    timing = timing_of(scenario(delay_s, rate_hz))
    assert timing.substeps == substeps
    assert timing.plant_step == pytest.approx(1.0 / rate_hz / substeps, rel=1e-15)
    flight = SimpleNamespace(effectors=("a",), steps=rate_hz, h=timing.h, plant_step=timing.plant_step)
    blocks = delay.blocks(delay.Config(delay_s=delay_s), flight)
    if delay_s == 0.0:
        assert blocks == []
        return
    steps, part = blocks[0].params["whole"][0], blocks[0].params["part"][0]
    assert (steps + part) * timing.plant_step == pytest.approx(delay_s, rel=1e-6)
    assert bool(part == 0.0) is (delay_s != 0.0001)


def test_plant_steps_that_are_given_stay_as_they_are():
    # who asks for one step a sample gets it, and the blend with it
    assert timing_of(scenario(0.0025, 200, substeps=1)).substeps == 1
    assert timing_of(scenario(0.0025, 200, substeps=3)).substeps == 3


def test_each_effector_has_its_own_line():
    # one stage, one block, three memories: no command may come out on another surface
    rows = empty_rows(N)
    effectors = as_records(rows)["effectors"]
    effectors["command"] = COMMANDS
    params = records_of(delay.PARAMS, 3, whole=[0, 3, 5], part=[0.0, 0.0, 0.0])
    Program([], [begins.block(EACH, name="begin"), delay.stage.block(params, np.zeros((3, 8)))]).run(rows, 0, N)
    for j, steps in enumerate((0, 3, 5)):
        np.testing.assert_array_equal(effectors["deflection"][:, j], shifted(steps)[:, j])
    assert rows.shape[1] == ROW_WIDTH + 3 * EFFECTOR.itemsize // 8
