"""Fly the same flights in two checkouts of this project, and compare what they write bit for bit.

    python tools/compare_checkouts.py OLD NEW            # all flights
    python tools/compare_checkouts.py OLD NEW --quick    # a dozen of them
    python tools/compare_checkouts.py OLD NEW --only mrac --python OLD_PYTHON NEW_PYTHON

For a change that must not change any flight. Each flight is `python -m uavftc fly ...` in a separate process, one at
a time for each checkout, so only the command line has to stay as it is. It compares the exit code, `history.parquet`
to the last bit (any NaN equals any NaN, null equals null; 0 and -0 differ), and `summary.json` without `timing`,
`provenance`, `files` and `summary_sha256` (checksums). Columns that NEW adds are reported but are no difference. Exit
code 0: all identical; 1: not all; 2: nothing could be compared.

A checkout is flown by its own `.venv/bin/python`, or else by the one that runs this. Names such as `pid` are entry
points of what is installed there: where they move, NEW needs a separate environment. Nothing is taken from an older
run: both checkouts compile their laws anew, in a temporary folder.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

TIME = "time_s"
IGNORED = ("timing", "provenance", "files", "summary_sha256")  # of `summary.json`: clocks, machines and checksums
LOST = 3  # exit code of a flight that is written up to the loss
PATIENCE_S = 600.0  # for one flight, its compilation included
PLANTS = ("jsbsim", "analytic")
CONTROLLERS = ("nndondi-l1", "ndi-l1", "nndondi-mrac", "ndi-mrac", "pid", "lqi")
BIAS = "--set 'sensors.gyro_bias_degps=[0.3,0.3,0.3]'"
LARGE = "--set 'reference={phi_deg: 40*sin(t), theta_deg: 15*sin(1.3*t), psi_deg: 60}'"
PROBE = """
import json, platform, uavftc
from importlib.metadata import version
versions = {name: version(name) for name in ("jsbsim", "numpy", "scipy", "numba", "llvmlite")}
print(json.dumps([uavftc.__file__, {"python": platform.python_version(), **versions}]))
"""

# --- the flights: what follows `uavftc fly` ---------------------------------------------------------------------------

QUICK = [
    "scenario3 --plant jsbsim --controller nndondi-l1",  # the paper's controller, with faults: what most people fly
    "scenario3 --plant analytic --controller nndondi-l1",  # the same on the other plant
    "scenario2 --plant jsbsim --controller nndondi-mrac",  # the inner law without filter
    "scenario2 --plant analytic --controller ndi-mrac",  # the outer law without observer
    f"scenario1-unsaturated --plant analytic --controller ndi-l1 {LARGE}",  # no limits, and large angles
    "gust --plant jsbsim --controller pid",  # a whole controller, and wind
    "scenario3 --plant jsbsim --controller lqi",  # a whole controller that is designed for the aircraft
    f"scenario1 --plant jsbsim --controller nndondi-l1 {BIAS}",  # sensors, and an observer that is not idle
    "scenario2 --plant jsbsim --controller nndondi-l1 --set controller.delay_s=0.0137",  # a delay between two samples
    "scenario3 --plant analytic --controller nndondi-l1 --set controller.delay_s=0.01",  # a delay of whole samples
    "scenario3 --plant jsbsim --controller nndondi-l1 --set controller.rate_hz=50",  # several plant steps a sample
    "scenario1 --plant jsbsim --controller nndondi-l1 --aircraft jsbsim:737 --set saturation=null",  # another aircraft
    "scenario3 --plant jsbsim --controller nndondi-l1 --set envelope.bank_deg=3",  # a lost flight
]
"""One flight through each part of the code."""

MORE = [
    # The paper's scenarios and the gust (JSBSim only, as all wind) with every shipped controller.
    *(
        f"{scenario} --plant {plant} --controller {controller}"
        for scenario, plant, controller in product(
            ("scenario1", "scenario2", "scenario3", "scenario1-unsaturated"), PLANTS, CONTROLLERS
        )
    ),
    *(f"gust --plant jsbsim --controller {controller}" for controller in CONTROLLERS),
    # A gyro bias: the controller is shown other rates than are flown, which wakes the observer.
    *(f"scenario1 --plant {plant} --controller {law} {BIAS}" for plant, law in product(PLANTS, CONTROLLERS)),
    # Delays: whole samples, half a sample, and two whole samples and a part.
    *(
        f"scenario2 --plant {plant} --controller {law} --set controller.delay_s={delay}"
        for plant, law, delay in product(PLANTS, ("nndondi-l1", "nndondi-mrac"), ("0.01", "0.0025", "0.0137"))
    ),
    # Several plant steps a sample, without a delay and with delays that end at and between plant steps.
    *(
        f"scenario3 --plant {plant} --controller nndondi-l1 --set simulation.substeps=4{delay}"
        for plant, delay in product(
            PLANTS, ("", " --set controller.delay_s=0.0025", " --set controller.delay_s=0.0137")
        )
    ),
    # Rates below and above the usual one; 1000 Hz also takes more rows than are held at a time.
    *(
        f"scenario3 --plant {plant} --controller {law} --set controller.rate_hz={rate}"
        for plant, law, rate in product(PLANTS, ("nndondi-l1", "nndondi-mrac", "pid"), (50, 1000))
    ),
    # Rates and a delay at once.
    *(
        f"scenario3 --plant {plant} --controller nndondi-l1 --set controller.rate_hz={rate} "
        "--set controller.delay_s=0.0137"
        for plant, rate in product(PLANTS, (50, 1000))
    ),
    # Aircraft of JSBSim: their trim, control matrix and limits are measured, and laws are designed from these.
    *(
        f"{scenario} --plant jsbsim --controller {law} --aircraft jsbsim:{aircraft} --set saturation=null"
        for scenario, aircraft, law in product(
            ("scenario1", "scenario3"), ("c172p", "737"), ("nndondi-l1", "nndondi-mrac", "lqi")
        )
    ),
    # The rotational model of an aircraft of JSBSim.
    "scenario3 --plant analytic --controller nndondi-l1 --aircraft jsbsim:c172p --set saturation=null",
    # Lost flights: in bank on both plants, in pitch, by too little and by too much airspeed.
    "scenario3 --plant jsbsim --controller pid --set envelope.bank_deg=3",
    "scenario3 --plant analytic --controller nndondi-l1 --set envelope.bank_deg=3",
    "scenario3 --plant jsbsim --controller nndondi-l1 --set envelope.pitch_deg=3",
    "gust --plant jsbsim --controller nndondi-l1 --set envelope.min_airspeed_mps=29.9",
    "gust --plant jsbsim --controller nndondi-l1 --set envelope.max_airspeed_mps=30.2",
    # Limits of each surface, one of them without.
    *(
        f"scenario3 --plant {plant} --controller {law} "
        "--set 'saturation={elevator: {min_rad: -0.02, max_rad: 0.1}, rudder: {min_rad: -0.03, max_rad: 0.02}}'"
        for plant, law in product(PLANTS, ("nndondi-l1", "lqi"))
    ),
    # A fault on one surface alone, with a bias that is an expression.
    *(
        f"scenario1 --plant {plant} --controller nndondi-l1 --set "
        f"'faults=[{{surface: {surface}, start_s: 5, end_s: 12, effectiveness: 0.3, bias_deg: 0.5 - 0.1*t}}]'"
        for plant, surface in product(PLANTS, ("aileron", "elevator", "rudder"))
    ),
    # A dead surface to the end of the flight, after a fault that its own touches.
    "scenario1 --plant jsbsim --controller nndondi-l1 --set "
    "'faults=[{surface: rudder, start_s: 2, end_s: 5, effectiveness: 1 - 0.1*t}, "
    "{surface: rudder, start_s: 5, effectiveness: 0}]'",
    # Wind, constant and as an expression, and a gust on top of it.
    *(
        f"scenario1 --plant jsbsim --controller {law} --set "
        "'disturbances=[{kind: wind, north_mps: -4, east_mps: 1 + 0.5*sin(0.3*t)}, "
        "{kind: gust, start_s: 6, ramp_s: 1, hold_s: 2, north_mps: 1, down_mps: -2}]'"
        for law in ("nndondi-l1", "ndi-mrac", "lqi")
    ),
    # d1 of eq. (7), on the analytic plant only.
    *(
        f"scenario1 --plant analytic --controller {law} --set 'disturbances=[{{kind: attitude-rate, "
        "phi_degps: 0.3, theta_degps: 0.2*sin(t), psi_degps: -0.1}]'"
        for law in ("nndondi-l1", "ndi-l1")
    ),
    # A heading that goes around, a reference that moves, and none at all.
    *(
        f"scenario1 --plant {plant} --controller nndondi-l1 --set 'reference={{psi_deg: 10*t}}' --set duration_s=40"
        for plant in PLANTS
    ),
    *(
        f"scenario1 --plant {plant} --controller nndondi-l1 --set "
        "'reference={phi_deg: 5*sin(0.5*t), theta_deg: 2*tanh(t), psi_deg: \"min(0.5*t, 4)\"}'"
        for plant in PLANTS
    ),
    "scenario1 --plant jsbsim --controller nndondi-l1 --set reference=null",
    # Large and quick motion: terms that are small in the scenarios, such as the gyroscopic ones, reach the last bit.
    *(
        f"scenario1-unsaturated --plant {plant} --controller {law} {LARGE}"
        for plant, law in product(PLANTS, ("nndondi-l1", "pid"))
    ),
    # Another trim.
    "scenario1 --plant jsbsim --controller nndondi-l1 --set initial.airspeed_mps=35 --set initial.altitude_m=800",
    # Parameters of the laws that no scenario changes.
    *(
        f"scenario2 --plant {plant} --controller nndondi-l1 --set controller.inner.integration=explicit "
        "--set controller.rate_hz=1000"
        for plant in PLANTS
    ),
    "scenario2 --plant jsbsim --controller nndondi-l1 --set controller.inner.reference_gain=printed",
    f"scenario3 --plant jsbsim --controller nndondi-l1 {BIAS} --set 'controller.outer.bandwidth=[0.4,0.5,0.6]' "
    "--set controller.outer.gamma=0.1 --set controller.inner.filter_bandwidth=30 "
    "--set 'controller.inner.rbf={centres: [-0.3,-0.1,0,0.1,0.3], width: 0.5}'",
    # Projection at its bounds.
    "scenario3 --plant jsbsim --controller nndondi-mrac --set 'controller.inner.effectiveness_bounds=[0.6,1.1]' "
    "--set controller.inner.weight_bound=0.01 --set controller.inner.offset_bound=0.01",
    # Options of a whole controller.
    "scenario3 --plant jsbsim --set "
    "'controller={kind: pid, options: {attitude_bandwidth: 0.5, rate_bandwidth: 3}, delay_s: 0.0025}'",
    # More rows than are held at a time, and the fewest that can be flown.
    *(f"scenario3 --plant {plant} --controller nndondi-l1 --set duration_s=100" for plant in PLANTS),
    *(f"scenario3 --plant {plant} --controller nndondi-l1 --set duration_s=0.005" for plant in PLANTS),
]
"""The rest: each scenario, controller and option, on both plants where both fly it."""

FLIGHTS = list(dict.fromkeys(QUICK + MORE))


# --- flying -----------------------------------------------------------------------------------------------------------


class Side(NamedTuple):
    """A checkout, the Python that flies it, and a temporary folder."""

    checkout: Path
    python: Path
    folder: Path

    def run(self, arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
        """Run this side's interpreter on this side's source."""
        compiled = self.folder / "compiled"
        for folder in (self.folder, compiled):
            folder.mkdir(mode=0o700, exist_ok=True)  # where others may write, no compiled laws are kept
        source = {"PYTHONPATH": str(self.checkout / "src"), "NUMBA_CACHE_DIR": str(compiled)}
        return subprocess.run(
            [str(self.python), *arguments],
            cwd=self.folder,
            env=os.environ | source,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
            timeout=PATIENCE_S,
        )


class Flown(NamedTuple):
    """What came of a flight: its exit code, or None if it did not end in time; its last message; its folder."""

    code: int | None
    message: str
    folder: Path


def fly(side: Side, number: int, flight: str) -> Flown:
    """Fly one flight on one side."""
    out = side.folder / str(number)
    try:
        done = side.run(["-m", "uavftc", "fly", *shlex.split(flight), "--no-plots", "--quiet", "--out", str(out)])
    except subprocess.TimeoutExpired:
        return Flown(None, f"not flown within {PATIENCE_S:g} s", out)
    return Flown(done.returncode, " ".join(done.stderr.split())[-300:], out)


def probe(side: Side) -> dict[str, str]:
    """Return the versions that fly a side.

    Raises
    ------
    ValueError
        If the side cannot be flown, or another source than the checkout's would be.
    """
    try:
        done = side.run(["-c", PROBE])
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ValueError(f"{side.python}: {error}") from error
    if done.returncode != 0:
        raise ValueError(f"{side.checkout}: {' '.join(done.stderr.split())[-300:]}")
    file: str
    versions: dict[str, str]
    file, versions = json.loads(done.stdout)
    if (side.checkout / "src").resolve() not in Path(file).resolve().parents:
        raise ValueError(f"{side.checkout}: {side.python} flies {file} instead")
    return versions


# --- comparing --------------------------------------------------------------------------------------------------------


class Compared(NamedTuple):
    """What differs in a flight, and what is reported without being a difference."""

    differences: list[str]
    notes: list[str]


def compare(old: Flown, new: Flown) -> Compared:
    """Compare one flight of both sides."""
    found = Compared([], [])
    if old.code != new.code:
        found.differences.append(f"exit code {old.code} / {new.code}")
    for name, side in (("OLD", old), ("NEW", new)):
        if side.code not in (0, LOST):  # also where both are the same: there is nothing to compare
            found.differences.append(f"not flown by {name}: exit code {side.code}: {side.message}")
    for file, differ in (("history.parquet", _histories), ("summary.json", _summaries)):
        present = [(side.folder / file).is_file() for side in (old, new)]
        if all(present):
            differ(old.folder / file, new.folder / file, found)
        elif any(present) or not found.differences:
            without = [name for name, there in zip(("OLD", "NEW"), present, strict=True) if not there]
            found.differences.append(f"no {file} from {' and '.join(without)}")
    if not found.differences:
        found.notes.insert(0, f"{pq.read_metadata(new.folder / 'history.parquet').num_rows} rows")
        if new.code == LOST:
            found.notes.insert(1, "lost")
    return found


def _histories(old_path: Path, new_path: Path, found: Compared) -> None:
    with pq.ParquetFile(old_path) as old_file, pq.ParquetFile(new_path) as new_file:
        old, new = old_file.read(), new_file.read()
    shared = [name for name in old.column_names if name in new.column_names]
    if gone := [name for name in old.column_names if name not in shared]:
        found.differences.append(f"columns only in OLD: {', '.join(gone)}")
    if added := [name for name in new.column_names if name not in shared]:
        found.notes.append(f"columns only in NEW: {', '.join(added)}")
    if [name for name in new.column_names if name in shared] != shared:
        found.differences.append("another order of columns")
    if old.num_rows != new.num_rows:
        found.differences.append(f"rows {old.num_rows} / {new.num_rows}")
    rows = min(old.num_rows, new.num_rows)
    old, new = old.slice(0, rows), new.slice(0, rows)
    times = old.column(TIME).to_numpy() if TIME in shared else None
    columns: list[tuple[int, str]] = []
    for name in shared:
        ours, theirs = old.column(name), new.column(name)
        if ours.type != theirs.type or ours.type != pa.float64():
            if not ours.equals(theirs):
                columns.append((-1, f"{name} of type {ours.type} / {theirs.type}"))
            continue
        differ, largest = _difference(ours, theirs)
        if differ.any():
            first = int(np.argmax(differ))
            since = f"row {first}" if times is None else f"{times[first]:g} s"
            columns.append((first, f"{name} {largest} from {since}"))
    found.differences.extend(text for _, text in sorted(columns, key=lambda column: column[0]))  # the cause first


def _difference(old: pa.ChunkedArray, new: pa.ChunkedArray) -> tuple[np.ndarray, str]:
    """Return where two columns differ, shape (n,), and their largest difference in words."""
    a, b = (np.ascontiguousarray(column.to_numpy()) for column in (old, new))
    a_null, b_null = (column.is_null().to_numpy() for column in (old, new))
    same = (a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b))
    differ = (a_null != b_null) | ~(same | a_null)
    both = differ & np.isfinite(a) & np.isfinite(b)
    if not both.any():
        return differ, "missing or not finite on one side"
    largest = float(np.max(np.abs(a[both] - b[both])))
    return differ, f"{largest:.3g}" if largest > 0.0 else "sign of zero"


def _summaries(old_path: Path, new_path: Path, found: Compared) -> None:
    old, new = (_flat(json.loads(path.read_text(encoding="utf-8"))) for path in (old_path, new_path))
    keys = [key for key in dict.fromkeys([*old, *new]) if key.split(".")[0] not in IGNORED]
    if added := [key for key in keys if key not in old]:
        found.notes.append(f"in the summary only in NEW: {', '.join(added)}")
    changed = [key for key in keys if key in old and old[key] != new.get(key)]
    if len(changed) > 3:  # their values would only say again what the columns say
        found.differences.append(f"summary {', '.join(changed)}")
    else:
        found.differences.extend(f"summary {key} {old[key]} / {new.get(key, 'absent')}" for key in changed)


def _flat(value: Any, key: str = "") -> dict[str, str]:
    """Return the values of a JSON document as JSON, path to text: 1 and 1.0 differ, as do 0.0 and -0.0."""
    if not isinstance(value, dict) or not value:
        return {key: json.dumps(value)}
    return {
        path: text
        for name, inner in value.items()
        for path, text in _flat(inner, f"{key}.{name}" if key else name).items()
    }


# --- the command line -------------------------------------------------------------------------------------------------


def compare_all(old: Side, new: Side, flights: Sequence[str]) -> int:
    """Fly and compare, print a line for each flight, and return how many differ."""
    different = 0
    pools = [ThreadPoolExecutor(1), ThreadPoolExecutor(1)]
    try:
        jobs = [
            [pool.submit(fly, side, number, flight) for pool, side in zip(pools, (old, new), strict=True)]
            for number, flight in enumerate(flights)
        ]
        for flight, pair in zip(flights, jobs, strict=True):
            ours, theirs = (job.result() for job in pair)
            found = compare(ours, theirs)
            different += bool(found.differences)
            notes = f" ({'; '.join(found.notes)})" if found.notes else ""
            print(f"{flight}: {'; '.join(found.differences) or 'identical'}{notes}", flush=True)
            for side in (ours, theirs):
                for file in side.folder.glob("*.parquet"):
                    file.unlink()
    finally:
        for pool in pools:
            pool.shutdown(cancel_futures=True)
    return different


def interpreter(checkout: Path) -> Path:
    """Return the interpreter of a checkout's own environment, or else the running one."""
    own = checkout / ".venv" / "bin" / "python"
    return own if own.exists() else Path(sys.executable)


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Fly the same flights in two checkouts and compare them bit for bit.")
    parser.add_argument("old", metavar="OLD", type=Path, help="the checkout to compare with")
    parser.add_argument("new", metavar="NEW", type=Path, help="the checkout to compare")
    parser.add_argument("--quick", action="store_true", help=f"{len(QUICK)} of the {len(FLIGHTS)} flights")
    parser.add_argument("--only", metavar="TEXT", default="", help="only flights whose options contain TEXT")
    parser.add_argument("--python", nargs=2, metavar=("OLD_PY", "NEW_PY"), type=Path, help="their interpreters")
    options = parser.parse_args()
    flights = [flight for flight in (QUICK if options.quick else FLIGHTS) if options.only in flight]
    if not flights:
        parser.error(f"no flight contains {options.only!r}")
    checkouts = [path.absolute() for path in (options.old, options.new)]
    for checkout in checkouts:
        if not (checkout / "src" / "uavftc").is_dir():
            parser.error(f"no src/uavftc in {checkout}")
    # not resolved: the interpreter of an environment is a link, and found by its own name
    pythons = [path.absolute() for path in options.python or map(interpreter, checkouts)]
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="uavftc-compare-", ignore_cleanup_errors=True) as folder:
        old, new = (
            Side(checkout, python, Path(folder, name))
            for name, checkout, python in zip(("old", "new"), checkouts, pythons, strict=True)
        )
        try:
            ours, theirs = probe(old), probe(new)
        except ValueError as error:
            print(error, file=sys.stderr)
            return 2
        if unlike := [f"{name} {ours[name]} / {theirs[name]}" for name in ours if ours[name] != theirs[name]]:
            print(f"flown by other versions, which may change bits: {', '.join(unlike)}", flush=True)
        try:
            different = compare_all(old, new, flights)
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            return 130
    same = len(flights) - different
    print(f"{len(flights)} flights in {time.monotonic() - started:.0f} s: {same} identical, {different} not")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
