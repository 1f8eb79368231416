"""Stages: what numba makes of a law, the status of one that raises, and parameters by name."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import uavftc
from uavftc.actuators import saturation
from uavftc.core.signals import EFFECTOR, ROW, as_records, empty_rows
from uavftc.core.stage import NOTHING, RAW, Stage, floats, law, params_of, records_of
from uavftc.sensors import bias, exact

GAIN = np.dtype([("gain", "f8", (3,)), ("K", "f8", (3, 3)), ("k", "f8"), ("n", "i8")])


@law
def scale(p, s, row):
    """Write the scaled rates and count the samples."""
    for i in range(3):
        row.v1[i] = p.gain[i] * row.x2[i]
    s.nothing += 1.0


@law
def brittle(p, s, row):
    """Raise where the time is negative."""
    if row.t < 0.0:
        raise ValueError("before the start")
    row.throttle = 1.0


@law
def brittle_effector(p, s, e, row):
    """Raise where the command is negative."""
    if e.command < 0.0:
        raise ValueError("negative")
    e.deflection = e.command + row.t


@law
def own_memory(p, s, row):
    """Keep the last two throttles."""
    memory = floats(s, 2)
    memory[1] = memory[0]
    memory[0] = row.throttle


def call(stage, *memory):
    """Call a compiled law as C, without the kernel: two words of numba's, then the addresses; return its status."""
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * (2 + len(memory)))(stage.address)
    words = np.zeros(2, np.uint64)  # where a result and where an exception would be put
    return function(words[:1].ctypes.data, words[1:].ctypes.data, *(m.ctypes.data for m in memory))


def test_a_compiled_law_takes_its_records_by_address():
    # the convention that the kernel relies on and that is numba's, not ours: a new numba must not break it unseen
    rows, state = empty_rows(1), np.zeros(1, NOTHING)
    as_records(rows)["x2"] = [1.0, 2.0, 3.0]
    p = params_of(GAIN, gain=[2.0, 3.0, 4.0], K=np.eye(3), k=0.0, n=1)
    assert call(Stage(scale, GAIN), p, state, rows) == 0
    np.testing.assert_array_equal(as_records(rows)["v1"][0], [2.0, 6.0, 12.0])
    assert state["nothing"] == 1.0


def test_a_law_that_raises_returns_a_status_and_does_nothing_after_it():
    # an exception cannot leave a C function: what is left of it is a status other than 0
    stage, rows = Stage(brittle), empty_rows(1)
    p, s = np.zeros(1, NOTHING), np.zeros(1, NOTHING)
    assert call(stage, p, s, rows) == 0
    assert as_records(rows)["throttle"] == 1.0
    as_records(rows)["t"], as_records(rows)["throttle"] = -1.0, 0.0
    assert call(stage, p, s, rows) != 0
    assert as_records(rows)["throttle"] == 0.0


def test_a_law_on_an_effector_takes_it_before_the_row_and_raises_the_same_way():
    # five addresses in all; e and row must not be crossed
    stage, row = Stage(brittle_effector), np.zeros(1, ROW)
    assert stage.on_effector
    assert not Stage(brittle).on_effector
    e, p, s = np.zeros(1, EFFECTOR), np.zeros(1, NOTHING), np.zeros(1, NOTHING)
    e["command"], row["t"] = 2.0, 0.5
    assert call(stage, p, s, e, row) == 0
    assert e["deflection"] == 2.5
    e["command"] = -1.0
    assert call(stage, p, s, e, row) != 0
    assert e["deflection"] == 2.5


def test_memory_of_a_laws_own_comes_as_a_pointer():
    # state RAW: no record, as many numbers as the law lays out
    stage, rows, state = Stage(own_memory, state=RAW), empty_rows(1), np.array([7.0, 8.0])
    as_records(rows)["throttle"] = 9.0
    assert call(stage, np.zeros(1, NOTHING), state, rows) == 0
    np.testing.assert_array_equal(state, [9.0, 7.0])


def test_a_stage_knows_its_law():
    # the name of its block is the law's file; the law as written stays at hand for plain Python
    stage = Stage(scale, GAIN, reads=["x2"], writes=["v1"])
    assert stage.name == "test_stage"
    assert stage.python is scale.py_func
    assert (stage.params, stage.state) == (GAIN, NOTHING)
    assert (stage.reads, stage.writes) == ({"x2"}, {"v1"})
    assert (Stage(scale).reads, Stage(scale).writes) == (None, None)
    assert stage.__doc__ == "Write the scaled rates and count the samples."
    assert stage.block().name == "test_stage"
    assert stage.block(name="another").name == "another"


def test_a_law_that_is_not_decorated_is_compiled_the_same():
    # the stage compiles the law itself: the decorator is for what a law calls
    stage, rows = Stage(brittle.py_func), empty_rows(1)
    assert call(stage, np.zeros(1, NOTHING), np.zeros(1, NOTHING), rows) == 0
    assert as_records(rows)["throttle"] == 1.0


def test_stage_compiles_when_its_address_is_asked_for_and_once():
    # importing a law costs nothing; two blocks share one machine code
    assert bias.stage.address == bias.stage.address != 0
    fresh = Stage(exact.step, exact.PARAMS, exact.STATE)
    assert "address" not in vars(fresh)
    assert fresh.address
    assert "address" in vars(fresh)


def test_memory_that_is_not_given_is_zero_and_each_blocks_own():
    # as many entries as what is given has: one for a row, one an effector
    stage = Stage(scale, GAIN)
    assert stage.block().params.tobytes() == bytes(GAIN.itemsize)
    assert stage.block().state is not stage.block().state
    assert stage.block(np.zeros(4, GAIN)).state.shape == (4,)
    assert stage.block(state=np.zeros(5, NOTHING)).params.shape == (5,)


def test_parameters_are_given_completely_and_by_name():
    # a forgotten or misspelt parameter must not become a zero
    record = params_of(bias.PARAMS, attitude=0.0, gyro=[1.0, 2.0, 3.0])
    assert record.shape == (1,)
    np.testing.assert_array_equal(record["gyro"][0], [1.0, 2.0, 3.0])
    with pytest.raises(TypeError, match="u_max"):
        params_of(saturation.PARAMS, u_min=-1.0)
    with pytest.raises(TypeError, match="u_maxx"):
        params_of(saturation.PARAMS, u_min=-1.0, u_max=1.0, u_maxx=1.0)


def test_a_number_fills_a_vector_and_nothing_else():
    # filling a matrix with one number is never meant: k times the identity is not a matrix full of k
    values = {"gain": 2.0, "K": np.eye(3), "k": 3.0, "n": 4}
    record = params_of(GAIN, **values)[0]
    np.testing.assert_array_equal(record["gain"], [2.0] * 3)
    np.testing.assert_array_equal(record["K"], np.eye(3))
    assert (record["k"], record["n"]) == (3.0, 4)
    for name, wrong in (
        ("K", 1.0),
        ("K", [1.0, 2.0, 3.0]),  # a row is not a matrix either
        ("K", np.eye(2)),
        ("gain", [1.0, 2.0]),
        ("gain", [[1.0, 2.0, 3.0]]),
        ("k", [1.0, 2.0, 3.0]),
        ("k", [1.0]),
        ("n", [[1]]),
    ):
        with pytest.raises(ValueError, match=f"parameter {name} has the shape"):
            params_of(GAIN, **{**values, name: wrong})


def test_records_of_several_effectors_have_one_entry_each():
    # entries are counted: five limits for three effectors are an error, not three limits
    records = records_of(saturation.PARAMS, 3, u_min=[-1.0, -2.0, -3.0], u_max=[1.0, 2.0, 3.0])
    np.testing.assert_array_equal(records["u_min"], [-1.0, -2.0, -3.0])
    filled = records_of(bias.PARAMS, 2, attitude=[0.0, 0.0], gyro=[1.0, 2.0])  # a number a record fills its vector
    np.testing.assert_array_equal(filled["gyro"], [[1.0] * 3, [2.0] * 3])
    for wrong in ([1.0] * 5, [1.0] * 2, [[1.0], [2.0], [3.0]]):
        with pytest.raises(ValueError, match="parameter u_max"):
            records_of(saturation.PARAMS, 3, u_min=[-1.0] * 3, u_max=wrong)


def test_division_by_zero_in_a_law_is_inf_and_not_an_exception():
    # an exception cannot leave a C function: the watch looks for inf and nan instead
    from uavftc.core.linear3 import solve

    assert not np.isfinite(solve(np.zeros((3, 3)), np.ones(3))).any()


def test_solve_agrees_with_lapack():
    # Cramer's rule, unrolled: every cofactor and its sign
    rng = np.random.default_rng(14)
    from uavftc.core.linear3 import multiply, multiply_transposed, solve

    for _ in range(100):
        M, b = rng.normal(size=(3, 3)) + 2.0 * np.eye(3), rng.normal(size=3)
        scale = np.linalg.cond(M)
        np.testing.assert_allclose(solve(M, b), np.linalg.solve(M, b), rtol=0, atol=1e-13 * scale**2)
        np.testing.assert_allclose(multiply(M, b), M @ b, rtol=0, atol=1e-14)
        np.testing.assert_allclose(multiply_transposed(M, b), M.T @ b, rtol=0, atol=1e-14)


LAW = """
import numpy as np

from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import RAW, Stage, floats, law, params_of

PARAMS = np.dtype([("gain", "f8"), ("matrix", "f8", (3, 3))])


@law
def helper(p, x):
    return p.gain * x * p.matrix[0, 0]


@law
def on_row(p, s, row):
    row.throttle = helper(p, row.t)
    floats(s, 1)[0] += 1.0


@law
def on_effector(p, s, e, row):
    e.deflection = helper(p, e.command)


if __name__ == "__main__":
    rows = empty_rows(2)
    as_records(rows)["t"], as_records(rows)["effectors"]["command"] = 3.0, 5.0
    p = params_of(PARAMS, gain=2.0, matrix=np.eye(3))
    row, effector = Stage(on_row, PARAMS, RAW), Stage(on_effector, PARAMS)
    Program([row.block(p, name="row")], [effector.block(np.repeat(p, 3), name="effector")]).run(rows, 0, 2)
    print(as_records(rows)["throttle"].sum(), as_records(rows)["effectors"]["deflection"].sum())
"""


def test_a_law_is_loaded_from_the_cache_in_a_second_process_and_the_cache_does_not_grow(tmp_path):
    # numba finds machine code by the types of the arguments: were a record's type new each time, every flight would
    # compile, and leave another file
    source, cache = tmp_path / "laws.py", tmp_path / "cache"
    source.write_text(LAW)
    environment = os.environ | {"UAVFTC_CACHE_DIR": str(cache), "PYTHONPATH": str(Path(uavftc.__file__).parents[1])}
    found = []
    for _ in range(3):
        done = subprocess.run([sys.executable, source], env=environment, capture_output=True, text=True, check=True)
        assert (done.stdout, done.stderr) == ("12.0 60.0\n", "")
        found.append({f: f.stat().st_mtime_ns for f in cache.rglob("*") if f.is_file()})
    compiled = sorted(f.suffix for f in found[0])
    assert compiled == [".nbc"] * 3 + [".nbi"] * 3  # the two laws and the kernel, an index and the code of each
    assert found[0] == found[1] == found[2]
