"""Stages and programs: order, stopping, parameters by name, and the cache of compiled laws."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import uavftc
from uavftc.actuators import effectiveness, saturation
from uavftc.core import compile_cache, stage
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import Program, params_of
from uavftc.flight import envelope
from uavftc.sensors import gyro


def limits(low, high):
    return saturation.stage.block(params_of(saturation.PARAMS, u_min=low, u_max=high))


def test_blocks_run_in_order():
    # limit then double is not double then limit
    for blocks, expected in (
        ([limits(-1.0, 1.0), effectiveness.stage.block()], 2.0),
        ([effectiveness.stage.block(), limits(-1.0, 1.0)], 1.0),
    ):
        rows = empty_rows(3)
        records = as_records(rows)
        records["u2"], records["effectiveness"] = 5.0, 2.0
        assert Program(blocks).run(rows, 0, 3) == 3
        np.testing.assert_array_equal(records["u2"], expected)


def test_only_the_rows_asked_for_are_run():
    # first is included, last is not; an empty range does nothing
    rows = empty_rows(6)
    records = as_records(rows)
    records["u2"] = 5.0
    program = Program([limits(-1.0, 1.0)])
    assert program.run(rows, 2, 4) == 4
    np.testing.assert_array_equal(records["u2"][:, 0], [5.0, 5.0, 1.0, 1.0, 5.0, 5.0])
    assert program.run(rows, 4, 4) == 4
    np.testing.assert_array_equal(records["u2"][4:], 5.0)


def test_program_stops_at_the_row_whose_status_is_set():
    # the row is finished, the ones after it are not begun, and its index is returned
    rows = empty_rows(10)
    records = as_records(rows)
    records["u2"], records["height"] = 5.0, 1.0
    records["height"][4] = -1.0
    watch = params_of(envelope.PARAMS, bank_max=1.0, pitch_max=1.0, airspeed_min=-1.0, airspeed_max=1.0)
    program = Program([envelope.stage.block(watch), limits(-1.0, 1.0)])
    assert program.run(rows, 0, 10) == 4
    np.testing.assert_array_equal(records["u2"][:, 0], [1.0] * 5 + [5.0] * 5)
    assert records["status"][4] == envelope.GROUND
    assert program.run(rows, 5, 10) == 10


def test_empty_program_runs():
    # no block is a program too
    assert Program([]).run(empty_rows(3), 0, 3) == 3


def test_two_blocks_of_one_stage_keep_their_own_memory():
    # the saturation serves for the stops as well: the stage is shared, its parameters are not
    rows = empty_rows(1)
    records = as_records(rows)
    records["u2"] = [5.0, -5.0, 0.5]
    Program([limits(-3.0, 3.0), limits(-1.0, 4.0)]).run(rows, 0, 1)
    np.testing.assert_array_equal(records["u2"][0], [3.0, -1.0, 0.5])


def test_program_keeps_the_memory_of_its_blocks_alive():
    # the table holds addresses only: without the blocks they would point at freed memory
    program = Program([limits(-1.0 - k, 1.0 + k) for k in range(50, 0, -1)])
    _ = [np.full(6, np.nan) for _ in range(1000)]
    rows = empty_rows(1)
    as_records(rows)["u2"] = 99.0
    program.run(rows, 0, 1)
    np.testing.assert_array_equal(as_records(rows)["u2"][0], 2.0)


def test_parameters_are_given_completely_and_by_name():
    # a forgotten or misspelt parameter must not become a zero
    record = params_of(saturation.PARAMS, u_min=-1.0, u_max=[1.0, 2.0, 3.0])
    assert record.shape == (1,)
    np.testing.assert_array_equal(record["u_min"][0], [-1.0] * 3)
    np.testing.assert_array_equal(record["u_max"][0], [1.0, 2.0, 3.0])
    with pytest.raises(TypeError, match="u_max"):
        params_of(saturation.PARAMS, u_min=-1.0)
    with pytest.raises(TypeError, match="u_maxx"):
        params_of(saturation.PARAMS, u_min=-1.0, u_max=1.0, u_maxx=1.0)
    with pytest.raises(ValueError, match="broadcast"):
        params_of(saturation.PARAMS, u_min=[1.0, 2.0], u_max=1.0)


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


# --- the cache of compiled laws


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A copy of the package that the cache takes for the source; its cache lies in tmp_path/cache."""
    copy = tmp_path / "copy"
    shutil.copytree(Path(compile_cache.__file__).parents[1], copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(compile_cache, "__file__", str(copy / "core" / "compile_cache.py"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    return copy


folder_of = compile_cache.compile_cache_dir.__wrapped__  # without the memory of an earlier call


def test_cache_folder_belongs_to_exactly_this_source(source, tmp_path):
    # numba looks at the file of an entry only; a change in what the entry calls must not find the old machine code
    first = folder_of()
    assert first.parent == tmp_path / "cache"
    assert first.is_dir()
    assert folder_of() == first  # the same source, the same folder
    names = {first.name}
    compiled = (
        "control/rbf.py", "control/inner/predictor.py", "core/kinematics.py", "core/linear3.py", "core/signals.py",
        "core/stage.py", "flight/envelope.py", "sensors/gyro.py", "actuators/delay.py", "plants/rigid_body.py",
    )  # fmt: skip
    for changed in compiled:
        file = source / changed
        file.write_text(file.read_text() + "\n# changed\n")
        names.add(folder_of().name)
    assert len(names) == 11
    for changed in ("cli/app.py", "report/table.py"):  # nothing compiled lies there
        file = source / changed
        file.write_text(file.read_text() + "\n# changed\n")
        assert folder_of().name in names
    assert len(list((tmp_path / "cache").iterdir())) == 11


def test_cache_folder_does_not_depend_on_where_the_source_lies(source, tmp_path, monkeypatch):
    # the content counts, not the path: an installed package and a checkout of it share
    first = folder_of()
    source.rename(tmp_path / "moved")
    monkeypatch.setattr(compile_cache, "__file__", str(tmp_path / "moved" / "core" / "compile_cache.py"))
    assert folder_of() == first


def test_every_compiled_source_file_is_part_of_the_address():
    # a new module with laws that is not hashed would be served from a stale cache
    package = Path(compile_cache.__file__).parents[1]
    hashed = {
        file.relative_to(package)
        for part in compile_cache.COMPILED
        for file in ([package / part] if part.endswith(".py") else (package / part).rglob("*.py"))
    }
    with_laws = {
        file.relative_to(package)
        for file in package.rglob("*.py")
        if any(line.startswith(("@law", "@Stage(", "law =")) for line in file.read_text().splitlines())
    }
    assert len(with_laws) >= 12
    assert with_laws <= hashed


def test_cache_that_cannot_be_written_falls_back_to_a_private_folder(source, tmp_path, monkeypatch):
    # a read-only home or cache costs compile time, not the flight
    blocked = tmp_path / "a file"
    blocked.write_text("")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked))
    monkeypatch.setattr(compile_cache.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    folder = folder_of()
    assert (tmp_path / "temporary") in folder.parents
    assert os.access(folder, os.W_OK)
    if os.name == "posix":
        assert folder.stat().st_mode & 0o077 == 0


def test_cache_that_is_read_only_is_not_used(source, tmp_path, monkeypatch):
    # the folder exists and may be entered, but not written
    access = os.access
    monkeypatch.setattr(compile_cache.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    monkeypatch.setattr(compile_cache.os, "access", lambda p, mode: "temporary" in str(p) and access(p, mode))
    assert (tmp_path / "temporary") in folder_of().parents


def test_without_any_writable_place_a_fresh_temporary_folder_serves(source, tmp_path, monkeypatch):
    # the last resort is never shared
    monkeypatch.setattr(compile_cache.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    monkeypatch.setattr(compile_cache.os, "access", lambda *_: False)
    monkeypatch.setattr(compile_cache.tempfile, "mkdtemp", lambda prefix: str(tmp_path / f"{prefix}fresh"))
    assert folder_of() == tmp_path / "uavftc-fresh"


def test_cache_setting_of_other_users_of_numba_is_restored(monkeypatch):
    # also when the compilation fails
    monkeypatch.setattr(numba.config, "CACHE_DIR", "somewhere else")
    with compile_cache.compile_cache():
        assert str(compile_cache.compile_cache_dir()) == numba.config.CACHE_DIR
    assert numba.config.CACHE_DIR == "somewhere else"

    def fails():
        with compile_cache.compile_cache():
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fails()
    assert numba.config.CACHE_DIR == "somewhere else"


FLY = """
import sys
import numpy as np
from uavftc.sensors import gyro
from uavftc.core.stage import Program, is_compiled, params_of
from uavftc.core.signals import as_records, empty_rows
print(is_compiled(), flush=True)
sys.stdin.readline()
rows = empty_rows(4)
Program([gyro.stage.block(params_of(gyro.PARAMS, bias=[1.0, 2.0, 3.0]))]).run(rows, 0, 4)
print(as_records(rows)["x2_meas"].sum(), is_compiled())
"""


def start(cache):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(Path(uavftc.__file__).parents[1])}
    return subprocess.Popen(
        [sys.executable, "-c", FLY],
        env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def test_processes_may_fill_an_empty_cache_at_the_same_time(tmp_path):
    # sweeps start many at once: all compile, all write, each must come out right and leave a usable cache
    cache = tmp_path / "cache"
    processes = [start(cache) for _ in range(2)]
    assert [p.stdout.readline() for p in processes] == ["False\n"] * 2  # both are ready, neither has compiled
    for p in processes:
        p.stdin.write("\n")
        p.stdin.flush()
    for p in processes:
        out, err = p.communicate(timeout=120)
        assert (p.returncode, out, err) == (0, "24.0 True\n", "")
    third = start(cache)
    out, err = third.communicate("\n", timeout=120)
    assert (out, err) == ("True\n24.0 True\n", "")
    (folder,) = cache.iterdir()
    assert not list(folder.rglob("*.tmp*"))


def test_compiled_laws_are_loaded_from_the_cache_and_not_compiled_again(tmp_path):
    # the second flight of a machine starts at once: no file of the cache is written anew
    cache = tmp_path / "cache"
    files = []
    for _ in range(2):
        out, err = start(cache).communicate("\n", timeout=120)
        assert err == ""
        assert out.endswith("24.0 True\n")
        files.append({f: f.stat().st_mtime_ns for f in cache.rglob("*.nb*")})
    assert len(files[0]) >= 4  # index and code of the entry and of the loop over the rows
    assert files[0] == files[1]


def test_stage_compiles_when_its_address_is_asked_for_and_once():
    # importing a law costs nothing; two blocks share one machine code
    assert gyro.stage.address == gyro.stage.address != 0
    fresh = stage.Stage(gyro.PARAMS, gyro.STATE)(gyro.stage._entry)
    assert "address" not in vars(fresh)
    assert fresh.address
    assert "address" in vars(fresh)
