"""Damage in JSBSim: point masses and forces that wait in the copy of the aircraft, with weight and magnitude zero.

A damage that changes mass, centre of gravity or inertia has `mass.POINTS` point masses of its own; their places are set
before the flight, and their weights when it begins and when it ends: nothing is done at a frame between. One that adds
forces or moments has external reactions, functions of JSBSim's properties times a switch. A weight of zero and a switch
of zero change no bit.

JSBSim takes the new mass in the frame after the row at which the damage begins, as it does a command. It keeps the
velocity: what was that of the old centre of gravity is then that of the new one, w x s is not added. It counts the
inertia of fuel tanks about the centre of gravity of the frame before, so with tanks J is exact one frame later.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jsbsim
import numpy as np

from uavftc.errors import InputError
from uavftc.plants.jsbsim.units import FT_M, IN_M, LBF_N, SLUG_KG, SLUGFT2_KGM2
from uavftc.plants.mass import POINTS, piece_of, points_of
from uavftc.plants.schedule import Change, Struck

NAME = "uavftc-damage"
_WEIGHTLESS = (
    f'<pointmass name="{NAME}"><weight unit="LBS">0</weight>'
    '<location unit="IN"><x>0</x><y>0</y><z>0</z></location></pointmass>'
)
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


class Additions(NamedTuple):
    """What a copy of an aircraft carries for the damages of a flight."""

    masses: str = ""
    """Elements of <mass_balance>."""
    reactions: str = ""
    """Elements of <external_reactions>."""
    properties: tuple[str, ...] = ()
    """To be declared."""


class _Reaction(NamedTuple):
    """A force or moment: its element, and where a force acts."""

    name: str
    xml: str
    place: tuple[float, float, float] | str | None
    """m, body axes, from the undamaged centre of gravity; `reference`, the aerodynamic one; None of a moment."""
    lateral: float = 0.0
    """To the right of that, in half spans."""


def additions(damage: Sequence[Struck]) -> Additions:
    """Return what the copy carries: the point masses and reactions of each damage, and a switch for each."""
    masses = sum(d.entry.changes_mass for d in damage) * POINTS
    reactions = "".join(r.xml for i, d in enumerate(damage) for r in _reactions(i, d.entry))
    switches = tuple(_switch(i) for i, d in enumerate(damage) if d.entry.acts)
    return Additions(masses * _WEIGHTLESS, reactions, switches)


def changes(
    fdm: jsbsim.FGFDMExec, damage: Sequence[Struck], J: np.ndarray, where: str
) -> list[tuple[int | None, Change]]:
    """Set the places of all damages on an aircraft at its start, inertia J, kg m^2; return what is done at which row.

    Raises
    ------
    InputError
        If the point masses did not come with the aircraft.
    """
    node = functools.partial(_node, fdm)
    mass = fdm["inertia/mass-slugs"] * SLUG_KG
    lbs_per_kg = fdm["inertia/weight-lbs"] / mass  # by JSBSim's own g
    cg = np.array([fdm[f"inertia/cg-{axis}-in"] for axis in "xyz"])
    reference = np.array([fdm[f"metrics/aero-rp-{axis}-in"] for axis in "xyz"])
    radius = float(np.sqrt(0.5 * np.trace(J) / mass))  # of the size of the vehicle's: weights of its order
    point = _own_points(fdm, damage, where)
    found: list[tuple[int | None, Change]] = []
    for i, (entry, first, end) in enumerate(damage):
        on: list[tuple[Callable[[float], object], float]] = []
        if entry.changes_mass:
            masses, places = points_of(piece_of(entry, mass), radius)
            for kg, place in zip(masses, places, strict=True):
                for axis, inches in zip("XYZ", _structural(cg, place), strict=True):
                    fdm[f"inertia/pointmass-location-{axis}-inches[{point}]"] = inches
                on.append((node(f"inertia/pointmass-weight-lbs[{point}]").set_double_value, lbs_per_kg * kg))
                point += 1
        if entry.acts:
            for reaction in _reactions(i, entry):
                if reaction.place is None:
                    continue
                at = reference if isinstance(reaction.place, str) else _structural(cg, np.array(reaction.place))
                at = at + np.array([0.0, reaction.lateral * fdm["metrics/bw-ft"] * FT_M / 2.0 / IN_M, 0.0])
                for axis, inches in zip("xyz", at, strict=True):
                    fdm[f"external_reactions/{reaction.name}/location-{axis}-in"] = inches
            on.append((node(_switch(i)).set_double_value, 1.0))
        off = [(write, 0.0) for write, _ in on]
        found += [(first, functools.partial(_write, on)), (end, functools.partial(_write, off))]
    return found


def _write(values: Sequence[tuple[Callable[[float], object], float]]) -> None:
    for write, value in values:
        write(value)


def _own_points(fdm: jsbsim.FGFDMExec, damage: Sequence[Struck], where: str) -> int:
    """Return the index of the first point mass that was added; they are behind those of the aircraft."""
    wanted = sum(d.entry.changes_mass for d in damage) * POINTS
    manager, n = fdm.get_property_manager(), 0
    while manager.get_node(f"inertia/pointmass-weight-lbs[{n}]") is not None:
        n += 1
    if n < wanted:
        raise InputError(
            where,
            found="a <mass_balance> to which no point mass can be added",
            expected="damage that changes no mass, or a <mass_balance> with its elements in the aircraft's main file",
            remedy="write the elements of <mass_balance> into the main file",
        )
    return n - wanted


def _structural(cg: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return a place, m, body axes from the centre of gravity, in structural inches: x aft, y right, z up."""
    return cg + np.array([-1.0, 1.0, -1.0]) * place / IN_M


def _switch(i: int) -> str:
    return f"{NAME}/on-{i}"


def _reactions(i: int, entry: Any) -> list[_Reaction]:
    """Return the forces and moments of an entry, the i-th of a flight."""
    found: list[_Reaction] = []

    def add(kind: str, frame: str, direction: tuple[int, ...], terms: str, place: Any = None, side: float = 0) -> None:
        name = f"{NAME}-{i}-{len(found)}"
        at = "" if kind == "moment" else '<location unit="IN"><x>0</x><y>0</y><z>0</z></location>'
        towards = "".join(f"<{axis}>{value}</{axis}>" for axis, value in zip("xyz", direction, strict=True))
        size = f"<function><product>{_read(_switch(i))}{terms}</product></function>"
        xml = f'<{kind} name="{name}" frame="{frame}">{at}<direction>{towards}</direction>{size}</{kind}>'
        found.append(_Reaction(name, xml, place, side))

    if (lost := entry.lift_lost) is not None:
        share = _value(0.5 * lost.fraction) + _read("forces/fwz-aero-lbs")  # positive up, as lift is
        side = lost.position if lost.side == "right" else -lost.position
        add("force", "WIND", (0, 0, 1), share, "reference", side)
    if entry.drag_area_m2:
        terms = _read("aero/qbar-psf") + _value(entry.drag_area_m2 / FT_M**2)
        add("force", "WIND", (-1, 0, 0), terms, entry.drag_at_m)
    for direction, newtons, area, moment in zip(
        _UNIT, entry.force_n, entry.force_area_m2, entry.moment_nm, strict=True
    ):
        if newtons:
            add("force", "BODY", direction, _value(newtons / LBF_N), entry.force_at_m)
        if area:
            add("force", "BODY", direction, _read("aero/qbar-psf") + _value(area / FT_M**2), entry.force_at_m)
        if moment:
            add("moment", "BODY", direction, _value(moment / SLUGFT2_KGM2))
    for axis, (frame, direction, lengths) in _AXES.items():
        made = [
            _joined("product", [_value(value), *map(_read, _OF[name[3:]])])
            for name, value in entry.coefficients.items()
            if name[1] == axis and value
        ]
        if made:
            kind, place = ("moment", None) if lengths else ("force", "reference")
            add(kind, frame, direction, _read(*_QS, *lengths) + _joined("sum", made), place)
    return found


def _read(*names: str) -> str:
    return "".join(f"<property>{name}</property>" for name in names)


def _joined(operator: str, parts: Sequence[str]) -> str:
    """Return a sum or a product; JSBSim complains about one of a single part."""
    return parts[0] if len(parts) == 1 else f"<{operator}>{''.join(parts)}</{operator}>"


def _value(number: float) -> str:
    return f"<value>{number!r}</value>"


def _node(fdm: jsbsim.FGFDMExec, name: str) -> jsbsim.FGPropertyNode:
    node = fdm.get_property_manager().get_node(name)
    if node is None:  # JSBSim would create it silently at the first write
        raise KeyError(name)
    return node
