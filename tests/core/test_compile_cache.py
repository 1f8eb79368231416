"""The cache of compiled laws: whose machine code it is, and that it is made once."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

import uavftc
from uavftc.core import compile_cache


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A copy of the package that the cache takes as the source; its cache is in tmp_path/cache."""
    copy = tmp_path / "copy"
    shutil.copytree(Path(compile_cache.__file__).parents[1], copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(compile_cache, "__file__", str(copy / "core" / "compile_cache.py"))
    monkeypatch.setenv("UAVFTC_CACHE_DIR", str(tmp_path / "cache"))
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
        "core/stage.py", "flight/envelope.py", "sensors/bias.py", "actuators/delay.py", "plants/rigid_body.py",
        "core/program.py", "control/allocation.py", "stage.py",
    )  # fmt: skip
    for changed in compiled:
        file = source / changed
        file.write_text(file.read_text() + "\n# changed\n")
        names.add(folder_of().name)
    assert len(names) == 14
    for changed in ("cli/app.py", "report/table.py"):  # nothing compiled is there
        file = source / changed
        file.write_text(file.read_text() + "\n# changed\n")
        assert folder_of().name in names
    assert len(list((tmp_path / "cache").iterdir())) == 14


def test_cache_folder_does_not_depend_on_where_the_source_lies(source, tmp_path, monkeypatch):
    # the content counts, not the path: an installed package and a checkout of it share
    first = folder_of()
    source.rename(tmp_path / "moved")
    monkeypatch.setattr(compile_cache, "__file__", str(tmp_path / "moved" / "core" / "compile_cache.py"))
    assert folder_of() == first


def test_numbas_own_variable_moves_the_compiled_laws_where_ours_is_not_set(source, tmp_path, monkeypatch):
    # who has set NUMBA_CACHE_DIR means compiled code; who has set ours as well means all
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "numba"))
    assert folder_of().parent == tmp_path / "cache"
    monkeypatch.delenv("UAVFTC_CACHE_DIR")
    assert folder_of().parent == tmp_path / "numba"


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
        if file.parent.name != "bench"  # compiles what no flight uses, and keeps none of it
        and re.search(r"^(@law|@overload|@intrinsic|@numba\.njit|law = )|\bStage\(", file.read_text(), re.MULTILINE)
    }
    assert len(with_laws) >= 22
    assert with_laws <= hashed


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
from uavftc.sensors import bias
from uavftc.core.program import Program
from uavftc.core.stage import is_compiled, params_of
from uavftc.core.signals import as_records, empty_rows
print(is_compiled(), flush=True)
sys.stdin.readline()
rows = empty_rows(4)
Program([bias.stage.block(params_of(bias.PARAMS, attitude=0.0, gyro=[1.0, 2.0, 3.0]))]).run(rows, 0, 4)
print(as_records(rows)["x2_meas"].sum(), is_compiled())
"""


def start(cache):
    environment = os.environ | {"UAVFTC_CACHE_DIR": str(cache), "PYTHONPATH": str(Path(uavftc.__file__).parents[1])}
    return subprocess.Popen(
        [sys.executable, "-c", FLY],
        env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


@pytest.mark.slow
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
