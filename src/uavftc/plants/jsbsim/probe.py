"""A first load in a child process, so that an aircraft that crashes JSBSim does not take the user's process with it.

Some mistakes in an aircraft (a property that does not exist inside an aerodynamic function, for one) abort the process
from native code. What has loaded once is remembered by the checksum of its files and not probed again.
"""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import platformdirs

from uavftc.aircraft import Aircraft
from uavftc.errors import InputError

TIMEOUT_S = 60.0
FRAMES = 20
_OK = "loads"


def ensure_loads(aircraft: Aircraft) -> None:
    """Make sure that the aircraft loads, initialises and runs without crashing the process.

    Raises
    ------
    InputError
        If it does not; the message is JSBSim's own where there is one.
    """
    mark = _mark(aircraft)
    if mark.is_file():
        return
    command = [sys.executable, "-m", __spec__.name, str(aircraft.folder)]
    try:
        child = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired:
        raise _crash(aircraft, f"JSBSim does not finish loading it within {TIMEOUT_S:g} s", "") from None
    if child.returncode == 0 and child.stdout.strip().endswith(_OK):
        with contextlib.suppress(OSError):
            mark.parent.mkdir(parents=True, exist_ok=True)
            mark.touch()
        return
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        raise _crash(aircraft, f"JSBSim crashes while loading it ({name})", child.stderr)
    # Anything else the load in this process tells better, with a message of its own.


def _mark(aircraft: Aircraft) -> Path:
    key = f"{aircraft.sha256()}-{metadata.version('jsbsim')}"
    return platformdirs.user_cache_path("uavftc") / "aircraft" / key


def _crash(aircraft: Aircraft, found: str, stderr: str) -> InputError:
    told = [line.split("what():")[-1].strip() for line in stderr.splitlines() if "what():" in line]
    return InputError(
        f"aircraft {aircraft.name}, {aircraft.xml}",
        found=": ".join([found, *told[:1]]),
        expected="an aircraft that JSBSim loads and runs",
        remedy="look for a property or operator name that does not exist, in the part you changed last",
    )


def main(folder: str) -> None:
    """Load, initialise and run a few frames."""
    from uavftc.aircraft import load_aircraft  # noqa: PLC0415
    from uavftc.plants.jsbsim.load import load  # noqa: PLC0415

    fdm = load(load_aircraft(folder), 0.005)
    fdm.run_ic()
    for _ in range(FRAMES):
        fdm.run()
    print(_OK)


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except InputError:
        sys.exit(2)
