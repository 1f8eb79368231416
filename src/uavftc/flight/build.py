"""From a scenario to a flight that is ready: aircraft, plant, inputs, and the program of everything that acts.

Nothing reads YAML after this.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from uavftc import actuators, environment, sensors
from uavftc.actuators import lag
from uavftc.actuators.saturation import axis_limits, effector_limits
from uavftc.aircraft.definition import Aircraft, load_aircraft
from uavftc.analysis.derived import Known
from uavftc.analysis.requirements import Monitor, Requirement
from uavftc.config.effect import Effect, config_of
from uavftc.control import agent as agents
from uavftc.control import allocation, uncontrolled
from uavftc.control.agent import Agent
from uavftc.control.custom.controller import Custom, custom_controller
from uavftc.control.custom.measured import Aboard
from uavftc.core.axes import Controlled
from uavftc.core.flow import check_flow
from uavftc.core.given import ControlDesign, Given
from uavftc.core.layout import Layout, targets_of
from uavftc.core.program import Program
from uavftc.core.signals import Column, Shape
from uavftc.core.stage import Block, params_of
from uavftc.errors import InputError
from uavftc.flight import envelope, uncertain
from uavftc.flight.aboard import aboard_of
from uavftc.flight.condition import axes_of, check_start, model_of, refuse_uncontrolled
from uavftc.flight.damaged import refuse_damage
from uavftc.flight.defaults import resolved
from uavftc.flight.engine_faults import impossible, told_of_engines
from uavftc.flight.inputs import Inputs
from uavftc.flight.layouts import claimed_stops, layout_of
from uavftc.flight.named import refuse, refuse_impossible, refuse_unknown
from uavftc.flight.requirements import asked, default_set, signals_of
from uavftc.flight.rotational import rotational_model
from uavftc.flight.servos import acting, own_servos, published
from uavftc.flight.timing import timing_of
from uavftc.plants.interface import Plant, Timing
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.plants.jsbsim.span import span
from uavftc.plants.schedule import Struck, struck_by
from uavftc.scenario.controllers import CustomController, kinds
from uavftc.scenario.schema import Scenario
from uavftc.scenario.uncertainty import Uncertainty


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
    given: Given
    """What its blocks were built from."""
    steps: int
    """Controller steps N; the history has N + 1 rows."""
    layout: Layout
    """The effectors of the aircraft, and the signals of its controller."""
    controller: Custom
    """Its blocks, and what else it brings."""
    requirements: tuple[Requirement, ...]
    """What it is asked to hold to."""
    signals: Mapping[str, Known]
    """Every signal that a requirement may name."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of its history."""
        return self.layout.columns

    @property
    def shape(self) -> Shape:
        """What its rows have behind their head."""
        return self.layout.shape

    def monitor(self) -> Monitor:
        """Return the recorder that judges its requirements."""
        return Monitor(self.requirements, self.signals, self.scenario.controller.rate_hz)

    def remarks(self) -> list[str]:
        """Return what its controller is worth a warning for, once it is flown."""
        return self.controller.remarks()


def build_flight(scenario: Scenario, aircraft: Aircraft | None = None, agent: Agent | None = None) -> Flight:
    """Return a flight ready to be flown.

    Parameters
    ----------
    scenario
        The flight.
    aircraft
        Its aircraft, where it is loaded already and its files have not changed.
    agent
        Who commands in place of the inner loop, or assists the controller; None is nobody.

    Raises
    ------
    InputError
        If the aircraft does not exist, does not load, or cannot be trimmed, or has a reference about an axis that it
        does not control.
    """
    if aircraft is None:
        aircraft = load_aircraft(scenario.aircraft, f"key aircraft: {scenario.aircraft}")
    model = model_of(scenario, aircraft)
    axes = axes_of(aircraft, model)
    refuse_uncontrolled(scenario, aircraft, axes)
    scenario = resolved(scenario, aircraft, model)
    if scenario.requirements is None:
        scenario = scenario.model_copy(update={"requirements": default_set(scenario, aircraft, model, axes)})
    check_start(scenario)
    finer = model is not None and scenario.plant == "jsbsim"
    timing = timing_of(acting(scenario, model), model.frame_s if model is not None and finer else math.inf)
    layout = layout_of(scenario, aircraft, model)
    refuse_unknown(scenario, layout)
    refuse_damage(scenario, uncertain.vehicle_of(scenario, aircraft, model))
    inputs = Inputs(scenario, trim_attitude(model), layout)
    if model is not None and finer:
        refuse(scenario, impossible(scenario, aircraft, model))
    plant = make_plant(scenario, aircraft, model, timing, inputs, layout)
    given = given_of(scenario, aircraft, model, plant, timing, axes, layout)
    refuse_impossible(scenario, given)
    watch = params_of(
        envelope.PARAMS,
        bank_max=math.radians(scenario.envelope.bank_deg),
        pitch_max=math.radians(scenario.envelope.pitch_deg),
        airspeed_min=scenario.envelope.min_airspeed_mps,
        airspeed_max=scenario.envelope.max_airspeed_mps,
    )
    layout = layout._replace(servos=published(scenario.actuators, given))
    controller = controller_of(scenario, given, aboard_of(scenario, given, model, layout), agent)
    layout = layout._replace(signals=controller.signals)
    signals = signals_of(scenario, layout, given)
    requirements = asked(scenario, layout, signals)
    sample = [
        *plant.before(),
        *chain_blocks([kind for kind in environment.KINDS if hasattr(kind, "blocks")], scenario, given),
        *chain_blocks(sensors.CHAIN, scenario, given),
        *controller.blocks,
        *uncontrolled.blocks(given),
        envelope.stage.block(watch),
        *plant.given(),
    ]
    allocate, gather = allocation.blocks(given)
    plant_step = [
        allocate,
        *chain_blocks(actuators.CHAIN, scenario, given),
        gather,
        *controller.plant_step,
        *plant.after(),
    ]
    check_flow([*sample, *plant_step])
    program = Program(sample, plant_step, substeps=plant.program_substeps)
    return Flight(
        scenario, aircraft, model, plant, program, inputs, watch, given, scenario.steps, layout, controller,
        requirements, signals,
    )  # fmt: skip


def chain_blocks(chain: Sequence[Effect], scenario: Scenario, given: Given) -> list[Block]:
    """Return the blocks of a chain of effects, in its order."""
    return [block for effect in chain for block in effect.blocks(config_of(effect, scenario), given)]


def controller_of(scenario: Scenario, given: Given, aboard: Aboard, agent: Agent | None = None) -> Custom:
    """Return the controller: outer and inner loop, or a custom module; with an agent where there is one.

    Raises
    ------
    InputError
        If an agent is to replace the inner loop of a controller that has none.
    """
    if agent is not None:
        assisted = _without_agent(scenario, given, aboard, replaced=agent.mode == agents.REPLACE)
        return assisted._replace(blocks=[*assisted.blocks, *agents.blocks(agent, given)])
    return _without_agent(scenario, given, aboard)


def _without_agent(scenario: Scenario, given: Given, aboard: Aboard, *, replaced: bool = False) -> Custom:
    """Return the controller, without its inner loop where that is `replaced`."""
    controller = scenario.controller
    if isinstance(controller, CustomController):
        if replaced:
            found, remedy = f"the controller {controller.kind}, which has none", "assist it, or name nndondi-l1"
            raise InputError("the agent", found=found, expected="an inner loop to replace", remedy=remedy)
        return custom_controller(
            controller.kind, given, controller.options, aboard=aboard, timeout_s=controller.timeout_s
        )
    loops = [
        (kinds(part)[loop.kind], loop) for part, loop in (("outer", controller.outer), ("inner", controller.inner))
    ]
    loops = loops[:1] if replaced else loops
    return Custom([block for law, loop in loops for block in law.blocks(loop, given)], [])


def given_of(
    scenario: Scenario,
    aircraft: Aircraft,
    model: TrimmedModel | None,
    plant: Plant,
    timing: Timing,
    axes: Controlled,
    layout: Layout,
) -> Given:
    """Return the flight as its blocks see it."""
    given = Given(
        h=timing.h,
        plant_step=timing.plant_step,
        steps=scenario.steps,
        seed=scenario.seed,
        effectors=layout.names,
        stops_rad=plant.u_limits,
        mixing=layout.mixing,
        design=control_design(scenario, aircraft, model, plant, axes, layout),
        gangs=layout.gangs,
        trim_rad=layout.trim_rad,
        read=layout.read,
        sense=layout.sense,
        span_m=span(aircraft),
        servos=own_servos(scenario, model),
        at_end=plant.takes_end,
        faults=tuple(scenario.faults),
        damage=scenario.damage,
    )
    return given._replace(design=within_servos(given, scenario))


def within_servos(given: Given, scenario: Scenario) -> ControlDesign:
    """Return the design of a flight, its limits as far as the scenario's servos go, too."""
    limits, reach = given.design.limits_rad, axis_limits(lag.positions(scenario.actuators, given), given.mixing)
    narrower = np.column_stack([np.maximum(limits[:, 0], reach[:, 0]), np.minimum(limits[:, 1], reach[:, 1])])
    return given.design._replace(limits_rad=narrower)


def trim_attitude(model: TrimmedModel | None) -> np.ndarray:
    """Return the attitude from which references count, shape (3,), rad."""
    return np.zeros(3) if model is None else np.array([model.trim["phi"], model.trim["theta"], 0.0])


def make_plant(
    scenario: Scenario,
    aircraft: Aircraft,
    model: TrimmedModel | None,
    timing: Timing,
    inputs: Inputs,
    layout: Layout,
) -> Plant:
    """Return the plant at its trim."""
    damage, vehicle = (
        struck_by(scenario.damage, scenario.controller.rate_hz),
        uncertain.vehicle_of(scenario, aircraft, model),
    )
    flown = uncertain.document_of(scenario, vehicle)
    plant: Plant
    if scenario.plant == "analytic":
        plant = make_analytic(aircraft, model, timing, damage, scenario.uncertainty)
        plant.settings |= {} if flown is None else {"uncertainty": flown}
        return plant
    from uavftc.plants.jsbsim import damage as damaged  # noqa: PLC0415
    from uavftc.plants.jsbsim import uncertainty  # noqa: PLC0415
    from uavftc.plants.jsbsim.plant import JSBSimPlant  # noqa: PLC0415 - each plant is imported only when flown

    assert model is not None  # every JSBSim aircraft is flown from a trimmed model
    wind, moment = inputs.acts_on("wind_n"), inputs.acts_on("d2")
    told = [
        uncertainty.told(aircraft, scenario.uncertainty, vehicle.factors),
        damaged.told(aircraft, damage, vehicle.inertia),
        *told_of_engines(scenario, model),
    ]
    at_start = inputs.wind_at_start(model.trim["altitude"])  # the ground is at sea level
    plant = JSBSimPlant(
        aircraft,
        model,
        timing,
        wind_n=at_start,
        has_wind=wind,
        has_moment=moment,
        told=told,
        engines=len(layout.engines),
        inertia=vehicle.inertia,
    )
    plant.settings |= {} if flown is None else {"uncertainty": flown}
    return plant


def make_analytic(
    aircraft: Aircraft,
    model: TrimmedModel | None,
    timing: Timing,
    damage: Sequence[Struck] = (),
    uncertainty: Uncertainty | None = None,
) -> Plant:
    """Return the rotational model: the companion file's, or the one measured on JSBSim at the trim."""
    from uavftc.plants.analytic import AnalyticPlant, of_another_inertia  # noqa: PLC0415

    inertia, A_l, B_m = rotational_model(aircraft, model)
    if uncertainty is not None and uncertainty.changes_inertia:
        inertia, A_l, B_m = of_another_inertia(inertia, A_l, B_m, uncertainty.inertia(inertia))
    if model is None:
        return AnalyticPlant(inertia, A_l, B_m, timing, u_limits=claimed_stops(aircraft), damage=damage)
    return AnalyticPlant(
        inertia,
        A_l,
        B_m,
        timing,
        x1_trim=trim_attitude(model),
        u_limits=np.array([e.limits_rad for e in model.effectors]),
        damage=damage,
    )


def control_design(
    scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None, plant: Plant, axes: Controlled, layout: Layout
) -> ControlDesign:
    """Return what a controller may be designed from: the pair measured at the trim, or the aircraft's."""
    if model is not None:
        A, B = np.array(model.A_at_once), np.array(model.B_rates)
    else:
        assert aircraft.analytic is not None  # or there would be a trimmed model
        A, B = np.array(aircraft.analytic.A_l), np.array(aircraft.analytic.B_m)
    targets, stops = targets_of(layout.names, layout.gangs), plant.u_limits
    commanded = effector_limits(scenario.saturation, layout.mixing, targets)
    each = np.column_stack([np.maximum(commanded[:, 0], stops[:, 0]), np.minimum(commanded[:, 1], stops[:, 1])])
    limits = axis_limits(each, layout.mixing)
    for j in np.flatnonzero(np.logical_not(axes)):
        B[:, j], limits[j] = 0.0, 0.0
    sign = layout.shown_sign
    return ControlDesign(
        A,
        B,
        limits,
        np.array(plant.x1_trim),
        aircraft.name,
        axes,
        layout.names,
        sign * layout.trim_rad,
        sign[:, None] * layout.mixing,
    )
