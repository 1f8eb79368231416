"""Damage in JSBSim: point masses and forces that wait in the copy of the aircraft, without weight and direction.

A damage that changes mass, centre of gravity or inertia has `mass.POINTS` point masses of its own; their places are set
before the flight, and their weights when it begins and when it ends: nothing is done at a frame between. One that adds
forces or moments has external reactions, functions of JSBSim's properties along a direction, which is zero until then.
A weight of zero and a direction of zero change no bit.

JSBSim takes the new mass in the frame after the row at which the damage begins, as it does a command. It keeps the
velocity: what was that of the old centre of gravity is then that of the new one, w x s is not added. It counts the
inertia of fuel tanks about the centre of gravity of the frame before, so with tanks J is exact one frame later.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim.copy import Addition
from uavftc.plants.jsbsim.events import Event, Told
from uavftc.plants.jsbsim.points import Added, placed, refuse_name, scale_of, structural
from uavftc.plants.jsbsim.units import FT_M, IN_M, LBF_N, SLUG_KG, SLUGFT2_KGM2
from uavftc.plants.mass import POINTS, piece_of
from uavftc.plants.schedule import Struck

NAME = "uavftc-damage"
_MARK = -987654.0  # in
_OF = {
    "alpha": ("aero/alpha-rad",),
    "beta": ("aero/beta-rad",),
    "p": ("velocities/p-aero-rad_sec", "aero/bi2vel"),
    "q": ("velocities/q-aero-rad_sec", "aero/ci2vel"),
    "r": ("velocities/r-aero-rad_sec", "aero/bi2vel"),
    "0": (),
}
_AXES = {  # frame, direction and reference length of a coefficient
    "D": ("WIND", (-1, 0, 0), ()),
    "Y": ("WIND", (0, 1, 0), ()),
    "L": ("WIND", (0, 0, -1), ()),
    "l": ("BODY", (1, 0, 0), ("metrics/bw-ft",)),
    "m": ("BODY", (0, 1, 0), ("metrics/cbarw-ft",)),
    "n": ("BODY", (0, 0, 1), ("metrics/bw-ft",)),
}
_UNIT = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
_QS = ("aero/qbar-psf", "metrics/Sw-sqft")


class _Reaction(NamedTuple):
    """A force or moment: its element, in which way, and where a force acts."""

    name: str
    xml: str
    direction: dict[str, int]
    """By the names of JSBSim's properties."""
    place: tuple[float, float, float] | str | None
    """m, body axes, from the undamaged centre of gravity; `reference`, the aerodynamic one; None of a moment."""
    lateral: float = 0.0
    """To the right of that, in half spans."""


def told(aircraft: Aircraft, damage: Sequence[Struck], J: np.ndarray) -> Told:
    """Return what the copy of an aircraft with the inertia J, kg m^2, carries for damages, and what is done when.

    Raises
    ------
    InputError
        If the aircraft's XML has a name that begins as those of the additions.
    """
    if not damage:
        return Told()
    where = refuse_name(aircraft, NAME, "damage")
    added = []
    if (points := _points(damage)).number:
        added.append(points.addition)
    if reactions := "".join(r.xml for i, d in enumerate(damage) for r in _reactions(i, d.entry)):
        added.append(Addition("external_reactions", reactions))
    return Told(additions=tuple(added), at_start=functools.partial(_events, tuple(damage), J, where))


def _points(damage: Sequence[Struck]) -> Added:
    return Added(NAME, _MARK, POINTS * sum(d.entry.changes_mass for d in damage))


def _events(damage: Sequence[Struck], J: np.ndarray, where: str, fdm: jsbsim.FGFDMExec) -> list[Event]:
    """Set the places of all damages on an aircraft at its start; return what is written at which row."""
    mass, scale = fdm["inertia/mass-slugs"] * SLUG_KG, scale_of(fdm, J)
    reference = np.array([fdm[f"metrics/aero-rp-{axis}-in"] for axis in "xyz"])
    points = iter(_points(damage).indices(fdm, where, "leave mass_kg, cg_m and inertia_kgm2 out"))
    events: list[Event] = []
    for i, (entry, first, end) in enumerate(damage):
        on: list[tuple[str, float]] = []
        if entry.changes_mass:
            on += placed(fdm, list(itertools.islice(points, POINTS)), piece_of(entry, mass), scale)
        for reaction in _reactions(i, entry):
            base = f"external_reactions/{reaction.name}"
            on += [(f"{base}/{axis}", float(value)) for axis, value in reaction.direction.items() if value]
            if reaction.place is None:
                continue
            at = reference if isinstance(reaction.place, str) else structural(scale.cg, np.array(reaction.place))
            at = at + np.array([0.0, reaction.lateral * fdm["metrics/bw-ft"] * FT_M / 2.0 / IN_M, 0.0])
            for axis, inches in zip("xyz", at, strict=True):
                fdm[f"{base}/location-{axis}-in"] = inches
        events += [Event(first, name, value) for name, value in on]
        events += [] if end is None else [Event(end, name, 0.0) for name, _ in on]
    return events


def _reactions(i: int, entry: Any) -> list[_Reaction]:
    """Return the forces and moments of an entry, the i-th of a flight."""
    found: list[_Reaction] = []

    def add(kind: str, frame: str, direction: tuple[int, ...], terms: str, place: Any = None, side: float = 0) -> None:
        name = f"{NAME}-{i}-{len(found)}"
        at = "" if kind == "moment" else '<location unit="IN"><x>0</x><y>0</y><z>0</z></location>'
        towards = "<direction><x>0</x><y>0</y><z>0</z></direction>"
        xml = f'<{kind} name="{name}" frame="{frame}">{at}{towards}<function>{terms}</function></{kind}>'
        axes = "lmn" if kind == "moment" else "xyz"
        found.append(_Reaction(name, xml, dict(zip(axes, direction, strict=True)), place, side))

    if (lost := entry.lift_lost) is not None:
        share = _product(_value(0.5 * lost.fraction), _read("forces/fwz-aero-lbs"))  # positive up, as lift is
        side = lost.position if lost.side == "right" else -lost.position
        add("force", "WIND", (0, 0, 1), share, "reference", side)
    if entry.drag_area_m2:
        terms = _product(_read("aero/qbar-psf"), _value(entry.drag_area_m2 / FT_M**2))
        add("force", "WIND", (-1, 0, 0), terms, entry.drag_at_m)
    for direction, newtons, area, moment in zip(
        _UNIT, entry.force_n, entry.force_area_m2, entry.moment_nm, strict=True
    ):
        if newtons:
            add("force", "BODY", direction, _value(newtons / LBF_N), entry.force_at_m)
        if area:
            terms = _product(_read("aero/qbar-psf"), _value(area / FT_M**2))
            add("force", "BODY", direction, terms, entry.force_at_m)
        if moment:
            add("moment", "BODY", direction, _value(moment / SLUGFT2_KGM2))
    for axis, (frame, direction, lengths) in _AXES.items():
        made = [
            _product(_value(value), *map(_read, _OF[name[3:]]))
            for name, value in entry.coefficients.items()
            if name[1] == axis and value
        ]
        if made:
            kind, place = ("moment", None) if lengths else ("force", "reference")
            total = made[0] if len(made) == 1 else f"<sum>{''.join(made)}</sum>"
            add(kind, frame, direction, _product(*map(_read, (*_QS, *lengths)), total), place)
    return found


def _read(name: str) -> str:
    return f"<property>{name}</property>"


def _value(number: float) -> str:
    return f"<value>{number!r}</value>"


def _product(*parts: str) -> str:
    """Return a product; JSBSim complains about one of a single part."""
    return parts[0] if len(parts) == 1 else f"<product>{''.join(parts)}</product>"
