"""Fly one campaign in several ways, and compare its table to the last bit: any number of workers, a cluster, killed.

    python tools/campaign_identity.py                       # 1,000 cases of 20 s on JSBSim, minutes
    python tools/campaign_identity.py --cases 60 --plant analytic

The ways: one worker; two workers; a Dask cluster on this machine (extra `campaign`) of two workers, one of which is
killed with -9 in the middle; and one worker, the whole campaign killed with -9 three times and gone on with. Of each it
prints how long it took, the content of `flights.parquet` (but for `wall_*`) as a checksum, and whether it is that of
the first. Exit code 0: all identical; 1: not all.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

FILE = """\
name: identity
base: scenario3
seed: 13
cases: {cases}
vary:
  "faults[0].effectiveness": {{uniform: [0.3, 1.0]}}
  "faults[1].effectiveness": {{uniform: [0.3, 1.0]}}
  "reference.phi_deg": {{uniform: [2, 8]}}
  "uncertainty.mass_factor": {{uniform: [0.9, 1.1]}}
controllers: [nndondi-l1]
plants: [{plant}]
"""
START_S = 120.0
UAVFTC = (sys.executable, "-m", "uavftc")


def sweep(file: Path, out: Path, *more: str) -> subprocess.Popen[bytes]:
    """Start a campaign."""
    return subprocess.Popen([*UAVFTC, "sweep", str(file), "--out", str(out), "--quiet", *more])


def ended(process: subprocess.Popen[bytes]) -> None:
    """Wait for a campaign, which must end well."""
    if process.wait():
        sys.exit(f"a campaign ended with exit code {process.returncode}")


def parts(out: Path) -> int:
    """Return how many parts of the table there are."""
    return len(list((out / "parts").glob("part-*.parquet")))


def until_parts(process: subprocess.Popen[bytes], out: Path, count: int) -> bool:
    """Wait until a campaign has so many parts; False if it ends before."""
    while parts(out) < count:
        if process.poll() is not None:
            return False
        time.sleep(0.02)
    return True


def killed_thrice(file: Path, out: Path) -> str:
    """Fly a campaign that is killed three times."""
    times = 0
    for _ in range(3):
        process = sweep(file, out, "--workers", "1", *(["--resume"] if times else []))
        if until_parts(process, out, parts(out) + 2):
            process.kill()
            times += 1
        process.wait()
    ended(sweep(file, out, "--workers", "1", "--resume"))
    return f"killed {times} times"


def on_cluster(file: Path, out: Path) -> str:
    """Fly a campaign on a cluster, one of whose two workers is killed."""
    with tempfile.TemporaryDirectory() as folder:
        logs = [Path(folder) / f"{name}.log" for name in ("scheduler", "one", "two")]
        started = [_dask(logs[0], "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")]
        address = _said(logs[0], "Scheduler at:").split()[-1]
        for log in logs[1:]:
            worker = ("worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
            started.append(_dask(log, *worker, "--local-directory", folder))
            _said(log, "Registered to:")
        try:
            process = sweep(file, out, "--cluster", address)
            if until_parts(process, out, 2):
                started[1].send_signal(signal.SIGKILL)
            ended(process)
            return "one of two workers killed" if started[1].poll() is not None else "no worker killed"
        finally:
            for one in reversed(started):
                one.terminate()
                one.wait()


def _dask(log: Path, *arguments: str) -> subprocess.Popen[bytes]:
    with log.open("wb") as stream:
        return subprocess.Popen([sys.executable, "-m", "dask", *arguments], stdout=stream, stderr=stream)


def _said(log: Path, what: str) -> str:
    end = time.monotonic() + START_S
    while time.monotonic() < end:
        for line in log.read_text(encoding="utf-8").splitlines():
            if what in line:
                return line
        time.sleep(0.1)
    sys.exit(f"dask did not say '{what}' within {START_S:g} s")


def on_workers(file: Path, out: Path, count: int) -> str:
    """Fly a campaign on so many workers."""
    ended(sweep(file, out, "--workers", str(count)))
    return "undisturbed"


def checksum(out: Path) -> tuple[int, str]:
    """Return how many flights the table of a campaign has, and the checksum of its content without wall-clock times."""
    from uavftc.jobs.campaign.table import content

    table = content(out)
    text = "\n".join(repr(row) for row in table.to_pylist())
    return len(table), hashlib.sha256(text.encode()).hexdigest()


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly, compare and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--plant", choices=("jsbsim", "analytic"), default="jsbsim")
    asked = parser.parse_args(arguments)
    ways = {
        "1 worker": lambda file, out: on_workers(file, out, 1),
        "killed and resumed": killed_thrice,
        "Dask": on_cluster,
        "2 workers": lambda file, out: on_workers(file, out, 2),
    }
    found: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "identity.yaml"
        file.write_text(FILE.format(cases=asked.cases, plant=asked.plant), encoding="utf-8")
        for name, fly in ways.items():
            out = Path(folder) / name.replace(" ", "-")
            started = time.monotonic()
            how = fly(file, out)
            flights, digest = checksum(out)
            found.append(digest)
            said = "" if len(found) == 1 else "identical" if digest == found[0] else "ANOTHER TABLE"
            took = f"{time.monotonic() - started:.0f} s"
            load = f"load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
            print(f"{name:20} {how:26} {flights} flights  {digest[:16]}  {took:>7}  {load}  {said}", flush=True)
    return 0 if len(set(found)) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
