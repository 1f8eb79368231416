"""The vehicle that flies, where it is not the nominal one: point masses and factors in the copy of the aircraft.

The factors are in the copy, so JSBSim knows of them from the load on. The point masses get their weight when the
vehicle is settled at the nominal trim and still frozen (`trim.start`); after `FRAMES` frames JSBSim has the mass, the
inertia of tanks about the new centre of gravity, and a past of the new accelerations for its integrators. Then what it
holds is compared with what was asked for.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim.copy import Change
from uavftc.plants.jsbsim.events import Told
from uavftc.plants.jsbsim.functions import Factor
from uavftc.plants.jsbsim.points import Added, held, placed, refuse_name, scale_of
from uavftc.plants.mass import POINTS, damaged, uncertain_piece

NAME = "uavftc-uncertainty"
POINT_MASSES = Added(NAME, -876543.0, POINTS)
FRAMES = 6  # one for the mass, one more for tanks, and four of the accelerations: JSBSim's integrators look back so far
ACCURACY = 1e-6  # of mass and inertia, relative, and of the centre of gravity by the radius of gyration


def told(aircraft: Aircraft, uncertainty: Any, factors: Mapping[str, float]) -> Told:
    """Return what the copy of an aircraft has for an `uncertainty`, and what is done to it when it is settled.

    `factors` are those on aerodynamic functions, by their whole names.

    Raises
    ------
    InputError
        If the aircraft's XML has a name that begins as those of the additions.
    """
    changes: list[Change] = [Factor(name, float(value)) for name, value in factors.items()]
    if not uncertainty.changes_mass:
        return Told(additions=tuple(changes))
    where = refuse_name(aircraft, NAME, "uncertainty")
    return Told(
        additions=(*changes, POINT_MASSES.addition), settled=functools.partial(_make_heavier, uncertainty, where)
    )


def _make_heavier(uncertainty: Any, where: str, fdm: jsbsim.FGFDMExec) -> None:
    """Give a vehicle that is settled and frozen the mass, centre of gravity and inertia that fly.

    Raises
    ------
    InputError
        If JSBSim does not hold them then.
    """
    remedy = "leave mass_factor, inertia_factor and cg_shift_m of uncertainty out"
    points = POINT_MASSES.indices(fdm, where, remedy)
    nominal_cg = np.array([fdm[f"inertia/cg-{axis}-in"] for axis in "xyz"])
    nominal = held(fdm, nominal_cg)
    piece = uncertain_piece(uncertainty, nominal.mass, nominal.inertia)
    for name, pounds in placed(fdm, points, piece, scale_of(fdm, nominal.inertia)):
        fdm[name] = pounds
    for _ in range(FRAMES):
        fdm.run()
    asked, now = damaged(nominal.mass, nominal.inertia, [piece]), held(fdm, nominal_cg)
    radius = float(np.sqrt(np.trace(nominal.inertia) / nominal.mass))
    off = max(
        abs(now.mass - asked.mass) / asked.mass,
        float(np.max(np.abs(now.cg - asked.cg))) / radius,
        float(np.max(np.abs(now.inertia - asked.inertia)) / np.max(np.abs(asked.inertia))),
    )
    if not off <= ACCURACY:
        raise InputError(
            where,
            found=f"{now.mass:.9g} kg and {np.diag(now.inertia).tolist()} kg m^2 in JSBSim",
            expected=f"{asked.mass:.9g} kg and {np.diag(asked.inertia).tolist()} kg m^2, as uncertainty asks for",
            remedy=remedy,
        )
