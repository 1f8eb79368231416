"""NUMBA_DISABLE_JIT=1 flies the same laws in plain Python: what a debugger and coverage see is what flies."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import uavftc
from flying import flown
from uavftc.core.signals import COLUMNS, EFFECTOR, column
from uavftc.results.history import read_history

FLY = """
import sys
import numpy as np
from uavftc.core.stage import COMPILED
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario
plant, file, *overrides = sys.argv[1:]
records, outcome = fly_to_memory(build_flight(load_scenario("scenario3", plant=plant, overrides=overrides)))
np.save(file, records)
print(COMPILED, outcome.completed)
"""


@pytest.mark.parametrize(
    ("plant", "overrides"),
    [
        ("analytic", ("duration_s=20",)),
        ("jsbsim", ("duration_s=2",)),
        # a delay inside the sample: plant steps are repeated on the copy of a row, by the program and by the plant
        ("analytic", ("duration_s=1", "controller.delay_s=0.0075", "sensors.gyro_bias_degps=0.1")),
        ("jsbsim", ("duration_s=1", "controller.delay_s=0.0075", "controller.kind=lqi")),
        ("analytic", ("duration_s=1", "controller.kind=pid")),
    ],
)
def test_a_flight_in_plain_python_is_the_compiled_one(plant, overrides, tmp_path):
    # every column, also those of each effector: rounding differs, by the functions of the C library, and no more
    if "controller.kind=" in " ".join(overrides):  # it takes the place of both loops
        overrides = ("controller={}", *overrides)
    file = tmp_path / "records.npy"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(Path(uavftc.__file__).parents[1])}
    command = [sys.executable, "-c", FLY, plant, file, *overrides]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "False True\n"), done.stderr
    plain = np.load(file)
    _, compiled, outcome = flown("scenario3", plant, None, overrides)
    assert outcome.completed
    assert len(plain) == len(compiled)
    for c in COLUMNS:
        found, expected = column(plain, c.name), column(compiled, c.name)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12, err_msg=c.name)
    for name in EFFECTOR.names:
        found, expected = plain["effectors"][name], compiled["effectors"][name]
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12, err_msg=name)


BRITTLE = """
import numpy as np
from uavftc.core.stage import Stage, law
def params(design, h, options): return np.zeros(1, PARAMS)
PARAMS = STATE = np.dtype([("nothing", "f8")])
@law
def step(p, s, row):
    if row.t > 0.501:
        raise ValueError("enough")
stage = Stage(step, PARAMS, STATE)
"""


@pytest.mark.slow
def test_the_command_in_plain_python_flies_draws_and_ends_as_the_compiled_one(tmp_path):
    # a flight to its end; and a law that raises, which ends it with exit code 3 and its name, not with a traceback
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(Path(uavftc.__file__).parents[1])}
    (tmp_path / "mine.py").write_text(BRITTLE, encoding="utf-8")
    fly = [sys.executable, "-m", "uavftc", "fly", "scenario3", "--set", "duration_s=1"]
    for more, code in ((["--out", "a"], 0), (["--out", "b", "--no-plots", "--controller", "mine.py"], 3)):
        done = subprocess.run([*fly, *more], env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == code
        assert done.stderr.startswith("warning: faults[2]: starts at 8 s")  # the faults come after the end
        assert "Traceback" not in done.stderr
    summary = json.loads((tmp_path / "b" / "summary.json").read_text(encoding="utf-8"))
    assert summary["ended_because"].startswith("the law custom raised ValueError: enough; ")
    assert summary["ended_because"].endswith("mine.py, line 9, at t = 0.505 s")
    history = read_history(tmp_path / "a" / "history.parquet")
    _, compiled, _ = flown("scenario3", "jsbsim", None, ("duration_s=1",))
    for c in COLUMNS:
        np.testing.assert_allclose(history[c.name], column(compiled, c.name), rtol=1e-12, atol=1e-12, err_msg=c.name)
