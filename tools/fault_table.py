"""Fly every shipped fault under four controllers, and write where it leaves each: docs/faults.md.

python tools/fault_table.py            # write the page, some minutes
python tools/fault_table.py --only stuck
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from uavftc.config.shipped import scenario_names
from uavftc.core.signals import SURFACES, attitude_error
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.load import load_scenario

PAGE = Path(__file__).parents[1] / "docs" / "faults.md"
CONTROLLERS = {"nndondi-l1": "NNDO-NDI, L1", "nndondi-mrac": "NNDO-NDI, MRAC", "pid": "PID", "lqi": "LQI"}
FAMILIES = ("beyond/fault-", "beyond/engine-")

INTRODUCTION = """# Where each fault leaves each controller

Each row is a shipped scenario, flown on JSBSim as it stands but for the controller. The first number is the largest
attitude error on any axis from the beginning of the fault on, the second the largest at the end of the flight, deg. The
travel is that of the three axis commands together over the flight, rad. A vehicle that is lost has its time and what
ended it.

    python tools/fault_table.py

"""


def cell(name: str, controller: str) -> str:
    """Return how one flight went, in a few characters."""
    scenario = load_scenario(name, controller=controller)
    flight = build_flight(scenario)
    records, outcome = fly_to_memory(flight)
    begins = min(fault.start_s for fault in scenario.faults)
    error = np.degrees(np.abs(attitude_error(records[records["t"] >= begins])))
    if not outcome.completed:
        why = "numerical" if outcome.numerical else (outcome.ended_because or "").split(":")[0].split(" outside")[0]
        return f"**lost** {outcome.ended_at_s:.1f} s, {why}"
    travel = sum(float(np.abs(np.diff(records["v2"][:, i])).sum()) for i in range(len(SURFACES)))
    return f"{error.max():.2g} / {error[-1].max():.2g}; {travel:.2g}"


def main() -> None:
    """Fly, and write the page."""
    parser = argparse.ArgumentParser(description="Fly every shipped fault under four controllers.")
    parser.add_argument("--only", default="", help="scenarios with this in their name; printed, not written")
    arguments = parser.parse_args()
    names = [n for n in scenario_names("beyond") if n.startswith(FAMILIES) and arguments.only in n]
    lines = [f"| scenario | fault | {' | '.join(CONTROLLERS.values())} |", "|---|---|" + "---|" * len(CONTROLLERS)]
    for name in names:
        told = load_scenario(name).description.rstrip(".")
        cells = [cell(name, controller) for controller in CONTROLLERS]
        lines.append(f"| `{name}` | {told} | {' | '.join(cells)} |")
        print(lines[-1], file=sys.stderr)
    text = "\n".join(lines) + "\n"
    if arguments.only:
        print(text)
    else:
        PAGE.write_text(INTRODUCTION + text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
