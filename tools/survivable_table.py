"""Compare what `uavftc survivable` says of shipped scenarios with flights: the table in docs/survivable.md.

python tools/survivable_table.py            # write the table, a quarter of an hour
python tools/survivable_table.py --only stuck
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.config.shipped import scenario_names
from uavftc.core.signals import attitude_error
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.jobs.survivable.job import survivable
from uavftc.scenario.load import load_scenario

PAGE = Path(__file__).parents[1] / "docs" / "survivable.md"
BEGINS, ENDS = "<!-- flights: written by tools/survivable_table.py -->", "<!-- end of flights -->"
CONTROLLERS = {"nndondi-l1": "L1", "nndondi-mrac": "MRAC", "pid": "PID", "lqi": "LQI"}
LAST = 0.25
"""Of the phase: where the error is looked at."""
HEAD = f"| scenario | phase, s | steady state | {' | '.join(CONTROLLERS.values())} |"


def left(name: str, controller: str, phase: dict[str, Any]) -> str:
    """Return the largest attitude error in the last quarter of a phase, deg, or when the vehicle was lost."""
    flight = build_flight(load_scenario(name, controller=controller))
    records, outcome = fly_to_memory(flight)
    if not outcome.completed and (outcome.ended_at_s or 0.0) < phase["end_s"]:
        return f"**lost** {outcome.ended_at_s:.1f} s"
    since = phase["end_s"] - LAST * (phase["end_s"] - phase["start_s"])
    those = (records["t"] >= since) & (records["t"] <= phase["end_s"])
    error = float(np.degrees(np.abs(attitude_error(records[those]))).max())
    return f"**{error:.2g}**" if error > 1.0 else f"{error:.2g}"


def answer(phase: dict[str, Any]) -> str:
    """Return what `survivable` says of a phase, in a few words."""
    if phase["level"] == "steady":
        return "yes"
    if phase["level"] == "attitude":
        return f"yes; airspeed {phase['residual']['thrust and drag']:+.2g} m/s^2"
    equation = phase["unmet"][0]["equation"] if phase["unmet"] else "several"
    instead = phase["instead"]
    near = (
        [f"bank {round(math.degrees(instead['bank']['state']['bank_rad']), 1) + 0.0:g} deg"]
        if instead.get("bank")
        else []
    )
    near += [f"{instead['airspeed']['state']['airspeed_mps']:.3g} m/s"] if instead.get("airspeed") else []
    turn = instead.get("turn")
    near += [f"turn {math.degrees(turn['state']['turn_radps']):.2g} deg/s"] if turn else []
    return f"**no**, {equation}; instead: {' or '.join(near) or 'nothing'}"


def main() -> None:
    """Look at each scenario, fly it by each controller, and write the table."""
    parser = argparse.ArgumentParser(description="Compare uavftc survivable with flights.")
    parser.add_argument("--only", default="", help="scenarios with this in their name; printed, not written")
    arguments = parser.parse_args()
    names = [n for n in scenario_names("beyond") if n.startswith(("beyond/fault-", "beyond/engine-"))]
    names += scenario_names("damage")
    lines = [HEAD, "|---|---|---|" + "---|" * len(CONTROLLERS)]
    for name in (n for n in names if arguments.only in n):
        document = survivable(load_scenario(name), sweep=False)
        phase = document["phases"][document["limiting"]]
        cells = [left(name, controller, phase) for controller in CONTROLLERS]
        when = f"{phase['start_s']:g} to {phase['end_s']:g}"
        lines.append(f"| `{name}` | {when} | {answer(phase)} | {' | '.join(cells)} |")
        print(lines[-1], file=sys.stderr, flush=True)
    text = "\n".join(lines)
    if arguments.only:
        print(text)
        return
    page = PAGE.read_text(encoding="utf-8")
    pattern = re.compile(f"{re.escape(BEGINS)}.*{re.escape(ENDS)}", re.DOTALL)
    PAGE.write_text(pattern.sub(lambda _: f"{BEGINS}\n{text}\n{ENDS}", page), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
