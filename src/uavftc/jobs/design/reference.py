"""A design compared with a flight: the prediction error, the reference system (45), and the bounds where they hold."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavftc.analysis.l1_condition import Given, norms_of, theorem_3
from uavftc.analysis.reference_system import (
    Replay,
    assumptions_not_met,
    differences,
    lumped_disturbance,
    replay,
    simulate,
)
from uavftc.config.effect import default_kind
from uavftc.control.gains import reference_gain
from uavftc.control.inner import l1
from uavftc.control.inner.predictor import PredictorConfig
from uavftc.core.axes import indices, reduced
from uavftc.errors import InputError
from uavftc.flight.build import Flight, build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.flight.rotational import rotational_model
from uavftc.scenario.controllers import Controller
from uavftc.scenario.schema import Scenario

SAMPLED = (
    "the bounds are those of the continuous law; the law that flew is sampled, and what that adds to the differences "
    "shrinks in proportion to the sample time"
)


def flight_document(scenario: Scenario) -> dict[str, Any]:
    """Fly a scenario, on its plant and on the analytic one, and return the observed maxima next to the bounds.

    Raises
    ------
    InputError
        If the flight cannot be built, or its inner loop is not L1.
    """
    l1_of(inner_of(scenario), scenario)
    flight = build_flight(scenario)
    flights = [_flown(flight)]
    if scenario.plant != "analytic" and not flight.inputs.acts_on("wind_n"):
        flights.append(_flown(build_flight(scenario.model_copy(update={"plant": "analytic"}))))
    return {"scenario": scenario.name, "flights": flights}


def _flown(flight: Flight) -> dict[str, Any]:
    records, outcome = fly_to_memory(flight)
    (block,) = l1.blocks(l1_of(inner_of(flight.scenario), flight.scenario), flight.given)
    state = replay(block, records)
    result = {
        "plant": flight.scenario.plant,
        "completed": outcome.completed,
        "ended_because": outcome.ended_because,
        "rate_hz": flight.scenario.controller.rate_hz,
        "max_r_radps": _of_controlled(flight, np.max(np.abs(records["v1"]), axis=0)),
        "max_x2_tilde_radps": (largest := _of_controlled(flight, np.max(np.abs(state.x2_tilde), axis=0))),
        "gamma_0": float(np.nanmax(largest)),
        "assumptions_not_met": assumptions_not_met(records, flight.scenario.limits_rad()),
        "reference_system": None,
        "bounds": None,
        "reason": None,
    }
    if flight.scenario.plant != "analytic":
        result["reason"] = "eta is known on the analytic plant only"
    elif len(records) < 2:
        result["reason"] = "the flight has less than two samples"
    else:
        result |= _reference_system(flight, records, state, result)
    return result


def _of_controlled(flight: Flight, values: np.ndarray) -> np.ndarray:
    """Return a value of each axis, nan where it is not controlled."""
    return np.where(flight.given.axes, values, np.nan)


def _reference_system(flight: Flight, records: np.ndarray, state: Replay, observed: dict[str, Any]) -> dict[str, Any]:
    """Return the reference system, printed and with A_m, for a flight on the analytic plant."""
    inner = l1_of(inner_of(flight.scenario), flight.scenario)
    inertia, A_l, B_l = rotational_model(flight.aircraft, flight.model)
    axes, k = flight.given.axes, inner.filter_bandwidth
    own = indices(axes)
    A_m, B_m, K_1 = (reduced(np.array(m), axes) for m in (inner.A_m, inner.B_m, inner.K_1))
    A_s = A_m + K_1
    K_2 = reference_gain(A_s, B_m)
    K = reference_gain(A_m, B_m) if inner.reference_gain == "plant" else K_2
    eta = lumped_disturbance(
        records,
        state.v_ad,
        inertia=inertia,
        A_l=A_l,
        B_l=B_l,
        A_m=A_m,
        B_m=B_m,
        axes=axes,
    )

    def whole(values: np.ndarray) -> np.ndarray:
        filled = np.full(3, np.nan)
        filled[own] = values
        return filled

    systems: dict[str, Any] = {}
    limits: dict[str, Any] | None = None if observed["assumptions_not_met"] else {}
    given = Given(lipschitz=0.0, gamma_0=observed["gamma_0"])
    for name, A, gain in (("A_s_K_2", A_s, K_2), ("A_s", A_s, K), ("A_m", A_m, K)):
        found = differences(
            records,
            state.v_ad,
            simulate(records, eta, A=A, B_m=B_m, K=gain, filter_bandwidth=k, v_start=state.v_ad[0], axes=axes),
            axes,
        )
        largest = float(np.max(found.x2))
        systems[name] = {
            "max_x_ref_minus_x2_radps": whole(found.x2),
            "largest_radps": largest,
            "share_of_max_r": largest / max(float(np.nanmax(observed["max_r_radps"])), 1e-300),
            "max_v_ref_minus_v_ad_rad": whole(found.v_ad),
            "largest_rad": float(np.max(found.v_ad)),
        }
        if limits is not None and name != "A_s_K_2":
            omega = records["effectiveness"][0][own]
            bound = theorem_3(norms_of(A, A_s=A_s, B_m=B_m, K=gain, filter_bandwidth=k, omega=omega), given)
            limits[name] = {
                "gamma_1": bound.gamma_1,
                "gamma_2": bound.gamma_2,
                "x2_within": bound.gamma_1 is not None and largest <= bound.gamma_1,
                "v_ad_within": bound.gamma_2 is not None and systems[name]["largest_rad"] <= bound.gamma_2,
            }
    reason = SAMPLED if limits is not None else "no bound: assumptions are not met"
    return {"reference_system": systems, "bounds": limits, "reason": reason}


def inner_of(scenario: Scenario) -> PredictorConfig | None:
    """Return the inner loop of a scenario's controller, None for a custom controller."""
    return scenario.controller.inner if isinstance(scenario.controller, Controller) else None


def l1_of(inner: PredictorConfig | None, scenario: Scenario | None) -> l1.Config:
    """Return the inner loop, or refuse one that is not L1 with an `InputError`."""
    if isinstance(inner, l1.Config):
        return inner
    raise InputError(
        f"{'' if scenario is None else scenario.name}, key controller.inner.kind",
        found="a custom controller, which has none"
        if inner is None
        else f"{default_kind(type(inner))}, which has no filter C(s)",
        expected="l1",
        remedy="give a scenario with controller.inner.kind: l1, or none",
    )
