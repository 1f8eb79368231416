"""Whole processes, as a user starts them: time, and peak memory."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from uavftc.core.cache import HOME_VARIABLE
from uavftc.jobs.bench.flights import level
from uavftc.jobs.bench.measure import Figure, NotMeasuredError, alternately, of, ratios, timed
from uavftc.plants.jsbsim.model import cache_dir
from uavftc.scenario.load import scenario_text

FLY = "from uavftc.cli.app import main_fly; main_fly()"  # what the script uavftc-fly does
IMPORTS = "import numpy, scipy.linalg, jsbsim, numba"
# Started by a small parent: a process counts the memory of the one that started it into its peak.
PEAK = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""
TIMEOUT_S = 600.0


def python(code: str, *arguments: str, environment: Mapping[str, str] | None = None) -> str:
    """Run code in a fresh interpreter and an empty folder, and return what it prints.

    Raises
    ------
    NotMeasuredError
        If it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", code, *arguments],
            cwd=folder,
            env={**os.environ, **(environment or {})},
            capture_output=True,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines()
        raise NotMeasuredError(f"the process ended with code {done.returncode}: {lines[-1] if lines else 'no message'}")
    return done.stdout


def fly_process(environment: Mapping[str, str] | None = None) -> float:
    """Return the seconds of `uavftc-fly scenario3 --no-plots`."""
    return timed(lambda: python(FLY, "scenario3", "--no-plots", environment=environment))


def process_warm_s(rounds: int) -> Figure:
    """`uavftc-fly scenario3 --no-plots`, laws compiled and trim solved before."""
    (seconds,) = alternately(rounds, fly_process)
    return Figure(seconds)


def warm_over_imports(rounds: int) -> Figure:
    """The same over a process that imports numpy, scipy.linalg, jsbsim and numba and does nothing."""
    warm, imports = alternately(rounds, fly_process, lambda: timed(lambda: python(IMPORTS)))
    return Figure(ratios(warm, imports), {"warm_s": of(warm), "imports_s": of(imports)})


def process_cold_s(rounds: int) -> Figure:
    """`uavftc-fly scenario3 --no-plots` with an empty cache of compiled laws."""

    def cold() -> float:
        with tempfile.TemporaryDirectory() as folder:
            models = cache_dir()
            shutil.copytree(models, Path(folder) / models.parent.name / models.name)
            return fly_process({HOME_VARIABLE: folder})

    return Figure(alternately(rounds, cold, warm_up=False)[0])


def process_first_s(rounds: int) -> Figure:
    """`uavftc-fly scenario3 --no-plots` with empty caches: laws compiled, and the trim solved in a child process."""

    def first() -> float:
        with tempfile.TemporaryDirectory() as folder:
            return fly_process({HOME_VARIABLE: folder})

    return Figure(alternately(rounds, first, warm_up=False)[0])


def memory_growth_mb(rounds: int) -> Figure:
    """Peak memory of `uavftc-fly --no-plots` on a level flight of 1 h at 200 Hz above that of one of 20 s."""
    if sys.platform == "win32":
        return Figure([], reason="this system does not count the peak memory of a process")
    mb = 1e-6 if sys.platform == "darwin" else 1e-3  # bytes there, kB elsewhere
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for duration in (3600.0, 20.0):
            file = Path(folder) / f"level{duration:g}.yaml"
            file.write_text(scenario_text(level(duration)), encoding="utf-8")
            files.append(str(file))

        def peak(file: str) -> float:
            return mb * float(python(PEAK, sys.executable, "-c", FLY, file, "--no-plots"))

        long, short = alternately(rounds, lambda: peak(files[0]), lambda: peak(files[1]), warm_up=False)
    growth = [a - b for a, b in zip(long, short, strict=True)]
    return Figure(growth, {"flight_1h_mb": of(long), "flight_20s_mb": of(short)})
