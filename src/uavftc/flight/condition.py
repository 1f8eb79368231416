"""The condition of a flight: at which airspeed and altitude, and whether the controller can fly the aircraft there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from uavftc.actuators.saturation import axis_limits
from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.authority import RATIO_MIN, Authority, authority, can_be_held, controlled_axes, obstacles, response
from uavftc.control.inner.predictor import A_M
from uavftc.core.axes import Controlled, left_to_the_airframe
from uavftc.core.signals import AXES, SURFACES
from uavftc.errors import InputError
from uavftc.flight.layouts import claimed_layout, claimed_stops
from uavftc.plants.jsbsim.model import ALTITUDE_M, TrimmedModel, stepped, trimmed_model, trimmed_models
from uavftc.scenario.controllers import CustomController
from uavftc.scenario.schema import Scenario

AMPLE = 3.0  # authority, available over demanded, that is enough to choose an airspeed without looking further
SPARE = 0.2  # of the throttle, left at the trim: with less, an airspeed is chosen only where there is no better

BANDWIDTH = (0.5, 0.5, 0.5)  # 1/s, the paper's
STEP_RAD = math.radians(5.0)  # the paper's step; see reasons_against_any


def model_of(scenario: Scenario, aircraft: Aircraft) -> TrimmedModel | None:
    """Return the aircraft's trimmed model at the scenario's condition, or None where the analytic plant needs none.

    Where neither scenario nor aircraft give an airspeed, the lowest with authority for the demanded step is chosen.

    Raises
    ------
    InputError
        If there is no trim, or the controller cannot fly the aircraft there.
    """
    if scenario.plant == "analytic" and aircraft.analytic is not None and aircraft.mass_properties is not None:
        return None
    airspeed, altitude = condition_of(scenario, aircraft)
    if airspeed is None:
        model = choose_airspeed(scenario, aircraft, trimmed_models(aircraft, altitude))
    else:
        model = trimmed_model(aircraft, airspeed, altitude)
        refuse_unflyable(scenario, aircraft, model)
    return stepped(aircraft, model) if scenario.plant == "jsbsim" else model


def condition_of(scenario: Scenario, aircraft: Aircraft) -> tuple[float | None, float]:
    """Return airspeed, m/s, and altitude, m, of the scenario, or else the aircraft's; None is to be chosen."""
    default = aircraft.initial
    altitude = scenario.initial.altitude_m or (default.altitude_m if default else ALTITUDE_M)
    return scenario.initial.airspeed_mps or (default.airspeed_mps if default else None), altitude


def authority_of(scenario: Scenario, model: TrimmedModel) -> Authority:
    """Return the authority of a trimmed model for the largest step of the scenario's reference."""
    controller = scenario.controller
    # a custom controller states neither; the paper's values stand for an ordinary step
    A_m, bandwidth = A_M, BANDWIDTH
    if not isinstance(controller, CustomController):
        A_m = getattr(controller.inner, "A_m", A_m)  # and so do laws that have neither
        bandwidth = getattr(controller.outer, "bandwidth", bandwidth)
    return authority(
        np.array(model.A),
        np.array(model.B),
        reach_of(model),
        A_m=np.array(A_m),
        bandwidth=np.array(bandwidth),
        step=largest_step(scenario),
        axes=axes_of_model(model),
    )


def largest_step(scenario: Scenario) -> np.ndarray:
    """Return the largest change of the reference from the trim, shape (3,), rad."""
    reference, t = scenario.reference, scenario.times()
    signals = (reference.phi_deg, reference.theta_deg, reference.psi_deg)
    return np.radians([float(np.max(np.abs(s.sample(t[:1] if s.constant is not None else t)))) for s in signals])


def reach_of(model: TrimmedModel) -> np.ndarray:
    """Return what each axis can do to either side, as measured at full command, rad, (3, 2)."""
    return np.array(model.reach_rad if len(model.reach_rad) else model.limits_rad)


def choose_airspeed(scenario: Scenario, aircraft: Aircraft, models: Sequence[TrimmedModel]) -> TrimmedModel:
    """Return the model at the lowest airspeed with ample authority, or else with the most.

    Raises
    ------
    InputError
        If none has enough.
    """
    best = best_model(scenario, models)
    refuse_unflyable(scenario, aircraft, best)
    return best


def best_model(scenario: Scenario, models: Sequence[TrimmedModel]) -> TrimmedModel:
    """Return the model at the lowest airspeed with ample authority, or else with the most, flyable or not."""
    ratios = []
    for model in models:
        ratio = -1.0 if obstacles_of(model) else float(np.nanmin(authority_of(scenario, model).ratio))
        spare = (1.0 - model.trim.get("throttle", 0.0)) / SPARE
        short_of_thrust = spare < 1.0 and ratio > RATIO_MIN
        ratios.append(RATIO_MIN + spare * (min(ratio, AMPLE) - RATIO_MIN) if short_of_thrust else ratio)
    ample = [i for i, ratio in enumerate(ratios) if ratio >= AMPLE]
    return models[ample[0] if ample else int(np.argmax(ratios))]


def obstacles_of(model: TrimmedModel) -> list[str]:
    """Return why no controller can fly an aircraft at a trim, whatever it is asked to do; empty if one can."""
    return obstacles(model.B_rates, np.array(model.limits_rad), np.array(model.nonlinearity), None)


def reasons_against(scenario: Scenario, model: TrimmedModel) -> list[str]:
    """Return why the controller cannot fly an aircraft at a trim; empty if it can."""
    limits, nonlinearity = np.array(model.limits_rad), np.array(model.nonlinearity)
    found = obstacles_of(model)
    return found or obstacles(model.B_rates, limits, nonlinearity, authority_of(scenario, model).ratio)


def contradictions(aircraft: Aircraft, model: TrimmedModel) -> list[str]:
    """Return which surfaces the companion file's B_m has, and the XML does nothing with: one of the two is wrong."""
    if aircraft.analytic is None:
        return []
    B_m, limits = np.array(aircraft.analytic.B_m), np.array(model.limits_rad)
    claimed = controlled_axes(B_m, limits)
    return [
        f"no small-signal {SURFACES[j]} response: {response(model.B_rates, limits)[j]:.2g} rad/s^2 at full deflection, "
        f"where analytic.B_m has {B_m[j, j]:g} 1/s^2 (0 in its column is an aircraft without)"
        for j in range(3)
        if claimed[j] and not model.axes[j]
    ]


def reasons_against_any(aircraft: Aircraft, model: TrimmedModel) -> list[str]:
    """Return why an aircraft with a rotational model in its companion file cannot be flown; empty if it can.

    No scenario is refused for its reference or its bandwidth: such an aircraft is flown to its limits on purpose. But
    what it controls it must control, which is checked with a step of `STEP_RAD` at the paper's bandwidth.
    """
    if found := obstacles_of(model) or contradictions(aircraft, model):
        return found
    limits, nonlinearity, step = reach_of(model), np.array(model.nonlinearity), np.full(3, STEP_RAD)
    A, B = np.array(model.A), np.array(model.B)
    demand = {"A_m": np.array(A_M), "bandwidth": np.array(BANDWIDTH), "step": step}
    counted = authority(A, B, limits, **demand, axes=axes_of_model(model))
    return [
        line.replace("for the reference", "for a small step")
        for line in obstacles(model.B_rates, limits, nonlinearity, counted.ratio)
    ]


def refuse_unflyable(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel) -> None:
    """Refuse an aircraft that the controller cannot fly at a trim.

    Raises
    ------
    InputError
        If the axes that respond cannot hold an attitude, B is ill-conditioned, or an axis has too little authority for
        the reference.
    """
    if aircraft.analytic is None:
        found, step, smaller = reasons_against(scenario, model), "the reference", ", a smaller reference"
    else:
        found, step, smaller = reasons_against_any(aircraft, model), f"a step of {math.degrees(STEP_RAD):g} deg", ""
    if found:
        airspeed = model.trim["airspeed"]
        raise InputError(
            f"aircraft {aircraft.name}, at {airspeed:g} m/s and {model.trim['altitude']:g} m",
            found="; ".join(found),
            expected="surfaces that respond, about pitch and about roll or yaw, each mostly on its own axis, with "
            f"authority for {step}",
            remedy=f"choose another initial.airspeed_mps{smaller}, or correct or choose another aircraft "
            f"(uavftc design {aircraft.reference} shows the numbers)",
        )


def axes_of_model(model: TrimmedModel) -> Controlled:
    """Return which axes of a trimmed aircraft are controlled."""
    roll, pitch, yaw = model.axes
    return roll, pitch, yaw


def axes_of(aircraft: Aircraft, model: TrimmedModel | None) -> Controlled:
    """Return which axes are controlled: those of the trimmed model, or of the companion file's rotational model.

    Raises
    ------
    InputError
        If those of the companion file cannot hold an attitude; a trimmed model was judged where it was chosen.
    """
    if model is not None:
        return axes_of_model(model)
    assert aircraft.analytic is not None  # or there would be a trimmed model
    limits = axis_limits(claimed_stops(aircraft), claimed_layout(aircraft).mixing)
    axes = controlled_axes(np.array(aircraft.analytic.B_m), limits)
    if not can_be_held(axes):
        raise InputError(
            f"{aircraft.companion}, key analytic.B_m",
            found=f"{np.array(aircraft.analytic.B_m).tolist()}: {'; '.join(left_to_the_airframe(axes))}",
            expected="surfaces that act about pitch and about roll or yaw",
            remedy="correct the entries on its diagonal, 1/s^2 per rad",
        )
    return axes


def refuse_uncontrolled(scenario: Scenario, aircraft: Aircraft, axes: Controlled) -> None:
    """Refuse a reference about an axis that nothing acts on.

    Raises
    ------
    InputError
        If such a reference is not zero at some sample.
    """
    for j, step in enumerate(largest_step(scenario)):
        if step and not axes[j]:
            key = list(type(scenario.reference).model_fields)[j]
            raise InputError(
                f"key reference.{key}",
                found=getattr(scenario.reference, key).text,
                expected=f"0, because {aircraft.name} has no {SURFACES[j]} (no effector acts about {AXES[j]})",
                remedy=f"leave it out (--set reference.{key}=0)",
            )


def check_start(scenario: Scenario) -> None:
    """Refuse an envelope that the flight would start outside of.

    Raises
    ------
    InputError
        If the initial airspeed is not inside the envelope of a resolved scenario.
    """
    low, high = scenario.envelope.min_airspeed_mps or 0.0, scenario.envelope.max_airspeed_mps or math.inf
    airspeed = scenario.initial.airspeed_mps or 0.0
    if scenario.plant == "jsbsim" and not low < airspeed < high:
        raise InputError(
            "key envelope",
            found=f"an airspeed at the start of {airspeed:g} m/s, outside {low:g} to {high:g} m/s",
            expected="a flight that starts inside its envelope",
            remedy="change initial.airspeed_mps, envelope.min_airspeed_mps or envelope.max_airspeed_mps",
        )
