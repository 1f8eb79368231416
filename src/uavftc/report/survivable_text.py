"""The document of `uavftc survivable` for reading, in 80 to 100 columns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.core.signals import AXES

ANSWERS = {
    "steady": "yes",
    "attitude": "yes, the airspeed changes",
    "moments": "no: for moments only",
    "none": "no",
}
GIVEN_UP = {
    "bank": "the bank",
    "pitch": "the pitch",
    "attitude": "bank and pitch",
    "airspeed": "the airspeed",
    "turn": "the heading",
}


def print_survivable(
    console: Console, document: dict[str, Any], folder: Path | None, *, aside: Console | None = None
) -> None:
    """Print the phases, and of the worst what stands in the way, what could be held, and how severe it may be.

    Warnings are printed on `aside`, where there is one.
    """
    for line in headline(document):
        console.print(Text(line, style="bold" if document["survivable"] else "bold red"))
    console.print()
    console.print(phase_table(document))
    console.print()
    for line in lines_of(document):
        console.print(Text(line))
    for warning in document["warnings"]:
        (aside or console).print(Text.assemble(("warning: ", "yellow"), warning))
    if folder is not None:
        console.print(Text(f"results: {folder}"), soft_wrap=True)


def headline(document: dict[str, Any]) -> list[str]:
    """Return the answer."""
    name = f"{document['scenario']}: {Path(document['aircraft']).name}, {document['plant']}"
    if document["survivable"]:
        return [f"{name}: a steady state exists at the reference, in every phase"]
    phase = document["phases"][document["limiting"]]
    when = f"{phase['start_s']:g} to {phase['end_s']:g} s"
    if phase["level"] in ("steady", "attitude"):
        return [f"{name}: the disturbance of {when} is more than the surfaces can do: no controller is to blame"]
    return [f"{name}: no steady state was found at the reference, {when}: no controller is to blame"]


def phase_table(document: dict[str, Any]) -> Table:
    """Return one row a phase: when, what acts, whether there is a steady state, and the least authority left."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 0, 0, 1), show_edge=False)
    table.add_column(Text("from - to\n[s]"))
    table.add_column(Text("what acts\n"), overflow="fold")
    table.add_column(Text("steady state\n"))
    table.add_column(Text("least authority left\nof that without faults"))
    for k, phase in enumerate(document["phases"]):
        row = (
            f"{phase['start_s']:g} - {phase['end_s']:g}",
            "\n".join(phase["active"]) or "nothing",
            _answer(phase),
            _weakest(phase),
        )
        style = "" if phase["survivable"] else "red"
        table.add_row(*map(Text, row), style=f"bold {style}".strip() if k == document["limiting"] else style)
    return table


def _answer(phase: dict[str, Any]) -> str:
    if not phase["survivable"] and phase["level"] in ("steady", "attitude"):
        return "no: the disturbance"
    return ANSWERS[phase["level"]]


def _weakest(phase: dict[str, Any]) -> str:
    found = [
        (share, axis, side)
        for axis, left in (phase["authority"] or {}).items()
        for side in ("negative", "positive")
        if (share := left[f"{side}_share"]) is not None
    ]
    if not found:
        return "-"
    share, axis, side = min(found, key=lambda one: one[0])
    return f"{axis} {'-' if side == 'negative' else '+'}: {100.0 * share:.0f} %"


def lines_of(document: dict[str, Any]) -> Iterator[str]:
    """Yield what is worth saying of the worst phase, a line each."""
    phase = document["phases"][document["limiting"]]
    reference, has_flow = phase["reference"], phase["state"]["airspeed_mps"] is not None
    asked = f"bank {_deg(reference['bank_rad'])}, pitch {_deg(reference['pitch_rad'])} deg"
    turn = f", turning at {_deg(reference['turn_radps'])} deg/s" if reference["turn_radps"] else ""
    speed = f", {document['airspeed_mps']:g} m/s" if has_flow else ""
    yield f"{phase['start_s']:g} to {phase['end_s']:g} s, as at {phase['at_s']:.4g} s; reference {asked}{turn}{speed}"
    if phase["held"]:
        at = ", ".join(f"{name} at {_deg(phase['deflections_rad'][name])} deg" for name in phase["held"])
        yield f"no command moves {at}"
    yield from _state(phase)
    if phase["unmet"]:
        yield _unmet(phase["unmet"])
    if phase["without_faults"] not in ("steady", "attitude"):
        yield "without faults and damage there is none either: the limits, or the reference, stand in the way"
    if phase["disturbance"] is not None:
        share = phase["disturbance"]["share"]
        much = "more than all" if share is None else f"{100.0 * share:.0f} %"
        yield f"disturbances take up to {much} of what the surfaces can do"
    yield from _instead(phase)
    yield from _authority(phase)
    yield from _severity(document)
    yield from _speeds(document)


def _unmet(found: list[dict[str, Any]]) -> str:
    """Return which equation cannot be met, or which any one of, or which together."""
    parts = []
    for one in found:
        angle = f" ({abs(math.degrees(one['residual'])):.3g} deg/s^2)" if one["unit"].startswith("rad") else ""
        parts.append(f"{one['equation']} by {abs(one['residual']):.3g} {one['unit']}{angle}")
    if not found[0]["alone"]:
        return f"not met together: {', '.join(parts)}"
    if len(parts) == 1:
        return f"not met, with all other equations met: {parts[0]} at least"
    return f"not met, with all other equations met, at least: {', or '.join(parts)}"


def _state(phase: dict[str, Any]) -> Iterator[str]:
    if phase["level"] not in ("steady", "attitude"):
        return
    state = phase["state"]
    surfaces = ", ".join(f"{name} {_deg(value)}" for name, value in phase["deflections_rad"].items())
    if state["airspeed_mps"] is None:
        yield f"steady with {surfaces} deg"
        return
    off = [abs(state[f"{name}_rad"] - phase["reference"][f"{name}_rad"]) for name in ("bank", "pitch")]
    more = state["turn_radps"] - phase["reference"]["turn_radps"]
    at = f"bank {_deg(state['bank_rad'])}, pitch {_deg(state['pitch_rad'])}, " if max(off) > 1e-4 else ""
    at += f"turning {_deg(more)} deg/s more than asked, " if abs(more) > 1e-4 else ""
    flow = f"incidence {_deg(state['alpha_rad'])}, sideslip {_deg(state['beta_rad'])}"
    yield f"steady at {at}{flow} deg, throttle {state['throttle']:.2f}; {surfaces} deg"
    rate = phase["residual"]["thrust and drag"]
    if phase["level"] == "attitude":
        way = "falls" if rate < 0.0 else "rises"
        yield f"thrust and drag do not balance: the airspeed {way} by {abs(rate):.2g} m/s^2 at first"


def _instead(phase: dict[str, Any]) -> Iterator[str]:
    if not phase["instead"]:
        return
    some = False
    for name, one in phase["instead"].items():
        if one is None:
            continue
        some = True
        state, reference = one["state"], phase["reference"]
        what = {
            "bank": f"bank {_deg(state['bank_rad'])} deg",
            "pitch": f"pitch {_deg(state['pitch_rad'])} deg",
            "attitude": f"bank {_deg(state['bank_rad'])} and pitch {_deg(state['pitch_rad'])} deg",
            "airspeed": f"{state['airspeed_mps']:.3g} m/s",
            "turn": f"a turn of {_deg(state['turn_radps'] - reference['turn_radps'])} deg/s more",
        }[name]
        rate = one["airspeed_rate_mps2"]
        rest = "" if one["level"] == "steady" else f", the airspeed changing by {rate:+.2g} m/s^2 at first"
        yield f"could be held, giving up {GIVEN_UP[name]}: {what}{rest}"
    if not some:
        yield "nothing that could be held instead was found: no bank, pitch, airspeed or turn"


def _authority(phase: dict[str, Any]) -> Iterator[str]:
    if phase["authority"] is None:
        return
    parts = []
    for axis in AXES:
        left = phase["authority"][axis]
        ends = [left[f"{side}_radps2"] for side in ("negative", "positive")]
        parts.append(f"{axis} {' to '.join('no limit' if e is None else _deg(e) for e in ends)}")
    yield f"authority left: {', '.join(parts)} deg/s^2"


def _severity(document: dict[str, Any]) -> Iterator[str]:
    severity = document["severity"]
    if severity is None:
        return
    ends = severity["ends_between"]
    held = [point["share"] for point in severity["points"] if point["survivable"]]
    if ends is None:
        yield "a steady state exists at every share of these faults that was tried"
    elif held == [0.0]:
        yield "there is none at any share of these faults that was tried: it is lost as soon as they begin"
    elif any(share > ends[1] for share in held):
        shares = ", ".join(f"{100.0 * share:g}" for share in held)
        yield f"a steady state exists at some shares of these faults only; of those tried at {shares} %"
    else:
        low, high = (100.0 * end for end in ends)
        yield f"a steady state exists up to {low:.3g} % of these faults, and at {high:.3g} % no more"


def _speeds(document: dict[str, Any]) -> Iterator[str]:
    speeds = document["airspeeds"]
    if speeds is None:
        return
    held, clean = speeds["held_mps"], speeds["held_without_faults_mps"]
    tried = [point["airspeed_mps"] for point in speeds["points"]]
    where = "at none" if held is None else f"from {held[0]:.3g} to {held[1]:.3g} m/s"
    else_ = "at none" if clean is None else f"from {clean[0]:.3g} to {clean[1]:.3g}"
    yield f"airspeeds tried, {min(tried):.3g} to {max(tried):.3g} m/s: held {where}; without faults {else_}"


def _deg(value: float) -> str:
    return f"{round(math.degrees(value), 2) + 0.0:.4g}"
