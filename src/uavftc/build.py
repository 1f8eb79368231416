"""From a scenario to a flight that is ready: aircraft, plant, controller, actuators, inputs.

Nothing reads YAML after this.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from uavftc import envelope
from uavftc.actuators import delay, effectiveness, saturation
from uavftc.aircraft import Aircraft, load_aircraft
from uavftc.control.gains import lyapunov_P, reference_gain
from uavftc.environment.inputs import Inputs
from uavftc.plants.interface import Plant, Timing
from uavftc.scenario.controllers import Controller, L1Inner, MracInner, NdiOuter, NndoNdiOuter
from uavftc.scenario.schema import Initial, Scenario
from uavftc.sensors import gyro
from uavftc.stage import Block, Program, params_of

MAX_ALIGNING = 8  # how many times finer the plant may step so that a delay falls on its steps


@dataclass(frozen=True)
class Flight:
    """Everything the loop needs; it can be flown once."""

    scenario: Scenario
    """As flown: what the scenario left to the aircraft is filled in."""
    aircraft: Aircraft
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
    aircraft = load_aircraft(scenario.aircraft)
    scenario = resolved(scenario, aircraft)
    timing, whole = timing_of(scenario)
    plant, inputs = make_plant(scenario, aircraft, timing)
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
        *controller_blocks(scenario.controller, timing.h, float(plant.x1_trim[2])),
        *actuator_blocks(scenario, aircraft, plant, timing, whole),
        envelope.stage.block(watch),
        *plant.after(),
    ]
    return Flight(scenario, aircraft, plant, Program(blocks), inputs, watch, scenario.steps)


def resolved(scenario: Scenario, aircraft: Aircraft) -> Scenario:
    """Return the scenario with everything filled in that it leaves to the aircraft."""
    airspeed = scenario.initial.airspeed_mps or aircraft.initial.airspeed_mps
    altitude = scenario.initial.altitude_m or aircraft.initial.altitude_m
    limits = scenario.envelope
    slow, fast = limits.min_airspeed_mps, limits.max_airspeed_mps
    inner = scenario.controller.inner
    if inner.B_m is None:
        inner = inner.model_copy(update={"B_m": aircraft.analytic.B_m})
    return scenario.model_copy(
        update={
            "initial": Initial(airspeed_mps=airspeed, altitude_m=altitude),
            "envelope": limits.model_copy(
                update={
                    "min_airspeed_mps": 0.5 * airspeed if slow is None else slow,
                    "max_airspeed_mps": 2.0 * airspeed if fast is None else fast,
                }
            ),
            "controller": scenario.controller.model_copy(update={"inner": inner}),
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


def make_plant(scenario: Scenario, aircraft: Aircraft, timing: Timing) -> tuple[Plant, Inputs]:
    """Return the plant, trimmed, and the inputs that count from its trim."""
    if scenario.plant == "analytic":
        from uavftc.plants.analytic import AnalyticPlant  # noqa: PLC0415 - each plant is imported only when flown

        model = aircraft.analytic
        inertia = np.array(aircraft.mass_properties.inertia_kgm2)
        analytic = AnalyticPlant(inertia, np.array(model.A_l), np.array(model.B_m), timing)
        return analytic, Inputs(scenario, analytic.x1_trim)
    from uavftc.plants.jsbsim.plant import JSBSimPlant  # noqa: PLC0415
    from uavftc.plants.jsbsim.probe import ensure_loads  # noqa: PLC0415

    ensure_loads(aircraft)
    air = Inputs(scenario, np.zeros(3))
    assert scenario.initial.airspeed_mps is not None  # resolved
    assert scenario.initial.altitude_m is not None
    jsbsim = JSBSimPlant(
        aircraft,
        timing,
        airspeed=scenario.initial.airspeed_mps,
        altitude=scenario.initial.altitude_m,
        wind_n=air.wind_at_start(),
        has_wind=air.has_wind,
        has_moment=air.has_moment,
    )
    return jsbsim, Inputs(scenario, jsbsim.x1_trim)


def controller_blocks(controller: Controller, h: float, psi_0: float) -> list[Block]:
    """Return the outer and the inner loop as blocks, for a sample time h, s, and an initial heading psi_0, rad."""
    return [*outer_blocks(controller.outer, h, psi_0), *inner_blocks(controller.inner, h, psi_0)]


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


def actuator_blocks(scenario: Scenario, aircraft: Aircraft, plant: Plant, timing: Timing, whole: int) -> list[Block]:
    """Return the chain on the surfaces: delay, saturation, effectiveness and bias, mechanical stops."""
    line = delay.stage.block(params_of(delay.PARAMS, whole=whole, partial=timing.switch), delay.memory(whole))
    limits = scenario.limits_rad()
    stops = aircraft.stops_rad()
    trim = plant.surface_trim
    return [
        line,
        saturation.stage.block(params_of(saturation.PARAMS, u_min=limits[:, 0], u_max=limits[:, 1])),
        effectiveness.stage.block(),
        saturation.stage.block(params_of(saturation.PARAMS, u_min=-stops - trim, u_max=stops - trim)),
    ]
