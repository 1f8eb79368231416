"""Ctrl-C before a flight: while JSBSim settles, and while a child process measures the trim."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from uavftc.aircraft.definition import load_aircraft
from uavftc.plants.jsbsim import model
from uavftc.plants.jsbsim.load import initialised
from uavftc.plants.jsbsim.model import trimmed_model
from uavftc.plants.jsbsim.plant import INTEGRATORS
from uavftc.plants.jsbsim.trim import Trim, start


def press_after(seconds: float) -> None:
    """Press Ctrl-C, as `kill -INT` of this process alone does."""
    threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()


def test_ctrl_c_is_seen_while_jsbsim_settles() -> None:
    # a million steps, the most there may be: some five seconds, of which nobody waits for more than a step
    aircraft = load_aircraft("hale")
    trim = Trim(**trimmed_model(aircraft, 30.0, 1000.0).trim)
    fdm = initialised(aircraft, 5e-6)
    press_after(0.2)
    with pytest.raises(KeyboardInterrupt):
        start(fdm, aircraft, trim, np.zeros(3), INTEGRATORS)
    assert fdm.get_sim_time() < 5.0


def test_ctrl_c_ends_the_child_process_that_measures_the_trim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # one that hangs, as JSBSim does on some aircraft, and does not hear the signal
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\ntrap '' INT\necho $$ > \"${0%/*}/pid\"\nexec sleep 600\n", encoding="utf-8")
    python.chmod(0o755)
    monkeypatch.setattr(model.sys, "executable", str(python))
    press_after(0.5)
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        model._in_child(load_aircraft("hale"), (30.0,), 1000.0)
    assert time.monotonic() - started < 30.0  # and not the two minutes that a child may take
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)
