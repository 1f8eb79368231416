"""The trimmed aircraft as numbers: trim, linear model, modes, controllability, authority, and whether it is flyable."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.authority import COUPLING_MAX, RESPONSE_MIN, can_be_held, obstacles
from uavftc.analysis.modes import STATES, modes
from uavftc.core.axes import ALL, Controlled, indices, reduced
from uavftc.core.signals import AXES, SURFACES
from uavftc.flight.condition import (
    authority_of,
    axes_of_model,
    best_model,
    condition_of,
    contradictions,
    largest_step,
    reasons_against,
)
from uavftc.flight.uncertain import function_names
from uavftc.jobs.design.effectors import axis_deflections, effector_list, engines_section
from uavftc.plants.jsbsim.model import TrimmedModel, trimmed_model, trimmed_models
from uavftc.scenario.schema import Scenario


def design_model(scenario: Scenario, aircraft: Aircraft) -> TrimmedModel:
    """Return the model at the scenario's condition, or at the airspeed a flight would choose, flyable or not.

    Raises
    ------
    InputError
        If the aircraft does not load or has no trim.
    """
    airspeed, altitude = condition_of(scenario, aircraft)
    if airspeed is None:
        return best_model(scenario, trimmed_models(aircraft, altitude))
    return trimmed_model(aircraft, airspeed, altitude)


def trimmed_sections(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel) -> dict[str, Any]:
    """Return what a trimmed model adds to the design document."""
    reasons = reasons_against(scenario, model) or contradictions(aircraft, model)
    return {
        "verdict": "refused" if reasons else "flyable",
        "reasons": reasons,
        "controlled": dict(zip(AXES, model.axes, strict=True)),
        "mass_kg": model.mass_kg,
        "inertia_kgm2": model.inertia_kgm2,
        "engines": model.engines,
        "trim": trim_section(model),
        "A": model.A_rates,
        "B": model.B_rates,
        "A_full": model.A,
        "B_full": model.B,
        "states": list(STATES),
        "modes": mode_list(np.array(model.A)),
        "controllability": controllability(model),
        "limits_rad": [pair if own else None for pair, own in zip(model.limits_rad, held_axes(model), strict=True)],
        "rad_per_command": model.rad_per_command,
        "deflection_measured": model.measured_rad,
        "nonlinearity": model.nonlinearity,
        "authority": authority_section(scenario, model),
        "throttle_mps2": model.throttle_mps2,
        "effectors": effector_list(model),
        "gangs": {axis: dict(members) for axis, members in model.gangs.items()},
        "propulsion": engines_section(model),
        "aerodynamic_functions": function_names(aircraft)[0],
    }


def held_axes(model: TrimmedModel) -> Controlled:
    """Return the axes that are controlled, or all where they cannot hold an attitude: what is missing is then shown."""
    axes = axes_of_model(model)
    return axes if can_be_held(axes) else ALL


def trim_section(model: TrimmedModel) -> dict[str, Any]:
    """Return the trim: attitude, commands in the aircraft's units, deflections from neutral, accelerations left.

    A surface that the aircraft does not have has no deflection.
    """
    trim = model.trim
    surfaces = zip(SURFACES, axis_deflections(model), held_axes(model), strict=True)
    names = ("u_dot_mps2", "v_dot_mps2", "w_dot_mps2", "p_dot_radps2", "q_dot_radps2", "r_dot_radps2")
    return {
        "method": trim["method"],
        "airspeed_mps": trim["airspeed"],
        "altitude_m": trim["altitude"],
        "alpha_rad": trim["alpha"],
        "theta_rad": trim["theta"],
        "phi_rad": trim["phi"],
        "gamma_rad": trim["theta"] - trim["alpha"],
        "surface_commands": dict(zip(model.names, trim["surfaces"], strict=True)),
        "trim_commands": dict(zip(AXES, trim["trim_commands"], strict=True)),
        **{f"{name}_rad": value if own else None for name, value, own in surfaces},
        "throttle": trim["throttle"],
        "residual": dict(zip(names, trim["residual"], strict=True)),
    }


def mode_list(A: np.ndarray) -> list[dict[str, Any]]:
    """Return the natural modes of a model over `STATES`, shape (8, 8)."""
    return [
        {
            "name": mode.name,
            "motion": mode.motion,
            "eigenvalue": [mode.eigenvalue.real, mode.eigenvalue.imag],
            "natural_frequency_radps": mode.natural_frequency,
            "damping": mode.damping,
            "time_constant_s": mode.time_constant,
        }
        for mode in modes(A)
    ]


def controllability(model: TrimmedModel) -> dict[str, Any]:
    """Return rank and condition of the rate loop, of the axes that are controlled.

    The rank is that of [B, A B, A^2 B] with B at full deflection, counting what answers with more than
    `RESPONSE_MIN`; the condition number is that of B with each surface scaled to its axis, as flights check it.
    """
    axes = held_axes(model)
    A, B = reduced(model.A_rates, axes), reduced(model.B_rates, axes)
    limits = np.max(np.abs(model.limits_rad), axis=1)
    full = B * limits[indices(axes)]
    reach = np.hstack([full, A @ full, A @ A @ full])
    own = np.diag(B)
    return {
        "rank": int(np.linalg.matrix_rank(reach, tol=RESPONSE_MIN)),
        "axes": len(own),
        "condition": float(np.linalg.cond(B / own)) if np.all(own != 0.0) else None,
        "condition_max": COUPLING_MAX,
        "full_deflection_radps2": dict(zip(SURFACES, np.abs(np.diag(model.B_rates)) * limits, strict=True)),
    }


def authority_section(scenario: Scenario, model: TrimmedModel) -> dict[str, Any]:
    """Return demand and supply of each axis for the scenario's largest step; None where an axis is not controlled."""
    step = largest_step(scenario)
    section: dict[str, Any] = {"step_rad": step, "sideslip_rad": None, **dict.fromkeys(AXES)}
    if obstacles(model.B_rates, np.array(model.limits_rad), np.zeros(3), None):
        return section
    found = authority_of(scenario, model)
    section["sideslip_rad"] = found.beta
    for j in indices(axes_of_model(model)):
        section[AXES[j]] = {
            "first_rad": abs(found.first[j]),
            "steady_rad": abs(found.steady[j]),
            "available_rad": found.available[j],
            "ratio": found.ratio[j],
        }
    return section
