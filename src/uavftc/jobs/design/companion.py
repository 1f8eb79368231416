"""A companion file of what was found of an aircraft, commented and ready to edit: `uavftc design --write-companion`.

It is read back before the command ends: measured with the file, the aircraft must be the same.
"""

from __future__ import annotations

import json
import math
import os
import re
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavftc.aircraft.definition import COMPANION, STOCK, Aircraft, load_aircraft
from uavftc.aircraft.effectors import Measured, servo_text
from uavftc.core.axes import left_to_the_airframe
from uavftc.core.signals import AXES, SURFACES
from uavftc.errors import InputError
from uavftc.flight.condition import axes_of_model, reasons_against
from uavftc.jobs.design.trimmed import design_model
from uavftc.plants.jsbsim.model import FRAME_S, TrimmedModel, notes, stepped, trimmed_model
from uavftc.plants.jsbsim.span import span
from uavftc.report.effectors_text import effect_text
from uavftc.results.single import cannot_write, write_single
from uavftc.scenario.schema import Scenario

OPTION = "--write-companion"
WIDTH = 118
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*")
_WORDS = ("null", "true", "false")  # of YAML: as texts they need quotes


class Written(NamedTuple):
    """A companion file that was written."""

    file: Path
    model: float
    """Largest difference of A and B, measured with the file, from those without, over the largest entry of each."""
    limits: float
    """The same of the limits about the trim: more surfaces than axes may share a trim another way."""


def check(aircraft: Aircraft) -> None:
    """Make sure, before anything is measured, that a companion file can be written and replaces none.

    Raises
    ------
    InputError
        If the aircraft is JSBSim's own, has a companion file, or its folder cannot be written.
    """
    if aircraft.reference.startswith(STOCK):
        found = "an aircraft of JSBSim's own, whose folder belongs to JSBSim"
        remedy = f"copy {aircraft.folder}, and what it needs of engine/ and systems/ into it, and name the copy"
    elif os.path.lexists(aircraft.companion):
        found, remedy = f"{aircraft.companion}, which is there already", "edit it, or move it away first"
    elif (refused := cannot_write(aircraft.companion)) is not None:
        found, remedy = refused, "copy the folder of the aircraft to where it can be written"
    else:
        return
    raise InputError(OPTION, found=found, expected=f"an aircraft folder of yours, without {COMPANION}", remedy=remedy)


def write(scenario: Scenario, aircraft: Aircraft) -> Written:
    """Write the companion file of an aircraft that has none, at the condition of the scenario, and read it back.

    Raises
    ------
    InputError
        If there is no trim, or the aircraft is refused with the file; nothing is left then.
    """
    check(aircraft)
    model = stepped(aircraft, design_model(scenario, aircraft))
    complaints = notes(aircraft, model._replace(frame_s=FRAME_S))  # a fine plant step is nobody's fault
    refused = reasons_against(scenario, model)
    kept = False
    try:
        try:
            again = _read_back(aircraft, model, text(aircraft, model, complaints, refused))
        except InputError as error:  # JSBSim complains of more than the check of the files does
            if complaints:
                raise
            again = _read_back(aircraft, model, text(aircraft, model, [error.found], refused))
        kept = True
    finally:
        if not kept:
            aircraft.companion.unlink(missing_ok=True)
    held = list(np.flatnonzero(model.axes))
    return Written(
        aircraft.companion,
        max(difference(model.A, again.A), difference(model.B, again.B)),
        difference(np.array(model.limits_rad)[held], np.array(again.limits_rad)[held]),
    )


def _read_back(aircraft: Aircraft, model: TrimmedModel, content: str) -> TrimmedModel:
    write_single(aircraft.companion, lambda partial: partial.write_text(content, encoding="utf-8"))
    read = load_aircraft(str(aircraft.folder))
    return trimmed_model(read, model.trim["airspeed"], model.trim["altitude"])


def difference(one: Any, other: Any) -> float:
    """Return the largest difference between two arrays over the largest entry of the first."""
    return float(np.max(np.abs(np.subtract(other, one))) / max(np.max(np.abs(one)), 1e-12))


# --- the text --------------------------------------------------------------------------------------------------------


def text(aircraft: Aircraft, model: TrimmedModel, complaints: Sequence[str], refused: Sequence[str]) -> str:
    """Return the companion file of an aircraft as found and measured.

    Parameters
    ----------
    complaints
        What is wrong with its files; they are allowed, and the reason is written.
    refused
        Why the controller cannot fly it as it is, if so; written as a comment.
    """
    lines = [
        "# What uavftc found and measured of this aircraft. Change what you know better. What you take out, the name",
        "# excepted, is found or measured again. All keys: docs/new-aircraft.md of uavftc.",
    ]
    lines += _comments(f"The paper's controller cannot fly it as it is: {reason}." for reason in refused)
    if model.engine_names and not model.engines:
        lines += [
            "# No throttle moves the thrust of its engines, whatever was tried to start them: it is flown as a glider."
        ]
    lines += _comments(f"{line[:1].upper()}{line[1:]}." for line in left_to_the_airframe(axes_of_model(model)))
    trim = model.trim
    power = f"throttle {trim['throttle']:.2f}" if model.engines else f"path {_deg(trim['theta'] - trim['alpha'])} deg"
    condition = f"airspeed_mps: {_number(trim['airspeed'])}, altitude_m: {_number(trim['altitude'])}"
    lines += [
        f"name: {_scalar(aircraft.name)}",
        f"description: {_scalar(_description(aircraft, model))}",
        f"initial: {{{condition}}}    # measured here: alpha {_deg(trim['alpha'])} deg, {power}",
    ]
    lines += _short(model) if set(model.names) <= set(SURFACES) else _long(model)
    if complaints:
        lines += _comments(["Without the last line the aircraft is refused:", *complaints])
        lines.append("warnings: allow")
    return "\n".join(lines) + "\n"


def _short(model: TrimmedModel) -> list[str]:
    """Return three surfaces, each of one axis, and the throttle."""
    lines = ["surfaces:    # a positive deflection gives a positive moment"]
    for e in model.effectors:
        lines += _comments([_measured(e)], indent="  ")
        lines.append(f"  {e.name}: {{{_named(command=e.command, position=e.position)}}}")
    if throttles := _throttles(model):
        lines += _engine_comments(model)
        position = [name.replace("-cmd-", "-pos-") for name in throttles]
        standard = all(name.startswith("fcs/throttle-cmd-norm") for name in throttles)
        lines.append(f"throttle: {{command: {_list(throttles)}{f', position: {_list(position)}' if standard else ''}}}")
    return lines


def _long(model: TrimmedModel) -> list[str]:
    """Return effectors, engines among them, and gangs."""
    lines = ["effectors:    # a positive deflection is positive in its position; without one, of a positive command"]
    for e in model.effectors:
        lines += _comments([_measured(e)], indent="  ")
        lines.append(f"  {_scalar(e.name)}: {{{_named(command=e.command, position=e.position)}}}")
    throttles = _throttles(model)
    named = len(throttles) == len(model.engine_names) and not set(model.engine_names) & set(model.names)
    if throttles:
        lines += _engine_comments(model, indent="  " if named else "")
    if named:
        lines += [f"  {n}: {{throttle: {_scalar(t)}}}" for n, t in zip(model.engine_names, throttles, strict=True)]
    elif throttles:
        lines.append(f"throttle: {{command: {_list(throttles)}}}")
    mixing = np.array(model.mixing)
    whole = np.array_equal(mixing, np.round(mixing))
    lines.append("gangs:    # deflection per deflection of the axis; a positive axis gives a positive moment")
    if not whole:
        rule = (
            "Surfaces that mirror each other do not settle who serves what: all share, by the least deflections, each "
        )
        lines += _comments([f"{rule}counted against its reach. All digits, so that it is the same when read."], "  ")
    for i, axis in enumerate(SURFACES):
        members = {_scalar(n): _number(w) for n, w in zip(model.names, mixing[:, i], strict=True) if w}
        if members:
            lines.append(f"  {axis}: {{{', '.join(f'{n}: {w}' for n, w in members.items())}}}")
    return lines


def _measured(e: Measured) -> str:
    """Return in words what was measured of an effector."""
    low, high = (e.trim_rad + limit for limit in e.limits_rad)
    first, second = sorted(e.commands, reverse=e.rad_per_command < 0.0)  # commands of the stops
    full = _at_stops(e)
    largest = max(map(abs, e.B[3:]))
    rates = ", ".join(f"{axis} {effect_text(value, largest)}" for axis, value in zip(AXES, e.B[3:], strict=True))
    said = [
        f"{e.rad_per_command:.4g} rad per command" + ("" if e.measured else ", assumed (it reports no deflection)"),
        f"stops {_deg(low)} and {_deg(high)} deg, at command {first:.4g} and {second:.4g}",
        f"effect {rates} 1/s^2 per rad",
    ]
    if any(abs(part - 1.0) > 0.02 for part in full):
        said.append(f"at the stops {full[0]:.2f} and {full[1]:.2f} of that")
    if servo := servo_text(e.servo):
        said.append(f"servo: {servo}")
    return "; ".join(said)


def _at_stops(e: Measured) -> list[float]:
    """Return the effect per rad at either stop over that in the small; the response was measured per command."""
    ends = sorted(
        (end - e.trim_command) * e.rad_per_command * part for end, part in zip(e.commands, e.full_response, strict=True)
    )
    return [end / limit if limit else 1.0 for end, limit in zip(ends, e.limits_rad, strict=True)]


def _engine_comments(model: TrimmedModel, indent: str = "") -> list[str]:
    started = {"running": "", "fuel": "with fuel that flows", "starter": "by magnetos and starter"}
    said = [f"thrust answers by {model.throttle_mps2:.3g} m/s^2 per unit of throttle"]
    if way := started.get(model.trim.get("way", "running"), ""):
        said.append(f"started {way}")
    if model.frame_s < FRAME_S:
        said.append(f"flown in steps of {1e3 * model.frame_s:g} ms or less")
    return _comments(["; ".join(said)], indent)


def _throttles(model: TrimmedModel) -> list[str]:
    return list(model.trim.get("throttles", ())) if model.engines else []


def _description(aircraft: Aircraft, model: TrimmedModel) -> str:
    wing = span(aircraft)
    count = len(model.engine_names)
    engines = {0: "no engine", 1: "1 engine"}.get(count, f"{count} engines")
    return ", ".join([f"{model.mass_kg:.4g} kg", *([] if wing is None else [f"{wing:.3g} m span"]), engines])


def _named(**values: Any) -> str:
    return ", ".join(f"{key}: {_scalar(value)}" for key, value in values.items() if value is not None)


def _list(values: Iterable[str]) -> str:
    return f"[{', '.join(map(_scalar, values))}]"


def _scalar(value: str) -> str:
    """Return a text as YAML reads it back, quoted where it must be."""
    plain = _PLAIN.fullmatch(value) is not None and value.lower() not in _WORDS
    return value if plain else json.dumps(value)


def _number(value: float) -> str:
    """Return a number with all digits: what is read back is the same to the bit."""
    return f"{value:.0f}" if value == round(value) else repr(float(value))


def _comments(texts: Iterable[str], indent: str = "") -> list[str]:
    """Return texts as comments, folded; what cannot be printed is left out, for YAML refuses it."""
    lines: list[str] = []
    for one in texts:
        clean = " ".join("".join(c if c.isprintable() else " " for c in one).split())
        lines += textwrap.wrap(clean, WIDTH, initial_indent=f"{indent}# ", subsequent_indent=f"{indent}#   ")
    return lines


def _deg(value: float) -> str:
    return f"{round(math.degrees(value), 3) + 0.0:.2f}"
