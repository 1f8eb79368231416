"""Fly scenarios 1 and 3 on every aircraft that JSBSim ships, and models published elsewhere; write docs/aircraft.md.

    python tools/survey_aircraft.py    # JSBSim's own: some ten minutes on two cores, less from the cache
    python tools/survey_aircraft.py --out page.md c172p 737
    python tools/survey_aircraft.py --models DIR/Talon DIR/X8    # scenario 1 on models; the rest of the page stays

Each aircraft is flown in a separate process, because some crash JSBSim; the limits are those of the aircraft
(`saturation=null`), and a reference about an axis without a surface is zero. The page is the same for the same code,
whatever the order and the number of processes.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.aircraft.definition import STOCK, stock_dir, stock_names
from uavftc.aircraft.effectors import servo_text
from uavftc.core.signals import AXES
from uavftc.errors import InputError
from uavftc.plants.jsbsim.model import ALTITUDE_M, FRAME_S, SPEEDS_MPS
from uavftc.report.progress import stages
from uavftc.report.verdict import margin_text

ROOT = Path(__file__).parents[1]
SCENARIOS = ("scenario1", "scenario3")
REFERENCE = ("phi_deg", "theta_deg", "psi_deg")
MOST_IAE = 0.25  # rad s, on each axis of scenario 1: 1.4 times that of hale
MOST_ERROR_DEG = 0.2  # deg, on each axis at the end
SLOWED = 0.1  # change of airspeed over the airspeed of the trim that is named as a reason
AT_STOP = 0.01  # share of a flight at a stop that is named as a reason
PATIENCE_S = 600.0  # for loading and trimming one aircraft: the page must not depend on how busy the machine was
FEW = 6  # effectors whose names are written out

_UMN = ("UASLab/OpenFlightSim", "b020511223946b8642c73a35eacd17c4d5c09ddf")
SOURCES = {
    "UltraStick25e": (*_UMN, "Simulation/aircraft/UltraStick25e"),
    "Talon": (*_UMN, "Simulation/aircraft/Talon"),
    "mAEWing2": (*_UMN, "Simulation/aircraft/mAEWing2"),
    "X8": ("XlokolokiX/X8_FlightGear_JSBSim", "e61139aa4975d98d6b75a5c41c1f360e20edc81e", "AIRCRAFT/X8_FixedWing"),
    "ask21-jsb": ("viktorradnai/flightgear-ask21", "fa350ab56f3eb1ae8427b4b6f00c4f97edc174f6", ""),
}
"""Repository, commit and folder of published models, by the name of their folder."""

STOCK_BEGINS, MODELS_BEGIN = "# JSBSim's own aircraft\n", "## Models published elsewhere\n"

Survey = dict[str, Any]
_stopped = threading.Event()


def fly_one(reference: str, scenarios: Sequence[str]) -> Survey:
    """Return what came of one aircraft: what was measured, trim and flights, or the reason of refusal."""
    from uavftc.aircraft.definition import load_aircraft
    from uavftc.flight.condition import authority_of, obstacles_of
    from uavftc.jobs.design.trimmed import design_model
    from uavftc.plants.jsbsim import model as models
    from uavftc.scenario.load import load_scenario

    models.TIMEOUT_S = PATIENCE_S
    found = _nothing(reference)
    try:
        first = load_scenario(scenarios[0], aircraft=reference, overrides=["saturation=null"])
        aircraft = load_aircraft(reference)
        model = models.stepped(aircraft, design_model(first, aircraft))
    except InputError as error:
        return found | {"reason": error.found}
    found["measured"] = _measured(model)
    if not obstacles_of(model):
        found["authority"] = [float(x) if np.isfinite(x) else None for x in authority_of(first, model).ratio]
    still = [f"reference.{key}=0" for key, own in zip(REFERENCE, model.axes, strict=True) if not own]
    for scenario in scenarios:
        try:
            found["flights"][scenario] = _flown(scenario, reference, ["saturation=null", *still])
        except InputError as error:
            found["flights"][scenario] = {"refused": error.found, "where": error.where}
    if all("refused" in flight for flight in found["flights"].values()):
        found |= {"reason": found["flights"][scenarios[0]]["refused"], "flights": {}}
    return found


def _nothing(reference: str) -> Survey:
    name = Path(reference).name.removeprefix(STOCK)
    return {"name": name, "measured": None, "authority": None, "reason": None, "flights": {}}


def _measured(model: Any) -> Survey:
    """Return what the page says of a trimmed model."""
    limits, reach = np.array(model.limits_rad), np.array(model.reach_rad)
    with np.errstate(divide="ignore", invalid="ignore"):
        full = reach / limits
    return {
        "method": model.trim["method"],
        "airspeed": model.trim["airspeed"],
        "axes": list(model.axes),
        "effectors": list(model.names),
        "servo": sorted({servo_text(e.servo) for e in model.effectors if e.servo}),
        "reported": all(e.measured for e in model.effectors),
        "limits_deg": np.degrees(limits).tolist(),
        "full": [[float(x) if np.isfinite(x) else None for x in pair] for pair in full],
        "engines": model.engines,
        "engines_there": len(model.engine_names),
        "started": model.trim.get("way", "running"),
        "frame_s": model.frame_s,
        "declared": len(model.declared),
    }


def _flown(scenario: str, reference: str, overrides: list[str]) -> Survey:
    from uavftc.analysis.metrics import metrics_of
    from uavftc.analysis.verdict import verdict_of
    from uavftc.flight.build import build_flight
    from uavftc.flight.fly import fly_to_memory
    from uavftc.scenario.load import load_scenario

    flight = build_flight(load_scenario(scenario, aircraft=reference, overrides=overrides))
    records, outcome = fly_to_memory(flight)
    if outcome.interrupted:
        raise KeyboardInterrupt
    monitor = flight.monitor()
    monitor.take(records)
    judged = verdict_of(
        monitor.found(),
        completed=outcome.completed,
        ended_at_s=outcome.ended_at_s,
        duration_s=flight.scenario.duration_s,
        numerical=outcome.numerical,
    )
    assert flight.model is not None  # all but a rotational model are trimmed
    roll, pitch, yaw = flight.model.axes
    axes = metrics_of(records, completed=outcome.completed, controlled=(roll, pitch, yaw))
    speed, deflections = records["airspeed"], records["effectors"]["deflection"]
    stops = np.array([e.limits_rad for e in flight.model.effectors])
    at_stop = np.mean((deflections <= stops[:, 0] + 1e-9) | (deflections >= stops[:, 1] - 1e-9), axis=0)
    return {
        "completed": outcome.completed,
        "ended_because": outcome.ended_because,
        "outcome": judged.outcome,
        "margin": judged.margin,
        "limiting": judged.limiting,
        "iae": [axes[axis]["iae"] for axis in AXES],
        "error_deg": [axes[axis]["steady_state_error_deg"] for axis in AXES],
        "travel_rad": [axes[axis]["control_activity_rad"] for axis in AXES],
        "airspeed_change_mps": float(np.max(np.abs(speed - speed[0]))),
        "at_stop": {e.name: float(share) for e, share in zip(flight.model.effectors, at_stop, strict=True)},
    }


def in_child(reference: str, scenarios: Sequence[str]) -> Survey:
    """Return `fly_one`, run in a separate process."""
    if _stopped.is_set():
        raise KeyboardInterrupt
    command = [sys.executable, __file__, "--one", reference, *scenarios]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=2.0 * PATIENCE_S)
    except subprocess.TimeoutExpired:
        return _nothing(reference) | {"reason": f"not flown within {2.0 * PATIENCE_S:g} s"}
    if done.returncode == -signal.SIGINT or "(SIGINT)" in done.stdout:  # Ctrl-C reached it before us
        _stopped.set()
        raise KeyboardInterrupt
    if done.returncode != 0:
        last = [line for line in done.stderr.splitlines() if line.strip()][-1:] or [f"exit code {done.returncode}"]
        return _nothing(reference) | {"reason": f"the process that flies it ended abnormally: {last[0]}"}
    return json.loads(done.stdout.strip().splitlines()[-1])


def survey(references: Sequence[str], scenarios: Sequence[str]) -> list[Survey]:
    """Return what came of each aircraft, in their order."""
    found: dict[str, Survey] = {}
    with stages() as show, ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        try:
            pending = {pool.submit(in_child, reference, scenarios): reference for reference in references}
            for future in as_completed(pending):
                found[pending[future]] = future.result()
                show(len(found), len(references), "flying every aircraft")
        except BaseException:
            _stopped.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [found[reference] for reference in references]


# --- the page --------------------------------------------------------------------------------------------------------


def against(one: Survey, flight: Survey, *, iae: float | None) -> list[str]:
    """Return in words and numbers what a flight lacks; empty where it was completed within bounds on each axis."""
    if "refused" in flight:
        return [f"not flown: {_plain(flight['where'])}: {_plain(flight['refused'])}"]
    if not flight["completed"]:
        return [f"lost: {_plain(flight['ended_because'])}", *_reasons(one, flight)]
    said = []
    for key, form, unit, most in (("error_deg", "{:.2g}", "deg off", MOST_ERROR_DEG), ("iae", "{:.2f}", "rad s", iae)):
        values = zip(AXES, flight[key], strict=True)
        over = [f"{axis} {form.format(v)}" for axis, v in values if v is not None and most is not None and v > most]
        if over:
            said.append(f"{', '.join(over)} {unit}")
    return [*said, *_reasons(one, flight)] if said else []


def _reasons(one: Survey, flight: Survey) -> list[str]:
    """Return what in a flight may be the cause: airspeed that is lost, stops that are reached, servos."""
    measured, said = one["measured"], []
    if flight["airspeed_change_mps"] > SLOWED * measured["airspeed"]:
        said.append(f"airspeed changes by {flight['airspeed_change_mps']:.1f} of {measured['airspeed']:g} m/s")
    stopped = {name: share for name, share in flight["at_stop"].items() if share > AT_STOP}
    if stopped:
        name = max(stopped, key=lambda n: stopped[n])
        said.append(f"{name} at its stop {100.0 * stopped[name]:.0f} % of the time")
    return [*said, *(f"servo with {text}" for text in measured["servo"])]


def verdict(one: Survey) -> str:
    """Return in a few words what became of an aircraft: both scenarios met, or what is lacking."""
    said = []
    for number, scenario in (("1", "scenario1"), ("3", "scenario3")):
        if scenario in one["flights"]:
            lacking = against(one, one["flights"][scenario], iae=MOST_IAE if number == "1" else None)
            if lacking:
                said.append(f"sc. {number}: {'; '.join(lacking)}")
    return "; ".join(said) or "met"


def stock_part(found: Sequence[Survey]) -> str:
    """Return the Markdown of JSBSim's own aircraft."""
    flown = [one for one in found if one["flights"]]
    refused = [one for one in found if not one["flights"]]
    speeds, height = f"{SPEEDS_MPS[0]:g} to {SPEEDS_MPS[-1]:g} m/s", f"{ALTITUDE_M:g} m"
    good = [one for one in flown if not against(one, one["flights"]["scenario1"], iae=MOST_IAE)]
    both = [one for one in good if not against(one, one["flights"]["scenario3"], iae=None)]
    lines = [
        STOCK_BEGINS,
        *_folded(
            f"Every aircraft that JSBSim {metadata.version('jsbsim')} ships, flown by the paper's controller with the "
            "paper's parameters: nothing is tuned to any of them. Effectors, trim, control matrix and limits are found "
            "and measured ([new-aircraft.md](new-aircraft.md) says how). Written by `python tools/survey_aircraft.py`; "
            "one of them alone:"
        ),
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
        *_folded(
            "IAE [rad s] and steady-state error [deg] are given as roll / pitch / yaw, the largest airspeed change in "
            "m/s. `jsbsim` is JSBSim's own trim, `own` and `solved` the project's, `glide` that of an aircraft without "
            "engines that run. What is outside the criterion is **bold**. The margin is that of the default "
            "requirements ([requirements.md](requirements.md)): below 0 one is broken, and named."
        ),
        "",
        "## Flown",
        "",
        "| aircraft | trim | m/s "
        "| sc. 1: IAE | error | airspeed | margin | sc. 3: IAE | error | airspeed | margin | criterion |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in flown:
        cells = [one["name"], one["measured"]["method"], f"{one['measured']['airspeed']:g}"]
        for scenario, iae in zip(SCENARIOS, (MOST_IAE, None), strict=True):
            cells += _flight_cells(one["flights"][scenario], iae)
        lines.append(f"| {' | '.join([*cells, verdict(one)])} |")
    lines += ["", "## What was measured", "", *_folded(MEASURED), "", *_measured_table(found)]
    lines += [
        "",
        "## Refused",
        "",
        f"Airspeeds tried: up to {len(SPEEDS_MPS)}, from {speeds}, those that the wing can carry, at {height}.",
        "",
        "| aircraft | why |",
        "|---|---|",
    ]
    lines += [f"| {one['name']} | {_plain(one['reason'])} |" for one in refused]
    return "\n".join(lines) + "\n"


def _flight_cells(flight: Survey, iae: float | None) -> list[str]:
    if "refused" in flight:
        return ["-", "-", "-", "-"]
    return [
        _three(flight["iae"], "{:.3f}", iae), _three(flight["error_deg"], "{:.3f}", MOST_ERROR_DEG),
        f"{flight['airspeed_change_mps']:.1f}" if flight["completed"] else "**lost**",
        _margin(flight),
    ]  # fmt: skip


def _margin(flight: Survey) -> str:
    """Return the margin of the default requirements, with what is broken where it is below 0."""
    text = margin_text(flight["margin"])
    return text if flight["outcome"] == "survived" else f"**{text}** {flight['limiting']}"


MEASURED = (
    "Limits about the trim, least..greatest [deg], of roll / pitch / yaw: what an axis moved alone has until its first "
    "surface is at a stop. Full over slope: what the axis does at either limit, over what its slope in the small makes "
    "of that deflection; 1 where the two are within 2 %. Backlash is the width of the hysteresis. Engines: how they "
    "were started, where it took more than saying that they run."
)


def _measured_table(found: Sequence[Survey]) -> list[str]:
    """Return the table of what was measured of each aircraft that has a trim."""
    lines = [
        "| aircraft | effectors | limits | full over slope | servo | engines | plant step |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in found:
        if one["measured"]:
            lines.append(f"| {' | '.join([one['name'], *measured_cells(one['measured'])])} |")
    return lines


def measured_cells(measured: Survey) -> list[str]:
    """Return effectors, limits, full over slope, servo, engines and plant step in words."""
    names, own = measured["effectors"], measured["axes"]
    shown = ", ".join(names) if len(names) <= FEW else f"{', '.join(names[: FEW - 1])} ..."
    limits = [f"{low:.1f}..{high:.1f}" if has else "none"
              for (low, high), has in zip(measured["limits_deg"], own, strict=True)]  # fmt: skip
    full = [_sides(pair) if has else "-" for pair, has in zip(measured["full"], own, strict=True)]
    engines = f"{measured['engines']}" if measured["engines"] else "none"
    if dead := measured["engines_there"] - measured["engines"]:
        engines = f"none of {dead} runs"
    started = {"running": "", "fuel": ", fuel on", "starter": ", by starter"}[measured["started"]]
    return [
        f"{len(names)}: {shown}",
        " / ".join(limits) + ("" if measured["reported"] else " (assumed)"),
        " / ".join(full),
        "; ".join(measured["servo"]) or "none",
        engines + (started if measured["engines"] else ""),
        f"{1e3 * measured['frame_s']:g} ms" + ("" if measured["frame_s"] >= FRAME_S else " or less"),
    ]


def _sides(pair: Sequence[float | None]) -> str:
    """Return full over slope at either end, or 1."""
    if all(x is None or abs(x - 1.0) <= 0.02 for x in pair):
        return "1"
    return " and ".join("-" if x is None else f"{x:.2f}" for x in pair)


def models_part(found: Sequence[Survey]) -> str:
    """Return the Markdown of models that were published elsewhere."""
    lines = [
        MODELS_BEGIN,
        *_folded(
            "Models of small aircraft and a sailplane as they were published, unmodified and without a companion file; "
            "they are no part of this project. Scenario 1 with the limits of the aircraft, without a tuned number; "
            "where nothing acts about yaw, `reference.psi_deg` is 0:"
        ),
        "",
        "```sh",
        "uavftc-fly scenario1 --aircraft path/to/Talon --set saturation=null",
        "```",
        "",
        "Error at the end [deg] and travel of the command over the 20 s [rad] are given as roll / pitch / yaw.",
        "",
        "| model | trim | m/s | margin | error | travel | criterion |",
        "|---|---|---|---|---|---|---|",
    ]
    for one in found:
        link, measured, flight = _link(one["name"]), one["measured"], one["flights"].get("scenario1")
        cells = [link, "-", "-"] if measured is None else [link, measured["method"], f"{measured['airspeed']:g}"]
        if flight is None or "refused" in flight:
            cells += ["not flown", "-", "-", _plain(one["reason"] or flight["refused"])]
        else:
            cells += [
                _margin(flight),
                _three(flight["error_deg"], "{:.3f}", MOST_ERROR_DEG),
                _three(flight["travel_rad"], "{:.2f}", None),
                "; ".join(against(one, flight, iae=MOST_IAE)) or "met",
            ]
        lines.append(f"| {' | '.join(cells)} |")
    lines += ["", "What was measured of them, as above:", "", *_measured_table(found)]
    return "\n".join(lines) + "\n"


def _link(name: str) -> str:
    if name not in SOURCES:
        return name
    repository, commit, folder = SOURCES[name]
    return f"[{name}](https://github.com/{repository}/tree/{commit}/{folder})".replace("/)", ")")


def joined(before: str, stock: str | None, models: str | None) -> str:
    """Return a page with its parts replaced by those that are given."""
    old_stock, mark, old_models = before.partition(MODELS_BEGIN)
    first = old_stock.rstrip() + "\n" if stock is None else stock
    second = mark + old_models if models is None else models
    return first + ("\n" + second if second else "")


def _folded(text: str) -> list[str]:
    return textwrap.wrap(text, 118, break_on_hyphens=False)


def _three(values: Sequence[float | None], form: str, most: float | None) -> str:
    def one(value: float | None) -> str:
        if value is None:
            return "-"
        text = form.format(value)
        return f"**{text}**" if most is not None and value > most else text

    return " / ".join(map(one, values))


def _plain(reason: str) -> str:
    """Return a reason without this machine's paths, and fit for a table."""
    for folder in (stock_dir().parent, ROOT, Path.cwd(), Path.home()):
        reason = reason.replace(f"{folder}/", "")
    return re.sub(r"\s+", " ", reason).replace("|", "\\|")


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="Fly scenarios 1 and 3 on JSBSim's own aircraft, 1 on other models.")
    parser.add_argument("names", nargs="*", help="aircraft; default all that JSBSim ships")
    parser.add_argument("--models", nargs="+", type=Path, metavar="FOLDER", help="models published elsewhere")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "aircraft.md", help="the page")
    parser.add_argument("--json", type=Path, help="also write the figures as JSON to this file")
    parser.add_argument("--one", nargs="+", metavar="AIRCRAFT", help="fly one in this process and print JSON")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(fly_one(options.one[0], options.one[1:] or SCENARIOS), allow_nan=False), flush=True)
        os._exit(0)  # some aircraft crash JSBSim as it is taken down
    stock: list[Survey] = []
    models: list[Survey] = []
    try:
        if options.names or not options.models:
            stock = survey([f"{STOCK}{name}" for name in options.names or stock_names()], SCENARIOS)
        if options.models:
            models = survey([str(folder.resolve()) for folder in options.models], SCENARIOS[:1])
    except KeyboardInterrupt:
        print("interrupted: the page is as it was", file=sys.stderr)
        return 130
    if options.json:
        options.json.write_text(json.dumps(stock + models, indent=1, allow_nan=False), encoding="utf-8")
    before = options.out.read_text(encoding="utf-8") if options.out.is_file() else ""
    parts = stock_part(stock) if stock else None, models_part(models) if models else None
    options.out.write_text(joined(before, *parts), encoding="utf-8")
    print(options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
