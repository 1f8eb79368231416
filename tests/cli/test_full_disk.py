"""A disk that is full: one line, exit code 1, and what there is room for is kept."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from uavftc.results import manifest
from uavftc.results.history import read_history

FLY = [sys.executable, "-m", "uavftc", "fly", "scenario1", "--plant", "analytic", "--set", "duration_s=20"]


@pytest.fixture
def small(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Path]:
    """A disk of its own with the options of `mount -t tmpfs -o`; skips where nothing may be mounted."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", request.param, "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(mount, check=False, capture_output=True).returncode:
        pytest.skip("nothing may be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def fly(folder: Path, *arguments: str, limit_kb: int | None = None) -> subprocess.CompletedProcess[str]:
    command = [*FLY, "--quiet", "--out", str(folder / "run"), *arguments]
    if limit_kb is not None:
        command = ["bash", "-c", f'ulimit -f {limit_kb}; exec "$@"', "bash", *command]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)


def is_whole(folder: Path) -> bool:
    document = manifest.read_summary(folder)
    if document is None or manifest.changed(folder, document) is not None:
        return False
    return len(read_history(folder / "history.parquet", ["time_s"])["time_s"]) == 4001


@pytest.mark.parametrize("small", ["size=4k", "size=64k", "size=128k", "nr_inodes=3", "nr_inodes=5"], indirect=True)
def test_no_room_for_the_history_is_one_line_and_nothing_is_left(small: Path) -> None:
    done = fly(small)
    assert done.returncode == 1
    assert done.stderr.startswith("error: No space left on device")
    assert len(done.stderr.splitlines()) == 1
    assert os.listdir(small) == []


@pytest.mark.parametrize("small", ["size=1000k", "size=1100k", "size=1200k"], indirect=True)
def test_room_for_the_history_alone_keeps_the_flight_without_its_figures(small: Path) -> None:
    done = fly(small)
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1), done.stderr
    assert done.stderr == f"error: {small / 'run'} has no figures: No space left on device\n"
    assert is_whole(small / "run")
    assert os.listdir(small) == ["run"]
    assert sorted(os.listdir(small / "run")) == ["history.parquet", "scenario.yaml", "summary.json"]
    document = json.loads((small / "run" / "summary.json").read_text())
    assert document["completed"]
    assert document["figures_missing"] == "No space left on device"


@pytest.mark.parametrize("small", ["size=1300k"], indirect=True)
def test_old_results_stay_where_there_is_no_room_for_new_ones(small: Path) -> None:
    assert fly(small, "--no-plots").returncode == 0
    (small / "ballast").write_bytes(b"0" * (os.statvfs(small).f_bavail * 4096 - 60_000))
    before = (small / "run" / "summary.json").read_bytes()
    done = fly(small, "--no-plots")
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1), done.stderr
    assert (small / "run" / "summary.json").read_bytes() == before
    assert is_whole(small / "run")
    assert sorted(os.listdir(small)) == ["ballast", "run"]


@pytest.mark.skipif(os.name == "nt", reason="ulimit")
def test_a_limit_of_the_file_size_is_one_line(tmp_path: Path) -> None:
    fly(tmp_path, "--no-plots")  # compiled by now
    shutil.rmtree(tmp_path / "run")
    done = fly(tmp_path, "--no-plots", limit_kb=64)
    assert (done.returncode, len(done.stderr.splitlines())) == (1, 1), done.stderr
    assert "File too large" in done.stderr
    assert os.listdir(tmp_path) == []
