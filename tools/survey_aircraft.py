"""Fly scenarios 1 and 3 on every aircraft that JSBSim ships, and write docs/aircraft.md.

    python tools/survey_aircraft.py                      # about ten minutes on two cores, less from the cache
    python tools/survey_aircraft.py --out page.md c172p 737

Each aircraft is flown in a separate process, because some crash JSBSim; the limits are those of the aircraft
(`saturation=null`). The page is the same for the same code, whatever the order and the number of processes.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.aircraft.definition import stock_dir, stock_names
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.plants.jsbsim.model import ALTITUDE_M, SPEEDS_MPS
from uavftc.report.progress import stages

ROOT = Path(__file__).parents[1]
SCENARIOS = ("scenario1", "scenario3")
MOST_IAE = 0.25  # rad s, on each axis of scenario 1: 1.4 times that of hale
MOST_ERROR_DEG = 0.2  # deg, on each axis at the end
PATIENCE_S = 600.0  # for loading and trimming one aircraft: the page must not depend on how busy the machine was

Survey = dict[str, Any]
_stopped = threading.Event()


def fly_one(name: str) -> Survey:
    """Return what came of one aircraft: trim and flights, or the reason of refusal."""
    from uavftc.analysis.metrics import metrics_of
    from uavftc.flight.build import build_flight
    from uavftc.flight.fly import fly_to_memory
    from uavftc.plants.jsbsim import model
    from uavftc.scenario.load import load_scenario

    model.TIMEOUT_S = PATIENCE_S
    found: Survey = {"name": name, "trim": None, "reason": None, "flights": {}}
    for scenario in SCENARIOS:
        try:
            flight = build_flight(load_scenario(scenario, aircraft=f"jsbsim:{name}", overrides=["saturation=null"]))
        except InputError as error:
            return found | {"reason": error.found}
        assert flight.model is not None  # all but a rotational model are trimmed
        found["trim"] = {key: flight.model.trim[key] for key in ("method", "airspeed", "altitude")}
        records, outcome = fly_to_memory(flight)
        if outcome.interrupted:
            raise KeyboardInterrupt
        axes = metrics_of(records, completed=outcome.completed)
        speed = records["airspeed"]
        found["flights"][scenario] = {
            "completed": outcome.completed,
            "ended_because": outcome.ended_because,
            "iae": [axes[axis]["iae"] for axis in AXES],
            "error_deg": [axes[axis]["steady_state_error_deg"] for axis in AXES],
            "airspeed_change_mps": float(np.max(np.abs(speed - speed[0]))),
        }
    return found


def in_child(name: str) -> Survey:
    """Return `fly_one`, run in a separate process."""
    if _stopped.is_set():
        raise KeyboardInterrupt
    lost: Survey = {"name": name, "trim": None, "reason": None, "flights": {}}
    command = [sys.executable, __file__, "--one", name]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=2.0 * PATIENCE_S)
    except subprocess.TimeoutExpired:
        return lost | {"reason": f"not flown within {2.0 * PATIENCE_S:g} s"}
    if done.returncode == -signal.SIGINT or "(SIGINT)" in done.stdout:  # Ctrl-C reached it before us
        _stopped.set()
        raise KeyboardInterrupt
    if done.returncode != 0:
        last = [line for line in done.stderr.splitlines() if line.strip()][-1:] or [f"exit code {done.returncode}"]
        return lost | {"reason": f"the process that flies it ended abnormally: {last[0]}"}
    return json.loads(done.stdout.strip().splitlines()[-1])


def survey(names: Sequence[str]) -> list[Survey]:
    """Return what came of each aircraft, in their order."""
    found: dict[str, Survey] = {}
    with stages() as show, ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        try:
            for future in as_completed([pool.submit(in_child, name) for name in names]):
                found[future.result()["name"]] = future.result()
                show(len(found), len(names), "flying every aircraft")
        except BaseException:
            _stopped.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [found[name] for name in names]


# --- the page --------------------------------------------------------------------------------------------------------


def within(flight: Survey, *, iae: float | None) -> bool:
    """Whether a flight was completed, with the error at the end and, if given, the IAE within bounds on each axis."""
    if not flight["completed"] or not all(error <= MOST_ERROR_DEG for error in flight["error_deg"]):
        return False
    return iae is None or all(value <= iae for value in flight["iae"])


def page(found: Sequence[Survey]) -> str:
    """Return the Markdown page."""
    flown = [one for one in found if one["flights"]]
    refused = [one for one in found if not one["flights"]]
    speeds, height = f"{SPEEDS_MPS[0]:g} to {SPEEDS_MPS[-1]:g} m/s", f"{ALTITUDE_M:g} m"
    good = [one for one in flown if within(one["flights"]["scenario1"], iae=MOST_IAE)]
    both = [one for one in good if within(one["flights"]["scenario3"], iae=None)]
    lines = [
        "# JSBSim's own aircraft",
        "",
        f"Every aircraft that JSBSim {metadata.version('jsbsim')} ships, flown by the paper's controller with the "
        "paper's parameters: nothing is tuned",
        "to any of them. Trim, control matrix and limits are measured ([new-aircraft.md](new-aircraft.md) says how). "
        "Written by",
        "`python tools/survey_aircraft.py`; one of them alone:",
        "",
        "```sh",
        "uavftc-fly scenario1 --aircraft jsbsim:c172p --set saturation=null",
        "```",
        "",
        f"Of {len(found)} aircraft, {len(flown)} are flown and {len(refused)} refused, with the reason below.",
        "",
        f"- **{len(good)}** meet in scenario 1 (steps of 5 deg on all axes at once): IAE <= {MOST_IAE:g} rad s and",
        f"  steady-state error <= {MOST_ERROR_DEG:g} deg, on each axis.",
        f"- **{len(both)}** of these also survive scenario 3 (faults on all three surfaces and disturbances): flown to "
        "the end, with a",
        f"  steady-state error <= {MOST_ERROR_DEG:g} deg on each axis.",
        f"- Flown, and outside one of the two: {', '.join(one['name'] for one in flown if one not in both) or 'none'}.",
        "",
        "IAE [rad s] and steady-state error [deg] are given as roll / pitch / yaw, the largest airspeed change in m/s. "
        "`jsbsim` is",
        "JSBSim's own trim, `own` the project's, `glide` that of an aircraft without engines. What is outside the "
        "criterion is **bold**.",
        "",
        "## Flown",
        "",
        "| aircraft | trim | m/s | sc. 1: IAE | error | airspeed | sc. 3: outcome | IAE | error | airspeed |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in flown:
        first, third = (one["flights"][name] for name in SCENARIOS)
        cells = [one["name"], one["trim"]["method"], f"{one['trim']['airspeed']:g}"]
        cells += [
            _three(first["iae"], "{:.3f}", MOST_IAE), _three(first["error_deg"], "{:.3f}", MOST_ERROR_DEG),
            _ended(first) or f"{first['airspeed_change_mps']:.1f}", _ended(third) or "completed",
            _three(third["iae"], "{:.3f}", None), _three(third["error_deg"], "{:.3f}", MOST_ERROR_DEG),
            f"{third['airspeed_change_mps']:.1f}",
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    lines += [
        "",
        "## Refused",
        "",
        f"Airspeeds tried: {len(SPEEDS_MPS)}, from {speeds}, at {height}.",
        "",
        "| aircraft | why |",
        "|---|---|",
    ]
    lines += [f"| {one['name']} | {_plain(one['reason'])} |" for one in refused]
    return "\n".join(lines) + "\n"


def _three(values: Sequence[float | None], form: str, most: float | None) -> str:
    def one(value: float | None) -> str:
        if value is None:
            return "-"
        text = form.format(value)
        return f"**{text}**" if most is not None and value > most else text

    return " / ".join(map(one, values))


def _ended(flight: Survey) -> str | None:
    return None if flight["completed"] else f"**lost**: {_plain(flight['ended_because'])}"


def _plain(reason: str) -> str:
    """Return a reason without this machine's paths, and fit for a table."""
    for folder in (stock_dir().parent, ROOT, Path.cwd(), Path.home()):
        reason = reason.replace(f"{folder}/", "")
    return re.sub(r"\s+", " ", reason).replace("|", "\\|")


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Fly scenarios 1 and 3 on JSBSim's own aircraft.")
    parser.add_argument("names", nargs="*", help="aircraft; default all that JSBSim ships")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "aircraft.md", help="the page")
    parser.add_argument("--json", type=Path, help="also write the figures as JSON to this file")
    parser.add_argument("--one", metavar="NAME", help="fly one aircraft in this process and print JSON")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(fly_one(options.one), allow_nan=False), flush=True)
        os._exit(0)  # some aircraft crash JSBSim as it is taken down
    try:
        found = survey(options.names or stock_names())
    except KeyboardInterrupt:
        print("interrupted: the page is as it was", file=sys.stderr)
        return 130
    if options.json:
        options.json.write_text(json.dumps(found, indent=1, allow_nan=False), encoding="utf-8")
    options.out.write_text(page(found), encoding="utf-8")
    print(options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
