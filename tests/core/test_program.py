"""Programs: the order of the blocks, plant steps, what ends a run, and what a flight's laws read and write."""

from __future__ import annotations

import numpy as np
import pytest

from uavftc.actuators import effectiveness, saturation
from uavftc.control import allocation
from uavftc.core.flow import PRESCRIBED, check_flow
from uavftc.core.program import RAISED, STEP_FAILED, Program
from uavftc.core.signals import ROW, as_records, empty_rows
from uavftc.core.stage import NOTHING, PythonBlock, Stage, StepFailed, law, params_of, records_of
from uavftc.flight import envelope
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario
from uavftc.sensors import bias, exact

COUNT = np.dtype([("calls", "f8"), ("last", "f8")])


@law
def counting(p, s, row):
    """Count the calls, and leave the count in the row."""
    s.calls += 1.0
    row.throttle = s.calls


@law
def counting_effector(p, s, e, row):
    """Count the calls on this effector, and leave the count in it."""
    s.calls += 1.0
    e.deflection = s.calls
    s.last = row.throttle


@law
def raises_after(p, s, row):
    """Raise at the third call."""
    s.calls += 1.0
    if s.calls >= 3.0:
        raise ValueError("the third")


@law
def raises_on_an_effector(p, s, e, row):
    """Raise at the third call on an effector that is marked."""
    s.calls += p.nothing
    if s.calls >= 3.0:
        raise ValueError("the third")


count, count_effector = Stage(counting, NOTHING, COUNT), Stage(counting_effector, NOTHING, COUNT)
third, third_effector = Stage(raises_after, NOTHING, COUNT), Stage(raises_on_an_effector, NOTHING, COUNT)


def limits(low, high, name="limits"):
    return saturation.stage.block(records_of(saturation.PARAMS, 3, u_min=[low] * 3, u_max=[high] * 3), name=name)


def doubled(n=3):
    """Rows of which each deflection is 5 and each effectiveness 2."""
    rows = empty_rows(n)
    records = as_records(rows)
    records["effectors"]["deflection"], records["effectors"]["effectiveness"] = 5.0, 2.0
    return rows, records["effectors"]["deflection"], effectiveness.stage.block(np.zeros(3, NOTHING))


def test_a_row_with_too_few_effectors_is_refused_before_anything_is_written_past_its_end():
    rows = empty_rows(2, 3)
    block = allocation.MIXED[0].block(np.zeros(4, allocation.MIXED_PARAMS), name="four")
    with pytest.raises(ValueError, match=f"four acts on more records than a row of {8 * rows.shape[1]} bytes has"):
        Program([block]).run(rows, 0, 2)


def test_blocks_run_in_order():
    # limit then double is not double then limit
    for order, expected in ((1, 2.0), (-1, 1.0)):
        rows, deflection, double = doubled()
        assert Program([limits(-1.0, 1.0), double][::order]).run(rows, 0, 3) == 3
        np.testing.assert_array_equal(deflection, expected)


def test_only_the_rows_asked_for_are_run():
    # first is included, last is not; an empty range does nothing
    rows, deflection, _ = doubled(6)
    program = Program([limits(-1.0, 1.0)])
    assert program.run(rows, 2, 4) == 4
    np.testing.assert_array_equal(deflection[:, 0], [5.0, 5.0, 1.0, 1.0, 5.0, 5.0])
    assert program.run(rows, 4, 4) == 4
    np.testing.assert_array_equal(deflection[4:], 5.0)


def test_a_bound_program_is_that_of_its_rows():
    # bound once for a chunk and called every sample; the rows of the next chunk are bound anew
    program = Program([count.block()])
    first, second = empty_rows(2), empty_rows(2)
    run = program.on(first)
    assert program.on(first) is run
    assert run(0, 2) == 2
    assert program.on(second)(1, 2) == 2
    np.testing.assert_array_equal(as_records(first)["throttle"], [1.0, 2.0])
    np.testing.assert_array_equal(as_records(second)["throttle"], [0.0, 3.0])


def test_program_stops_at_the_row_whose_status_is_set():
    # the row is finished, the ones after it are not begun, and its index is returned
    rows, deflection, _ = doubled(10)
    records = as_records(rows)
    records["height"] = 1.0
    records["height"][4] = -1.0
    watch = params_of(envelope.PARAMS, bank_max=1.0, pitch_max=1.0, airspeed_min=-1.0, airspeed_max=1.0)
    program = Program([envelope.stage.block(watch), limits(-1.0, 1.0)])
    assert program.run(rows, 0, 10) == 4
    np.testing.assert_array_equal(deflection[:, 0], [1.0] * 5 + [5.0] * 5)
    assert records["status"][4] == envelope.GROUND
    assert program.why(envelope.GROUND) is None  # the vehicle is lost, no law has failed
    assert program.run(rows, 5, 10) == 10


def test_empty_program_runs():
    # no block is a program too
    assert Program([]).run(empty_rows(3), 0, 3) == 3


def test_two_blocks_of_one_stage_keep_their_own_memory():
    # the saturation serves for the stops as well: the stage is shared, its parameters are not
    rows = empty_rows(1)
    effectors = as_records(rows)[0]["effectors"]
    effectors["deflection"] = [5.0, -5.0, 0.5]
    Program([limits(-3.0, 3.0), limits(-1.0, 4.0, "stops")]).run(rows, 0, 1)
    np.testing.assert_array_equal(effectors["deflection"], [3.0, -1.0, 0.5])


def test_program_keeps_the_memory_of_its_blocks_alive():
    # the table holds addresses only: without the blocks they would point at freed memory
    program = Program([limits(-1.0 - k, 1.0 + k, f"limits {k}") for k in range(50, 0, -1)])
    _ = [np.full(6, np.nan) for _ in range(1000)]
    rows = empty_rows(1)
    as_records(rows)["effectors"]["deflection"] = 99.0
    program.run(rows, 0, 1)
    np.testing.assert_array_equal(as_records(rows)["effectors"]["deflection"][0], 2.0)


@pytest.mark.parametrize("effectors", [1, 2, 5])
def test_a_block_on_effectors_runs_once_for_each_with_its_own_memory(effectors):
    # as many as the rows have; parameters of one record serve for all of them
    rows, state = empty_rows(4, effectors), np.zeros(effectors, COUNT)
    Program([count.block(), count_effector.block(state=state, name="each")]).run(rows, 0, 4)
    np.testing.assert_array_equal(state["calls"], 4.0)
    np.testing.assert_array_equal(state["last"], 4.0)  # the row is the one that the block before has written
    each = np.repeat(np.arange(1.0, 5.0)[:, None], effectors, axis=1)
    np.testing.assert_array_equal(as_records(rows)["effectors"]["deflection"], each)
    one = np.zeros(1, saturation.PARAMS)
    one["u_min"], one["u_max"] = -1.0, 2.0
    shared = saturation.stage.block(one, np.zeros(effectors, NOTHING))
    Program([shared]).run(rows, 0, 4)
    np.testing.assert_array_equal(as_records(rows)["effectors"]["deflection"].max(axis=1), [1.0, 2.0, 2.0, 2.0])


def test_two_blocks_with_one_name_are_refused():
    # others find a block by its name
    with pytest.raises(ValueError, match="two blocks of one name among limits, limits"):
        Program([limits(-1.0, 1.0)], [limits(-2.0, 2.0)])
    with pytest.raises(ValueError, match="custom"):
        Program([PythonBlock("custom", lambda row: None), count.block(name="custom")])


def test_a_block_is_found_by_its_name():
    # with the memory that flies
    block = bias.stage.block(params_of(bias.PARAMS, attitude=0.0, gyro=1.0))
    program = Program([exact.stage.block(), PythonBlock("middle", lambda row: None)], [block])
    assert program["bias"] is block
    assert program.names == ("exact", "middle", "bias")
    for name in ("nothing", "middle"):  # a step in Python has no memory to look at
        with pytest.raises(KeyError, match=f"no compiled block {name} among exact, middle, bias"):
            program[name]


# --- a step in plain Python ------------------------------------------------------------------------------------------


def test_a_step_in_python_runs_between_the_compiled_blocks_of_a_row():
    # it sees what the blocks before it wrote, and those after it see what it wrote
    rows = empty_rows(3)
    start = ROW.fields["x2_meas"][1] // 8
    as_records(rows)["x2"] = [1.0, 2.0, 3.0]
    seen = []

    def step(row):
        seen.append(row[start : start + 3].copy())
        row[start : start + 3] *= 10.0

    offset = bias.stage.block(params_of(bias.PARAMS, attitude=0.0, gyro=[0.1, 0.2, 0.3]))
    for after, plant_step in (([offset], []), ([], [offset])):
        program = Program([exact.stage.block(), PythonBlock("times ten", step), *after], plant_step)
        assert program.run(rows, 0, 3) == 3
        np.testing.assert_array_equal(as_records(rows)["x2_meas"], [[10.1, 20.2, 30.3]] * 3)
    np.testing.assert_array_equal(seen, [[1.0, 2.0, 3.0]] * 6)


def test_a_step_in_python_that_fails_ends_the_run_and_says_why():
    # what comes after it in the row has nothing to act on
    rows = empty_rows(5)
    as_records(rows)["t"] = np.arange(5.0)

    def step(row):
        if row[0] == 3.0:
            raise StepFailed("no more")

    program = Program([count.block(name="before"), PythonBlock("custom", step), count.block(name="after")])
    assert program.failure is None
    assert program.run(rows, 0, 5) == 3
    assert as_records(rows)["status"][3] == STEP_FAILED
    assert program.why(STEP_FAILED) == "no more"
    assert (program["before"].state["calls"], program["after"].state["calls"]) == (4.0, 3.0)


# --- plant steps -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_row_keeps_its_first_plant_step(substeps):
    # the history has what holds from t_k on; the later plant steps run on a copy, their laws' memory goes on
    rows, each = empty_rows(4), np.zeros(3, COUNT)
    blocks = [count_effector.block(state=each, name="each"), count.block(name="plant")]
    program = Program([count.block(name="sample")], blocks, substeps=substeps)
    assert program.run(rows, 0, 4) == 4
    assert program["sample"].state["calls"] == 4.0
    assert program["plant"].state["calls"] == 4.0 * substeps
    np.testing.assert_array_equal(each["calls"], 4.0 * substeps)
    first = 1.0 + substeps * np.arange(4.0)
    np.testing.assert_array_equal(as_records(rows)["throttle"], first)
    np.testing.assert_array_equal(as_records(rows)["effectors"]["deflection"], first[:, None] + np.zeros(3))


def test_a_plant_that_drives_its_own_steps_repeats_them_on_a_copy():
    # the same two steps a row, by `again`, as JSBSim takes them frame by frame
    rows, each = empty_rows(3), np.zeros(3, COUNT)
    program = Program([count.block(name="sample")], [count_effector.block(state=each, name="each")])
    again = program.again(rows)
    for k in range(3):
        assert program.run(rows, k, k + 1) == k + 1
        before = rows[k].copy()
        again(k)
        np.testing.assert_array_equal(rows[k], before)
    assert program["sample"].state["calls"] == 3.0
    np.testing.assert_array_equal(each["calls"], 6.0)
    np.testing.assert_array_equal(each["last"], 3.0)  # the copy is of the row: it has what the sample's blocks wrote
    np.testing.assert_array_equal(as_records(rows)["effectors"]["deflection"][:, 0], [1.0, 3.0, 5.0])


# --- a law that raises -----------------------------------------------------------------------------------------------


def test_a_law_that_raises_ends_the_run_with_its_name():
    # a compiled call has no traceback: the status shows which block it was
    rows = empty_rows(6)
    program = Program([count.block(name="before"), third.block(name="brittle"), count.block(name="after")])
    assert program.run(rows, 0, 6) == 2
    assert as_records(rows)["status"][2] == RAISED - 1
    assert program.why(as_records(rows)["status"][2]) == "the law brittle raised an exception"
    assert (program["before"].state["calls"], program["after"].state["calls"]) == (3.0, 2.0)
    assert not rows[3:].any()


def test_a_law_that_raises_is_named_among_steps_in_python_too():
    # its place is counted in the whole program, not in the compiled call it is part of
    rows = empty_rows(6)
    nothing = PythonBlock("nothing", lambda row: None)
    for blocks in ([nothing, count.block(), third.block(name="brittle")], [third.block(name="brittle"), nothing]):
        program = Program(blocks)
        assert program.run(rows, 0, 6) == 2
        assert program.why(as_records(rows)["status"][2]) == "the law brittle raised an exception"
        rows[:] = 0.0


@pytest.mark.parametrize("effector", [0, 1, 2])
def test_a_law_that_raises_on_one_effector_ends_the_run(effector):
    # whichever it is: also if the law is well again on the next
    rows, marked = empty_rows(6), np.zeros(3, NOTHING)
    marked["nothing"][effector] = 1.0
    program = Program([count.block()], [third_effector.block(marked, name="brittle"), count.block(name="after")])
    assert program.run(rows, 0, 6) == 2
    assert program.why(as_records(rows)["status"][2]) == "the law brittle raised an exception"
    assert program["after"].state["calls"] == 2.0


@pytest.mark.parametrize("stage", [third, third_effector], ids=["row", "effector"])
def test_a_law_that_raises_in_a_repeated_plant_step_ends_the_run(stage):
    # its third call is the second plant step of the second row; the row is the one at which the run ends
    params = np.ones(3 if stage.on_effector else 1, NOTHING)
    for drives in (False, True):
        rows = empty_rows(6)
        blocks = [count.block()], [stage.block(params, name="brittle")]
        if drives:  # as JSBSim does
            program = Program(*blocks)
            again = program.again(rows)
            k = 0
            while program.run(rows, k, k + 1) > k and again(k):
                k += 1
        else:
            program = Program(*blocks, substeps=2)
            k = program.run(rows, 0, 6)
        assert k == 1
        assert program.why(as_records(rows)["status"][1]) == "the law brittle raised an exception"
        assert as_records(rows)["throttle"][1] == 2.0  # the row is otherwise that of its first plant step


class Brittle:
    """An effect of the actuators that raises at a plant step of a flight."""

    @staticmethod
    def blocks(config, given):
        return [third_effector.block(np.full(len(given.effectors), 0.2, NOTHING), name="brittle")]


@pytest.mark.parametrize("plant", ["analytic", "jsbsim"])
def test_a_law_that_raises_ends_a_flight_with_its_name(plant, monkeypatch):
    # at its 15th plant step: the third of three a sample, t = 0.02 s
    from uavftc import actuators

    monkeypatch.setattr(actuators, "CHAIN", (*actuators.CHAIN, Brittle))
    overrides = ("duration_s=1", "simulation.substeps=3")
    records, outcome = fly_to_memory(build_flight(load_scenario("scenario1", plant=plant, overrides=overrides)))
    assert not outcome.completed
    assert outcome.ended_because == "the law brittle raised an exception, at t = 0.020 s"
    assert records["t"][-1] == pytest.approx(0.015)


# --- what laws read and write ----------------------------------------------------------------------------------------


def test_a_law_that_reads_what_nothing_has_written_is_refused():
    # a controller before the sensors would fly on zeros
    offset = bias.stage.block(params_of(bias.PARAMS, attitude=0.0, gyro=0.0))
    with pytest.raises(ValueError, match="bias reads x1_meas, x2_meas, which nothing before it has written"):
        check_flow([offset])
    with pytest.raises(ValueError, match="exact reads x1, x2, which"):
        check_flow([exact.stage.block()])
    vehicle = Stage(counting, NOTHING, COUNT, reads=[], writes=["x1", "x2"]).block(name="vehicle")
    check_flow([vehicle, exact.stage.block(), offset])
    with pytest.raises(ValueError, match="bias reads x1_meas, x2_meas"):
        check_flow([vehicle, offset, exact.stage.block()])  # in this order


def test_what_the_scenario_prescribes_may_be_read_by_all():
    # time, reference, faults, disturbances and wind are there before any law
    check_flow([Stage(counting, NOTHING, COUNT, reads=sorted(PRESCRIBED), writes=[]).block()])


def test_a_law_that_does_not_say_what_it_writes_is_taken_for_a_controller():
    # a custom controller writes the command, compiled or not
    watch = Stage(counting, NOTHING, COUNT, reads=["v2"], writes=[]).block(name="watch")
    check_flow([PythonBlock("custom", lambda row: None), watch])
    check_flow([count.block(name="custom"), watch])
    with pytest.raises(ValueError, match="watch reads v2"):
        check_flow([watch])


def test_a_flight_whose_laws_read_what_nothing_writes_is_not_built(monkeypatch):
    # the sensors' chain without its first: found when the flight is built, not in its history
    from uavftc import sensors

    monkeypatch.setattr(sensors, "CHAIN", (bias,))
    with pytest.raises(ValueError, match=r"reads x1_meas, x2_meas, which nothing before it has written"):
        build_flight(load_scenario("scenario1", plant="analytic"))
