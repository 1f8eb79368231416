"""Point masses put into the copy of an aircraft: without weight until they get one, placed when the vehicle is known.

They stand at a mark until then: an index says nothing, an included file may have more. A weight of zero changes no bit.
"""

from __future__ import annotations

from typing import NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim.copy import Addition
from uavftc.plants.jsbsim.load import inertia
from uavftc.plants.jsbsim.units import IN_M, SLUG_KG
from uavftc.plants.mass import Body, Piece, points_of

_OURS = "uavftc-"


class Added(NamedTuple):
    """Point masses of one purpose."""

    name: str
    """Of each of them."""
    mark: float
    """Where they stand until they are placed, in; of no other purpose."""
    number: int

    @property
    def addition(self) -> Addition:
        """What the copy of the aircraft has for them."""
        at = f'<location unit="IN"><x>{self.mark}</x><y>0</y><z>0</z></location>'
        one = f'<pointmass name="{self.name}"><weight unit="LBS">0</weight>{at}</pointmass>'
        return Addition("mass_balance", self.number * one)

    def indices(self, fdm: jsbsim.FGFDMExec, where: str, remedy: str) -> list[int]:
        """Return their indices in a loaded aircraft, by the place that they were given.

        Raises
        ------
        InputError
            If they did not come with the aircraft.
        """
        manager, found, n = fdm.get_property_manager(), [], 0
        while (node := manager.get_node(f"inertia/pointmass-location-X-inches[{n}]")) is not None:
            if node.get_double_value() == self.mark:
                found.append(n)
            n += 1
        if len(found) != self.number:
            of = self.name.removeprefix(_OURS)
            raise InputError(
                where,
                found=f"{len(found)} of {self.number} point masses of {of} in the aircraft as JSBSim has loaded it",
                expected="a <mass_balance> to which point masses can be added",
                remedy=f"{remedy}, or look at <mass_balance> in the aircraft's main file",
            )
        return found


class Scale(NamedTuple):
    """What places and weights of point masses are counted from."""

    cg: np.ndarray
    """Centre of gravity of the vehicle without the pieces, shape (3,), structural inches."""
    radius: float
    """At which the masses stand, m: of the size of the vehicle's, so that weights are of its order."""
    lbs_per_kg: float
    """By JSBSim's own g."""


def scale_of(fdm: jsbsim.FGFDMExec, J: np.ndarray) -> Scale:
    """Return the scale of a vehicle as it is, with the inertia J, shape (3, 3), kg m^2."""
    mass = fdm["inertia/mass-slugs"] * SLUG_KG
    cg = np.array([fdm[f"inertia/cg-{axis}-in"] for axis in "xyz"])
    return Scale(cg, float(np.sqrt(0.5 * np.trace(J) / mass)), fdm["inertia/weight-lbs"] / mass)


def placed(fdm: jsbsim.FGFDMExec, points: list[int], piece: Piece, scale: Scale) -> list[tuple[str, float]]:
    """Set the places of the point masses of a piece; return the properties of their weights, and the weights, lb."""
    masses, places = points_of(piece, scale.radius)
    weights = []
    for point, kg, place in zip(points, masses.tolist(), places, strict=True):
        for axis, inches in zip("XYZ", structural(scale.cg, place), strict=True):
            fdm[f"inertia/pointmass-location-{axis}-inches[{point}]"] = inches
        weights.append((f"inertia/pointmass-weight-lbs[{point}]", scale.lbs_per_kg * kg))
    return weights


def structural(cg: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return a place, m, body axes from the centre of gravity, in structural inches: x aft, y right, z up."""
    return cg + np.array([-1.0, 1.0, -1.0]) * place / IN_M


def held(fdm: jsbsim.FGFDMExec, cg: np.ndarray) -> Body:
    """Return mass, centre of gravity from `cg`, structural inches, and inertia as JSBSim holds them."""
    now = np.array([fdm[f"inertia/cg-{axis}-in"] for axis in "xyz"])
    shift = np.array([-1.0, 1.0, -1.0]) * (now - cg) * IN_M
    return Body(fdm["inertia/mass-slugs"] * SLUG_KG, shift, inertia(fdm))


def refuse_name(aircraft: Aircraft, name: str, of: str) -> str:
    """Refuse an aircraft whose XML has a name that begins as those of additions; return where it is, for messages.

    Raises
    ------
    InputError
        If it has.
    """
    where = f"aircraft {aircraft.name}, {aircraft.xml}"
    if name.encode() in aircraft.xml.read_bytes():
        expected = f"none that {of} has for its own"
        raise InputError(where, found=f"the name {name}", expected=expected, remedy="choose another name there")
    return where
