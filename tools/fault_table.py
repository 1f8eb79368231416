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
from uavftc.core.signals import SURFACES
from uavftc.jobs.campaign.pool import fly_one
from uavftc.scenario.load import load_scenario

PAGE = Path(__file__).parents[1] / "docs" / "faults.md"
CONTROLLERS = {"nndondi-l1": "NNDO-NDI, L1", "nndondi-mrac": "NNDO-NDI, MRAC", "pid": "PID", "lqi": "LQI"}
FAMILIES = ("beyond/fault-", "beyond/engine-")

INTRODUCTION = """# Where each fault leaves each controller

Each row is a shipped scenario, flown on JSBSim as it stands but for the controller; [gallery.md](gallery.md) has each
drawn, under the first of them. A cell begins with the margin of the flight, by the requirements that hold where a
scenario has none ([requirements.md](requirements.md)), and what limits it: 1 at best, below 0 where a requirement is
broken, at most -1 where the vehicle is lost. Then come the largest attitude error on any axis from the beginning of the
fault on and the largest at the end of the flight, deg, and the travel of the three axis commands together over the
flight, rad; of a vehicle that is lost, when, and what ended it. The flights of 12 s on the c172p end before their
errors have died away.

    python tools/fault_table.py

"""


def cell(name: str, controller: str) -> str:
    """Return how one flight went, in a few characters."""
    result = fly_one(load_scenario(name, controller=controller))
    outcome, verdict, history = result.outcome, result.verdict, result.history
    assert verdict is not None
    assert history is not None
    margin = f"{verdict.margin:.2f}".replace("-", "\N{MINUS SIGN}")
    if not outcome.completed:
        cause, _, end = (outcome.ended_because or "").rpartition("ended by ")
        parts = [cause.split(",")[0].strip("; "), end.split(":")[0].split(" outside")[0]]
        why = "numerical" if outcome.numerical else "; ended by ".join(part for part in parts if part)
        return f"**{margin}** lost at {outcome.ended_at_s:.1f} s, {why}"
    begins = min(fault.start_s for fault in result.scenario.faults)
    errors = np.array([history[f"{angle}_ref_rad"] - history[f"{angle}_rad"] for angle in ("phi", "theta", "psi")])
    error = np.degrees(np.abs(errors[:, history["time_s"] >= begins]))
    travel = sum(float(np.abs(np.diff(history[f"{surface}_cmd_rad"])).sum()) for surface in SURFACES)
    judged = f"**{margin}** {verdict.limiting}" if verdict.margin < 0.0 else f"{margin} {verdict.limiting}"
    return f"{judged}; {error.max():.2g} / {error[:, -1].max():.2g}; {travel:.2g}"


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
