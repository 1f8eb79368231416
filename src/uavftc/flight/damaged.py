"""Damage that cannot be flown: what a plant does not represent, and what no rigid body can be."""

from __future__ import annotations

import numpy as np

from uavftc.config.explain import MAX_SHOWN
from uavftc.config.values import Problem
from uavftc.errors import InputError, join
from uavftc.flight.uncertain import Vehicle
from uavftc.plants.mass import at_a_time, impossible, piece_of
from uavftc.scenario.damage import Damage
from uavftc.scenario.schema import Scenario

_ROTATIONAL = {
    "mass_kg": "a mass", "cg_m": "a centre of gravity", "lift_lost": "forces", "drag_area_m2": "forces",
    "force_n": "forces", "force_area_m2": "forces", "coefficients": "a dynamic pressure",
}  # fmt: skip
"""What the analytic plant lacks for a key."""


def refuse_damage(scenario: Scenario, vehicle: Vehicle) -> None:
    """Refuse damage that the plant cannot represent, or that leaves no mass or no inertia at any time of the vehicle.

    Raises
    ------
    InputError
        With the place of each key.
    """
    if not scenario.damage:
        return
    found = _analytic(scenario) if scenario.plant == "analytic" else []
    if not found:
        found = _bodies(scenario, vehicle.mass, vehicle.inertia)
    if found:
        where = scenario.origin.where
        raise join(
            [InputError(where(p.key), found=p.found, expected=p.expected, remedy=p.remedy) for p in found[:MAX_SHOWN]]
        )


def _analytic(scenario: Scenario) -> list[Problem]:
    found = []
    expected = "on plant: analytic, control_power and inertia_kgm2 with ixx, iyy, izz and ixz"
    remedy = "fly it on plant: jsbsim, or leave the key out"
    for i, entry in enumerate(scenario.damage):
        changed = [
            key
            for key in _ROTATIONAL
            if getattr(entry, key) != Damage.model_fields[key].get_default(call_default_factory=True)
        ]
        for key in changed:
            lacks = f"{key}, for which the rotational model has no {_ROTATIONAL[key].removeprefix('a ')}"
            found.append(Problem(("damage", i, key), lacks, expected, remedy))
        if any(entry.moment_nm):
            moment = "a disturbance of kind angular-acceleration does the same there; or fly it on plant: jsbsim"
            found.append(Problem(("damage", i, "moment_nm"), "a moment of damage", expected, moment))
        for key in ("ixy_kgm2", "iyz_kgm2"):
            if getattr(entry.inertia_kgm2, key):
                lacks = f"{key}, and eq. (2) holds for a plane of symmetry"
                found.append(Problem(("damage", i, "inertia_kgm2", key), lacks, expected, remedy))
    return found


def _bodies(scenario: Scenario, mass: float, J: np.ndarray) -> list[Problem]:
    """Return the first time at which what is left of the vehicle is no rigid body."""
    pieces = [piece_of(entry, mass) for entry in scenario.damage]
    for since, acting in at_a_time(scenario.damage):
        those = [i for i in acting if scenario.damage[i].changes_mass]
        wrong = impossible(mass, J, [pieces[i] for i in those])
        if those and wrong is not None:
            together = "" if len(those) == 1 else f" with {' and '.join(f'damage[{i}]' for i in those[:-1])}"
            left = f"{wrong} left of the {mass:.6g} kg and {', '.join(f'{v:.6g}' for v in np.diag(J))} kg m^2"
            expected = "a rigid body at any time: mass > 0, inertia positive definite, no principal moment above the "
            expected += "sum of the others"
            at = f"{left} of the aircraft, from {since:g} s{together}"
            return [Problem(("damage", those[-1]), at, expected, "take less away, or move one of the windows")]
    return []
