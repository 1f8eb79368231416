"""From a scenario to a flight that is ready: aircraft, plant, controller, actuators, inputs.

Nothing reads YAML after this.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from uavftc.actuators import delay, effectiveness, saturation
from uavftc.aircraft.definition import Aircraft, load_aircraft
from uavftc.analysis.authority import Authority, authority, obstacles
from uavftc.control.custom.controller import ControlDesign, own_blocks
from uavftc.control.gains import lyapunov_P, reference_gain
from uavftc.core.stage import Block, Program, PythonBlock, params_of
from uavftc.errors import InputError
from uavftc.flight import envelope
from uavftc.flight.inputs import Inputs
from uavftc.plants.interface import Plant, Timing
from uavftc.plants.jsbsim.model import ALTITUDE_M, TrimmedModel, trimmed_model, trimmed_models
from uavftc.scenario.controllers import A_M, Controller, L1Inner, MracInner, NdiOuter, NndoNdiOuter, OwnController
from uavftc.scenario.schema import Initial, Scenario
from uavftc.sensors import gyro

AMPLE = 3.0  # authority, available over demanded, with which an airspeed is chosen without looking further
NOMINAL_AIRSPEED_MPS = 30.0  # for a rotational model without one; nothing depends on it but the envelope's limits
MAX_ALIGNING = 8  # how many times finer the plant may step so that a delay falls on its steps


@dataclass(frozen=True)
class Flight:
    """Everything the loop needs; it can be flown once."""

    scenario: Scenario
    """As flown: what the scenario left to the aircraft is filled in."""
    aircraft: Aircraft
    model: TrimmedModel | None
    """Of the aircraft at its trim; None where the companion file's rotational model is flown without one."""
    plant: Plant
    program: Program
    inputs: Inputs
    envelope: np.ndarray
    """One record of `envelope.PARAMS`."""
    steps: int
    """Controller steps N; the history has N + 1 rows."""


def build_flight(scenario: Scenario) -> Flight:
    """Return a flight ready to be flown.

    Raises
    ------
    InputError
        If the aircraft does not exist, does not load, or cannot be trimmed.
    """
    aircraft = load_aircraft(scenario.aircraft, f"key aircraft: {scenario.aircraft}")
    model = model_of(scenario, aircraft)
    scenario = resolved(scenario, aircraft, model)
    check_start(scenario)
    timing, whole = timing_of(scenario)
    plant, inputs = make_plant(scenario, aircraft, model, timing)
    watch = params_of(
        envelope.PARAMS,
        bank_max=math.radians(scenario.envelope.bank_deg),
        pitch_max=math.radians(scenario.envelope.pitch_deg),
        airspeed_min=scenario.envelope.min_airspeed_mps,
        airspeed_max=scenario.envelope.max_airspeed_mps,
    )
    blocks = [
        *plant.before(),
        gyro.stage.block(params_of(gyro.PARAMS, bias=np.radians(scenario.sensors.gyro_bias_degps))),
        *controller_blocks(scenario, aircraft, model, plant, timing.h),
        *actuator_blocks(scenario, plant, timing, whole),
        envelope.stage.block(watch),
        *plant.after(),
    ]
    return Flight(scenario, aircraft, model, plant, Program(blocks), inputs, watch, scenario.steps)


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
        return choose_airspeed(scenario, aircraft, trimmed_models(aircraft, altitude))
    model = trimmed_model(aircraft, airspeed, altitude)
    if aircraft.analytic is None:
        refuse_unflyable(scenario, aircraft, model)
    return model


def condition_of(scenario: Scenario, aircraft: Aircraft) -> tuple[float | None, float]:
    """Return airspeed, m/s, and altitude, m, of the scenario or else the aircraft's own; None is to be chosen."""
    own = aircraft.initial
    altitude = scenario.initial.altitude_m or (own.altitude_m if own else ALTITUDE_M)
    return scenario.initial.airspeed_mps or (own.airspeed_mps if own else None), altitude


def authority_of(scenario: Scenario, model: TrimmedModel) -> Authority:
    """Return the authority of a trimmed model for the largest step of the scenario's reference."""
    controller = scenario.controller
    # a controller of one's own states neither; the paper's stand for a step of ordinary haste
    A_m, bandwidth = A_M, (0.5, 0.5, 0.5)
    if not isinstance(controller, OwnController):
        A_m, bandwidth = controller.inner.A_m, controller.outer.bandwidth
    return authority(
        np.array(model.A),
        np.array(model.B),
        np.array(model.limits_rad),
        A_m=np.array(A_m),
        bandwidth=np.array(bandwidth),
        step=largest_step(scenario),
    )


def largest_step(scenario: Scenario) -> np.ndarray:
    """Return the largest change of the reference from the trim, shape (3,), rad."""
    reference, t = scenario.reference, scenario.times()
    signals = (reference.phi_deg, reference.theta_deg, reference.psi_deg)
    return np.radians([float(np.max(np.abs(s.sample(t[:1] if s.constant is not None else t)))) for s in signals])


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
        found = obstacles(model.B_rates, np.array(model.limits_rad), np.array(model.nonlinearity), None)
        ratios.append(-1.0 if found else float(np.min(authority_of(scenario, model).ratio)))
    ample = [i for i, ratio in enumerate(ratios) if ratio >= AMPLE]
    return models[ample[0] if ample else int(np.argmax(ratios))]


def reasons_against(scenario: Scenario, model: TrimmedModel) -> list[str]:
    """Return why the controller cannot fly an aircraft at a trim; empty if it can."""
    limits, nonlinearity = np.array(model.limits_rad), np.array(model.nonlinearity)
    found = obstacles(model.B_rates, limits, nonlinearity, None)
    return found or obstacles(model.B_rates, limits, nonlinearity, authority_of(scenario, model).ratio)


def refuse_unflyable(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel) -> None:
    """Refuse an aircraft that the controller cannot fly at a trim.

    Raises
    ------
    InputError
        If a surface does not respond, B is ill-conditioned, or an axis has too little authority for the reference.
    """
    if found := reasons_against(scenario, model):
        airspeed = model.trim["airspeed"]
        raise InputError(
            f"aircraft {aircraft.name}, at {airspeed:g} m/s and {model.trim['altitude']:g} m",
            found="; ".join(found),
            expected="three surfaces that respond, each mostly on its own axis, with authority for the reference",
            remedy="choose another initial.airspeed_mps, a smaller reference, or another aircraft "
            f"(uavftc design {aircraft.reference} shows the numbers)",
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


def resolved(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None) -> Scenario:
    """Return the scenario with everything filled in that it leaves to the aircraft."""
    own = aircraft.initial
    airspeed = scenario.initial.airspeed_mps or (model.trim["airspeed"] if model else own and own.airspeed_mps)
    altitude = scenario.initial.altitude_m or (model.trim["altitude"] if model else own and own.altitude_m)
    airspeed, altitude = airspeed or NOMINAL_AIRSPEED_MPS, altitude or ALTITUDE_M
    limits = scenario.envelope
    slow, fast = limits.min_airspeed_mps, limits.max_airspeed_mps
    controller = scenario.controller
    if isinstance(controller, Controller) and controller.inner.B_m is None:
        B_m = aircraft.analytic.B_m if aircraft.analytic else _rows(model.B_rates) if model else None
        inner = controller.inner.model_copy(update={"B_m": B_m})
        controller = controller.model_copy(update={"inner": inner})
    return scenario.model_copy(
        update={
            "initial": Initial(airspeed_mps=airspeed, altitude_m=altitude),
            "envelope": limits.model_copy(
                update={
                    "min_airspeed_mps": 0.5 * airspeed if slow is None else slow,
                    "max_airspeed_mps": 2.0 * airspeed if fast is None else fast,
                }
            ),
            "controller": controller,
        }
    )


def timing_of(scenario: Scenario) -> tuple[Timing, int]:
    """Return the plant's timing and the whole samples of the delay.

    A delay of part of a sample changes the command inside a sample. Where the number of plant steps is left open, it
    is chosen such that the change falls between two of them, if up to MAX_ALIGNING times as many allow.
    """
    h = 1.0 / scenario.controller.rate_hz
    # longer than the flight is as good as the flight's length, and keeps the line in memory small
    samples = min(scenario.controller.delay_s * scenario.controller.rate_hz, scenario.steps + 1.0)
    whole = math.floor(samples + 1e-9)
    part = samples - whole
    part = part if part > 1e-9 else 0.0
    substeps = scenario.substeps
    if part and scenario.simulation.substeps is None:
        aligned = (n for n in range(substeps, MAX_ALIGNING * substeps + 1) if abs(n * part - round(n * part)) < 1e-6)
        substeps = next(aligned, MAX_ALIGNING * substeps)
    return Timing(h, substeps, part), whole


def make_plant(
    scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None, timing: Timing
) -> tuple[Plant, Inputs]:
    """Return the plant at its trim, and the inputs that count from it."""
    plant: Plant
    if scenario.plant == "analytic":
        plant = make_analytic(aircraft, model, timing)
        return plant, Inputs(scenario, plant.x1_trim)
    from uavftc.plants.jsbsim.plant import JSBSimPlant  # noqa: PLC0415 - each plant is imported only when flown

    assert model is not None  # every JSBSim aircraft is flown from a trimmed model
    air = Inputs(scenario, np.zeros(3))
    plant = JSBSimPlant(
        aircraft, model, timing, wind_n=air.wind_at_start(), has_wind=air.has_wind, has_moment=air.has_moment
    )
    return plant, Inputs(scenario, plant.x1_trim)


def make_analytic(aircraft: Aircraft, model: TrimmedModel | None, timing: Timing) -> Plant:
    """Return the rotational model: the companion file's, or the one measured on JSBSim at the trim."""
    from uavftc.plants.analytic import AnalyticPlant  # noqa: PLC0415

    inertia, A_l, B_m = rotational_model(aircraft, model)
    if model is None:
        stops = np.array([s.stop_rad or np.inf for s in aircraft.surface_list()])
        return AnalyticPlant(inertia, A_l, B_m, timing, u_limits=np.column_stack([-stops, stops]))
    return AnalyticPlant(
        inertia,
        A_l,
        B_m,
        timing,
        x1_trim=np.array([model.trim["phi"], model.trim["theta"], 0.0]),
        u_limits=np.array(model.limits_rad),
    )


def rotational_model(aircraft: Aircraft, model: TrimmedModel | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return J, kg m^2, A_l, 1/s, and B_m, 1/s^2, of the analytic plant, shape (3, 3) each."""
    if model is None:
        assert aircraft.analytic is not None  # or there would be a trimmed model
        assert aircraft.mass_properties is not None
        inertia = np.array(aircraft.mass_properties.inertia_kgm2)
        return inertia, np.array(aircraft.analytic.A_l), np.array(aircraft.analytic.B_m)
    inertia = np.array(model.inertia_kgm2)
    inertia[[0, 1, 1, 2], [1, 0, 2, 1]] = 0.0  # eq. (2) knows no other product of inertia than J_xz
    return inertia, model.A_rates, model.B_rates


def _rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(map(float, row)) for row in matrix)


def controller_blocks(
    scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None, plant: Plant, h: float
) -> list[Block] | list[Block | PythonBlock]:
    """Return the controller as blocks, for a sample time h, s: outer and inner loop, or a module of one's own."""
    controller, psi_0 = scenario.controller, float(plant.x1_trim[2])
    if isinstance(controller, OwnController):
        return own_blocks(controller.kind, control_design(scenario, aircraft, model, plant), h, controller.options)
    return [*outer_blocks(controller.outer, h, psi_0), *inner_blocks(controller.inner, h, psi_0)]


def control_design(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None, plant: Plant) -> ControlDesign:
    """Return what a controller may be designed from: the pair measured at the trim, or the aircraft's own."""
    if model is not None:
        A, B = model.A_rates, model.B_rates
    else:
        assert aircraft.analytic is not None  # or there would be a trimmed model
        A, B = np.array(aircraft.analytic.A_l), np.array(aircraft.analytic.B_m)
    commanded, stops = scenario.limits_rad(), plant.u_limits
    limits = np.column_stack([np.maximum(commanded[:, 0], stops[:, 0]), np.minimum(commanded[:, 1], stops[:, 1])])
    return ControlDesign(A, B, limits, np.array(plant.x1_trim), aircraft.name)


def outer_blocks(outer: NdiOuter | NndoNdiOuter, h: float, psi_0: float) -> list[Block]:
    """Return the outer loop: the observer, where there is one, and the inversion."""
    from uavftc.control.outer import ndi, nndo  # noqa: PLC0415

    inversion = ndi.stage.block(params_of(ndi.PARAMS, D=outer.bandwidth))
    if isinstance(outer, NdiOuter):
        return [inversion]
    observer = nndo.stage.block(
        params_of(
            nndo.PARAMS,
            h=h,
            sigma=outer.sigma,
            gamma=outer.gamma,
            centres=outer.rbf.centres,
            width=outer.rbf.width,
            psi_0=psi_0,
        )
    )
    return [observer, inversion]


def inner_blocks(inner: L1Inner | MracInner, h: float, psi_0: float) -> list[Block]:
    """Return the inner loop; its gains are computed from the design matrices here."""
    from uavftc.control.inner import l1, mrac  # noqa: PLC0415

    A_m, B_m = np.array(inner.A_m), np.array(inner.B_m)
    A_s = A_m + np.array(inner.K_1)
    shared = {
        "h": h,
        "A_m": A_m,
        "B_m": B_m,
        "A_s": A_s,
        "P_B_m": lyapunov_P(A_s, np.array(inner.Q)) @ B_m,
        "Gamma": inner.adaptation_gain,
        "explicit": float(inner.integration == "explicit"),
        "omega_min": inner.effectiveness_bounds[0],
        "omega_max": inner.effectiveness_bounds[1],
        "W_max": inner.weight_bound,
        "eps_max": inner.offset_bound,
        "centres": inner.rbf.centres,
        "width": inner.rbf.width,
        "psi_0": psi_0,
        "K": reference_gain(A_m if inner.reference_gain == "plant" else A_s, B_m),
        "K_0": inner.K_0,
    }
    if isinstance(inner, L1Inner):
        return [l1.stage.block(params_of(l1.PARAMS, **shared, filter_bandwidth=inner.filter_bandwidth))]
    return [mrac.stage.block(params_of(mrac.PARAMS, **shared))]


def actuator_blocks(scenario: Scenario, plant: Plant, timing: Timing, whole: int) -> list[Block]:
    """Return the chain on the surfaces: delay, saturation, effectiveness and bias, mechanical stops."""
    line = delay.stage.block(params_of(delay.PARAMS, whole=whole, partial=timing.switch), delay.memory(whole))
    limits, stops = scenario.limits_rad(), plant.u_limits
    return [
        line,
        saturation.stage.block(params_of(saturation.PARAMS, u_min=limits[:, 0], u_max=limits[:, 1])),
        effectiveness.stage.block(),
        saturation.stage.block(params_of(saturation.PARAMS, u_min=stops[:, 0], u_max=stops[:, 1])),
    ]
