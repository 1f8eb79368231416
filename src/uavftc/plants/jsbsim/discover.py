"""Effectors of an aircraft that no companion file names: properties that are read and written by nothing, tried.

JSBSim's standard commands where they act; else, or where they would hide surfaces that have a command of their own,
the properties that flight controls and aerodynamics read and nothing writes, less JSBSim's own. Each is tried on the
frozen vehicle by its response. Inputs that move the same positions are one effector. Named after the property.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import Surface, standard
from uavftc.analysis.authority import RESPONSE_MIN
from uavftc.plants.jsbsim import engines
from uavftc.plants.jsbsim.controls_xml import aerodynamic_inputs, unwritten
from uavftc.plants.jsbsim.engines import has
from uavftc.plants.jsbsim.settle import set_from_below, settle

STANDARD = {
    "aileron": standard("aileron", "left-aileron"),
    "elevator": standard("elevator", "elevator"),
    "rudder": standard("rudder", "rudder"),
}
TRIED = 40  # properties at most
LASTING = 0.4  # share of an effect that may stay when a command is released: backlash, or a slow servo
STEPS = {"rad": 0.1, "deg": 5.0, "": 0.3}  # of a command that is tried, by its unit
NOT_SURFACES = re.compile(r"throttle|mixture|advance|brake|gear|steer|starter|magneto|hold|mode|heading|altitude|wow")
LIKELY = re.compile(r"throttle|motor|power", re.IGNORECASE)  # in the name of a throttle
_ENVIRONMENT = ("aero/", "velocities/", "metrics/", "atmosphere/", "position/", "attitude/", "inertia/", "forces/")
_MINIMAL = """<?xml version="1.0"?><fdm_config name="bare" version="2.0"><metrics><wingarea unit="M2">1</wingarea>
<wingspan unit="M">1</wingspan><chord unit="M">1</chord><location name="AERORP" unit="M"><x>0</x><y>0</y><z>0</z>
</location></metrics><mass_balance><ixx unit="KG*M2">1</ixx><iyy unit="KG*M2">1</iyy><izz unit="KG*M2">1</izz>
<emptywt unit="KG">1</emptywt><location name="CG" unit="M"><x>0</x><y>0</y><z>0</z></location></mass_balance>
<ground_reactions/><propulsion/><flight_control/><aerodynamics/></fdm_config>"""


class Tried(NamedTuple):
    """A property and what it does."""

    name: str
    response: np.ndarray
    """(6,) change of the accelerations for a step of `STEPS`."""
    moved: frozenset[str]
    """What the aerodynamics read and it moves."""


def unit(name: str) -> str:
    """Return `rad` or `deg` where the name of a property says so, or an empty text."""
    found = re.search(r"[-_](rad|deg)s?$", name)
    return found[1] if found else ""


def surfaces(
    aircraft: Aircraft, fresh: Callable[[], jsbsim.FGFDMExec], declared: Collection[str]
) -> dict[str, Surface]:
    """Return the surfaces that act, by name.

    Parameters
    ----------
    aircraft
        What is tried.
    fresh
        Returns an FDM frozen in a condition of flight; again where one was broken by what was tried.
    declared
        Properties that another program would provide; they are no effectors.
    """
    fdm = fresh()
    watched = [n for n in aerodynamic_inputs(aircraft) if has(fdm, n) and not n.startswith(_ENVIRONMENT)]
    known = _bare_catalogue()
    others = [
        n
        for n in unwritten(aircraft)
        if n not in known and n not in declared and has(fdm, n) and not NOT_SURFACES.search(n)
    ]
    settle(fdm)
    tried = [try_out(fdm, s.command, watched) for s in STANDARD.values() if has(fdm, s.command)]
    own = {name: t for name, t in zip(STANDARD, tried, strict=False) if t is not None}
    found = []
    for name in others[:TRIED]:
        if (t := try_out(fdm, name, watched)) is not None:
            found.append(t)
        if not np.all(np.isfinite(settle(fdm, patience_s=0.1))):
            fdm = fresh()
    single = [t for t in found if len(t.moved) == 1]
    if own and not _hidden(own, single):
        return {name: _with_position(STANDARD[name], t, fdm) for name, t in own.items()}
    return _named(single or found, fdm)


def _hidden(own: dict[str, Tried], single: list[Tried]) -> bool:
    """Whether the standard commands hide surfaces that all have commands of their own."""
    covered = {p for t in single for p in t.moved}
    return any(len(t.moved) > 1 for t in own.values()) and all(t.moved and t.moved <= covered for t in own.values())


def _with_position(surface: Surface, tried: Tried, fdm: jsbsim.FGFDMExec) -> Surface:
    """Return a standard surface with the position that it moves."""
    if surface.position is not None and has(fdm, surface.position) and (
        surface.position in tried.moved or not tried.moved
    ):  # fmt: skip
        return surface
    angles = sorted(p for p in tried.moved if unit(p))
    if angles and not (surface.position and has(fdm, surface.position) and _moves(fdm, surface)):
        return surface.model_copy(update={"position": angles[0]})
    return surface


def _moves(fdm: jsbsim.FGFDMExec, surface: Surface) -> bool:
    """Whether a command moves the position property of its surface."""
    assert surface.position is not None
    before, value = fdm[surface.position], fdm[surface.command]
    fdm[surface.command] = value + STEPS[""]
    settle(fdm)
    moved = abs(fdm[surface.position] - before) > 1e-6
    fdm[surface.command] = value
    settle(fdm)
    return bool(moved)


def _named(tried: list[Tried], fdm: jsbsim.FGFDMExec) -> dict[str, Surface]:
    """Return one surface for each set of positions, named after its property."""
    found: dict[str, Surface] = {}
    seen: set[frozenset[str]] = set()
    for t in tried:
        key = t.moved or frozenset([t.name])
        if key in seen:
            continue
        seen.add(key)
        angles = sorted(p for p in t.moved if unit(p))
        name = effector_name(t.name, found)
        found[name] = Surface(command=t.name, position=angles[0] if angles else None)
    return found


def effector_name(name: str, taken: dict[str, Surface]) -> str:
    """Return the name of an effector from that of its property: the last part without unit and `cmd`."""
    text = re.sub(r"[-_](rad|deg|norm|nd|ext)(?=$|[-_])", "", name.rsplit("/", 1)[-1])
    text = re.sub(r"^cmd[-_]?|[-_]cmd$|[-_]command$", "", text)
    text = re.sub(r"[^A-Za-z0-9_]", "_", text).strip("_") or "surface"
    text = text if text[0].isalpha() else f"s{text}"
    if text in taken or text in STANDARD:
        text = f"{text}_{len(taken) + 1}"
    return text[:60]


def why_none(fdm: jsbsim.FGFDMExec) -> str:
    """Return in words what JSBSim's standard commands do, of an aircraft in which no effector was found."""
    parts = []
    for name, surface in STANDARD.items():
        size, left, _, _ = _answer(fdm, surface.command, [])
        if not math.isfinite(size + left):
            return f"{name} of {STEPS['']:g} makes the accelerations not a number"
        stays = f", {left:.2g} after release" if size >= RESPONSE_MIN else ""
        parts.append(f"{name} {size:.2g} rad/s^2{stays}")
    return f"JSBSim's commands of {STEPS['']:g} do {', '.join(parts)}"


def try_out(fdm: jsbsim.FGFDMExec, name: str, watched: list[str]) -> Tried | None:
    """Return what a property does, or None where it moves no angular acceleration, or not for as long as it is set."""
    size, left, change, moved = _answer(fdm, name, watched)
    if not math.isfinite(size + left) or size < RESPONSE_MIN or left > LASTING * size:
        return None
    return Tried(name, change, moved)


def _answer(fdm: jsbsim.FGFDMExec, name: str, watched: list[str]) -> tuple[float, float, np.ndarray, frozenset[str]]:
    """Return size, what is left of it, rad/s^2, change of the accelerations (6,) and what is moved, of one step."""
    value = fdm[name]
    base, positions = settle(fdm, patience_s=0.3), [fdm[n] for n in watched]
    fdm[name] = value + STEPS[unit(name)]
    after = settle(fdm, patience_s=2.0)
    moved = frozenset(
        n for n, p in zip(watched, positions, strict=True)
        if n != name and abs(fdm[n] - p) > 1e-6 * max(1.0, abs(p))
    )  # fmt: skip
    thrust = engines.pull(fdm) if engines.count(fdm) else 0.0
    set_from_below(fdm, {name: value}, {name: 0.05 * STEPS[unit(name)]})
    back = settle(fdm, patience_s=2.0)
    change = after - base
    if engines.count(fdm) and abs(engines.pull(fdm) - thrust) > 0.05 * engines.weight(fdm):
        return 0.0, 0.0, change, moved  # an engine
    return float(np.max(np.abs(change[3:]))), float(np.max(np.abs(back - base)[3:])), change, moved


def throttles(aircraft: Aircraft, fdm: jsbsim.FGFDMExec) -> tuple[str, ...]:
    """Return the commands that move the thrust: JSBSim's own, or else what the flight controls read; or none."""
    standard_names = tuple(f"fcs/throttle-cmd-norm[{i}]" for i in range(engines.count(fdm)))
    known = _bare_catalogue()
    others = [n for n in unwritten(aircraft) if n not in known and has(fdm, n) and unit(n) == ""][:TRIED]
    others.sort(key=lambda n: not LIKELY.search(n))
    for names in (standard_names, *((n,) for n in others)):
        pulls = []
        before = [fdm[n] for n in names]
        for value in (0.2, 0.7):
            for n in names:
                fdm[n] = value
            settle(fdm, least_s=1.0)
            pulls.append(engines.pull(fdm))
        for n, value in zip(names, before, strict=True):
            fdm[n] = value
        if not math.isfinite(pulls[1]) or pulls[1] - pulls[0] > engines.LIVE * engines.weight(fdm):
            return names
        settle(fdm, least_s=0.5)
    return ()


_catalogue: set[str] | None = None


def _bare_catalogue() -> set[str]:
    """Return the properties that any aircraft has."""
    global _catalogue  # noqa: PLW0603 - one a process
    if _catalogue is None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "bare").mkdir()
            (Path(folder) / "bare" / "bare.xml").write_text(_MINIMAL, encoding="utf-8")
            fdm = jsbsim.FGFDMExec(folder)
            fdm.set_debug_level(0)
            fdm.set_aircraft_path(folder)
            fdm.load_model("bare")
            fdm.run_ic()
            listed: Any = fdm.query_property_catalog("")
            lines = listed.splitlines() if isinstance(listed, str) else listed
            _catalogue = {line.split()[0] for line in lines if line.split()}
    return _catalogue
