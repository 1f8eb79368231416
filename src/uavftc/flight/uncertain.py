"""The vehicle that flies, where it is not the nominal one: what it is, what is said of it, and what is refused."""

from __future__ import annotations

from typing import Any, NamedTuple
from xml.parsers import expat

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.config.explain import describe
from uavftc.config.values import Problem
from uavftc.flight.named import refuse
from uavftc.plants.jsbsim.functions import functions, meant, plain_utf8
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.plants.mass import impossible, uncertain_piece
from uavftc.scenario.schema import Scenario

_ANALYTIC = {
    "mass_factor": "the rotational model has no mass",
    "cg_shift_m": "the rotational model has no centre of gravity",
    "coefficients": "the rotational model has no aerodynamic functions, only the pair A_l, B_m as measured or printed",
}
SECTION = "uncertainty"


class Vehicle(NamedTuple):
    """The vehicle that flies."""

    mass: float
    """kg."""
    inertia: np.ndarray
    """About its centre of gravity, shape (3, 3), kg m^2, matrix signs."""
    factors: dict[str, float]
    """On aerodynamic functions, by their whole names; those that change something."""


def nominal(aircraft: Aircraft, model: TrimmedModel | None) -> tuple[float, np.ndarray]:
    """Return mass, kg, and inertia, kg m^2, of the aircraft as it is known."""
    if model is not None:
        return model.mass_kg, np.array(model.inertia_kgm2)
    assert aircraft.mass_properties is not None  # or there would be a trimmed model
    return aircraft.mass_properties.mass_kg, np.array(aircraft.mass_properties.inertia_kgm2)


def vehicle_of(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None) -> Vehicle:
    """Return the vehicle that flies, whole; damage comes later.

    Raises
    ------
    InputError
        With the place of each key that the plant or the aircraft does not have, or that leaves no rigid body.
    """
    uncertainty, (mass, J) = scenario.uncertainty, nominal(aircraft, model)
    found, factors = _functions(scenario, aircraft)
    if scenario.plant == "analytic":
        found += _on_analytic(scenario)
    wrong = impossible(mass, J, [uncertain_piece(uncertainty, mass, J)]) if uncertainty.changes_mass else None
    if not found and wrong is not None:
        key = "inertia_factor" if uncertainty.changes_inertia else "mass_factor"
        of = f"{wrong}, of the nominal {mass:.6g} kg and {', '.join(f'{v:.6g}' for v in np.diag(J))} kg m^2"
        expected = "a rigid body: mass > 0, inertia positive definite, no principal moment above the sum of the others"
        found = [Problem((SECTION, key), of, expected, "choose factors nearer to 1, or nearer to each other")]
    refuse(scenario, found)
    changed = {name: value for name, value in factors.items() if value != 1.0}
    return Vehicle(mass * uncertainty.mass_factor, uncertainty.inertia(J), changed)


def _on_analytic(scenario: Scenario) -> list[Problem]:
    """Return what the analytic plant does not represent."""
    uncertainty = scenario.uncertainty
    changed = {
        "mass_factor": uncertainty.mass_factor != 1.0,
        "cg_shift_m": any(uncertainty.cg_shift_m),
        "coefficients": any(value != 1.0 for value in uncertainty.coefficients.values()),
    }
    expected, remedy = "on plant: analytic, inertia_factor alone", "fly it on plant: jsbsim, or leave the key out"
    return [
        Problem((SECTION, key), f"{key}, and {_ANALYTIC[key]}", expected, remedy)
        for key, is_so in changed.items()
        if is_so
    ]


def _functions(scenario: Scenario, aircraft: Aircraft) -> tuple[list[Problem], dict[str, float]]:
    """Return what is wrong with the names of `coefficients`, and the factors by whole names."""
    coefficients = scenario.uncertainty.coefficients
    if not coefficients:
        return [], {}
    names, elsewhere = function_names(aircraft)
    problems: list[Problem] = []
    factors: dict[str, float] = {}
    first: dict[str, str] = {}
    for name, value in coefficients.items():
        key = (SECTION, "coefficients", name)
        if elsewhere is not None or not names:
            what = f"aerodynamics in a file of their own, {elsewhere}" if elsewhere else "no aerodynamic functions"
            expected = f"functions with names under <aerodynamics> in {aircraft.xml.name}"
            remedy = "move <aerodynamics> into the main file" if elsewhere else "leave coefficients out"
            problems.append(Problem(key, f"{describe(name)}, where {scenario.aircraft} has {what}", expected, remedy))
            continue
        means = meant(name, names)
        if means.function is None:
            expected = f"{means.expected}, the aerodynamic functions of {scenario.aircraft}"
            problems.append(Problem(key, describe(name), expected, means.remedy))
        elif means.function in factors:
            what = f"{describe(name)}, which is {first[means.function]} again ({means.function})"
            problems.append(Problem(key, what, "one factor for each function", "leave one of the two out"))
        else:
            factors[means.function], first[means.function] = value, name
    return problems, factors


def function_names(aircraft: Aircraft) -> tuple[list[str], str | None]:
    """Return the names of the aerodynamic functions in an aircraft's main file, and the file they are in instead."""
    try:
        found = functions(plain_utf8(aircraft.xml.read_bytes()))
    except (OSError, UnicodeError, expat.ExpatError):  # whoever loads it says what is wrong
        return [], None
    return found.names, found.elsewhere


def document_of(scenario: Scenario, vehicle: Vehicle) -> dict[str, Any] | None:
    """Return what is flown, as `summary.json` has it under the settings of the plant; None of the nominal aircraft."""
    if not (scenario.uncertainty.changes_mass or vehicle.factors):
        return None
    mass = {"mass_kg": vehicle.mass, "cg_shift_m": list(scenario.uncertainty.cg_shift_m)}
    own = {**mass, "factors": vehicle.factors} if scenario.plant == "jsbsim" else {}
    return {**own, "inertia_kgm2": vehicle.inertia.tolist()}


def remarks(scenario: Scenario, flown: dict[str, Any] | None) -> list[str]:
    """Return in a line how the vehicle that flew differs from the nominal one; `flown` as from `document_of`."""
    if flown is None:
        return []
    uncertainty = scenario.uncertainty
    said = [f"mass x {uncertainty.mass_factor:g} ({flown['mass_kg']:.6g} kg)"] if uncertainty.mass_factor != 1.0 else []
    if uncertainty.changes_inertia:
        said.append(f"inertia x {', '.join(f'{factor:g}' for factor in uncertainty.inertia_factor)}")
    if any(uncertainty.cg_shift_m):
        said.append(f"centre of gravity moved by {', '.join(f'{m:g}' for m in uncertainty.cg_shift_m)} m")
    said += [f"{name} x {value:g}" for name, value in flown.get("factors", {}).items()]
    return [f"uncertainty: the vehicle flies with {'; '.join(said)}; trim, design and gains are the nominal aircraft's"]
