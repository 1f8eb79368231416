"""The scenario: one immutable object that describes a flight completely. Each key carries its unit as a suffix."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from uavftc.actuators import CHAIN, ENGINES, effectiveness
from uavftc.actuators.saturation import limits_rad
from uavftc.config.document import Origin
from uavftc.config.effect import ENGINE, configs, default_kind, faults, section, tag_of
from uavftc.config.values import ZERO, Model, NonNegative, Positive, Signal, Whole, own_section, refusal
from uavftc.environment import KINDS
from uavftc.scenario.checks import MAX_SUBSTEPS, problems
from uavftc.scenario.controllers import AnyController, Controller
from uavftc.scenario.damage import Damage
from uavftc.scenario.requirements import Requirement
from uavftc.scenario.uncertainty import Uncertainty
from uavftc.sensors import CHAIN as SENSORS

MAX_PLANT_STEP_S = 5e-3  # s; the JSBSim integrators are made for 120-200 Hz


class Initial(Model):
    """Condition at t = 0; null is the aircraft's default."""

    airspeed_mps: Positive | None = None
    """true airspeed at t = 0, > 0; `null` is the aircraft's default, or else the lowest with ample authority
    for the reference"""
    altitude_m: Positive | None = None
    """altitude above mean sea level at t = 0, > 0; `null` is the aircraft's default, or else 1500"""


class Reference(Model):
    """Commanded change from the trim attitude, deg: numbers or expressions of t."""

    phi_deg: Signal = ZERO
    """signal: commanded change of bank from the trim attitude"""
    theta_deg: Signal = ZERO
    """signal: of pitch"""
    psi_deg: Signal = ZERO
    """signal: of heading"""


class Envelope(Model):
    """Outside it the vehicle is lost. Null airspeeds are half and twice the airspeed at t = 0."""

    bank_deg: Annotated[Positive, Field(le=180)] = 90.0
    """largest bank to either side, up to 180"""
    pitch_deg: Annotated[Positive, Field(le=90)] = 80.0
    """largest pitch up or down, up to 90"""
    min_airspeed_mps: NonNegative | None = None
    """`null` is half the airspeed at t = 0"""
    max_airspeed_mps: Positive | None = None
    """`null` is twice the airspeed at t = 0"""

    @field_validator("max_airspeed_mps")
    @classmethod
    def _ordered(cls, top: float | None, info: ValidationInfo) -> float | None:
        low = info.data.get("min_airspeed_mps")
        if top is not None and low is not None and top <= low:
            raise PydanticCustomError("airspeeds", "above min_airspeed_mps, {low} m/s", {"low": f"{low:g}"})
        return top


class Simulation(Model):
    """How the plant is stepped: `substeps` plant steps a controller step; null chooses steps of at most 5 ms."""

    substeps: Annotated[Whole, Field(ge=1, le=MAX_SUBSTEPS)] | None = None
    """plant steps in one controller step, 1 to 1000; `null` is the fewest with steps of at most 5 ms, or of what the
    step check of the aircraft allows where that is less. A flight takes at most 200 million of them, on JSBSim each of
    at least 5 us, and a delay at most 10 million"""


FAULTS = [kind for _, kind in faults((*CHAIN, *ENGINES))]
"""The kinds of entry in `faults`."""


def _kind(entry: Any) -> str:
    """Return the tag of a fault's entry: its kind, or that of the paper, eq. (6), and whether it is of an engine."""
    if not isinstance(entry, dict):
        return tag_of(type(entry)) if isinstance(entry, BaseModel) else default_kind(effectiveness.Config)
    if "engine" in entry:
        return f"{ENGINE}{entry.get('kind', '')}"
    return str(entry.get("kind", default_kind(effectiveness.Config)))


if TYPE_CHECKING:  # what is put together from the effects is known when it is imported
    Fault = Any
    Disturbance = Any
    Sensors = Any
    Actuators = Any
else:
    _faults = [Annotated[config, Tag(tag_of(config))] for config in FAULTS]
    Fault = Annotated[reduce(or_, _faults), Discriminator(_kind)] if len(FAULTS) > 1 else FAULTS[0]
    Disturbance = Annotated[reduce(or_, configs(KINDS, "ENTRY_OF", "disturbances")), Field(discriminator="kind")]
    Sensors = section("sensors", SENSORS, "What the controller sees: the errors of the sensors.", __name__)
    Actuator = section("actuators", CHAIN, "What a servo does by itself.", __name__, named="Actuator")

    class Actuators(Actuator):
        """What the servos do by themselves; under the name of an effector or gang the keys of its own."""

        model_config = ConfigDict(extra="allow")
        __pydantic_extra__: dict[str, Annotated[Actuator | None, BeforeValidator(own_section)]]

        def named(self) -> dict[str, Any]:
            """Return the keys given by name, each with the common ones where it says nothing; None does nothing."""
            return dict(self.__pydantic_extra__ or {})

        @model_validator(mode="after")
        def _common_in_each(self) -> Actuators:
            found = list(self.problems())
            common = {key: getattr(self, key) for key in Actuator.model_fields}
            for name, own in self.named().items():
                if own is not None:
                    left_out = common.keys() - own.model_fields_set
                    whole = own.model_copy(update={key: common[key] for key in left_out})
                    self.__pydantic_extra__[name] = whole
                    found += [p._replace(key=(name, *p.key)) for p in whole.problems()]
            if found:
                raise refusal(found)
            return self


def _chain_sections() -> dict[str, Any]:
    """Return the sections of the actuators' chain with their defaults, as `create_model` takes them."""
    found = {
        effect.SECTION: (effect.Config | None, Field(None, description=f"[{effect.SECTION}](#{effect.SECTION})"))
        for effect in CHAIN
        if hasattr(effect, "SECTION")
    }
    if configs(CHAIN, "KEYS_IN", "actuators"):
        found["actuators"] = (Actuators, Field(Actuators(), description="[servos](#actuators)"))
    return found


class _Head(Model):
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """letters, digits, `.`, `-`, `_`, at most 100, beginning with a letter or digit; names the result folder"""
    description: str = ""
    """free text"""
    duration_s: Positive
    """length of the flight; a whole number of controller steps, at most 20 million"""
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0
    """whole number from 0 to 2^63 - 1. Of everything random: each effect, entry and axis has
    numbers of its own, so that none changes those of another; where nothing is random, it changes nothing"""
    plant: Literal["jsbsim", "analytic"] = "jsbsim"
    """`jsbsim`: six degrees of freedom. `analytic`: the rotational model of the paper, eqs. (1)-(7)"""
    aircraft: Annotated[str, Field(min_length=1, max_length=4096)] = "hale"
    """a shipped aircraft, `jsbsim:NAME` for one that JSBSim ships (`uavftc aircraft` lists them), or the path of a
    folder ([new-aircraft.md](new-aircraft.md))"""
    initial: Initial = Initial()
    """[initial](#initial) condition"""
    reference: Reference = Reference()
    """[reference](#reference) attitude"""
    controller: AnyController = Controller()
    """[controller](#controller), its rate and delay"""


if TYPE_CHECKING:

    class _Chains(_Head):
        def __getattr__(self, name: str) -> Any:
            """A section of the actuators' chain."""
else:
    _Chains = create_model("_Chains", __base__=_Head, **_chain_sections())


class Scenario(_Chains):
    """A flight: what is flown, by which controller, against which limits, faults and disturbances.

    Raises
    ------
    pydantic.ValidationError
        If a value or a combination of values is wrong; `uavftc.scenario.load` turns it into an `InputError`.
    """

    faults: tuple[Fault, ...] = ()
    """[faults](#faults) of surfaces and engines"""
    damage: tuple[Damage, ...] = ()
    """[damage to the vehicle](#damage)"""
    uncertainty: Uncertainty = Uncertainty()
    """[how the vehicle that flies differs from the nominal one](#uncertainty)"""
    disturbances: tuple[Disturbance, ...] = ()
    """[disturbances](#disturbances)"""
    sensors: Sensors = Sensors()
    """[sensors](#sensors)"""
    envelope: Envelope = Envelope()
    """[where the vehicle is lost](#envelope)"""
    simulation: Simulation = Simulation()
    """[how the plant is stepped](#simulation)"""
    requirements: tuple[Requirement, ...] | None = None
    """[what the flight must hold to](#requirements); `null` is the default set, `[]` none"""

    _origin: Origin = PrivateAttr(default_factory=Origin)

    @property
    def origin(self) -> Origin:
        """Where its keys were written, for messages about them."""
        return self._origin

    @model_validator(mode="before")
    @classmethod
    def _null_sections(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        sections = cls.nullable()
        return {key: value for key, value in data.items() if not (key in sections and value is None)}

    @classmethod
    def nullable(cls) -> set[str]:
        """Return the sections that are as left out where they are null."""
        return {name for name, field in cls.model_fields.items() if isinstance(field.default, BaseModel | tuple)}

    @model_validator(mode="after")
    def _checked(self) -> Scenario:
        if found := problems(self):
            raise refusal(found)
        return self

    def changed(self, values: Mapping[str, Any] | None = None, **sections: Any) -> Scenario:
        """Return a scenario with other values at dotted keys, with the checks and messages of a file.

        Parameters
        ----------
        values
            By key, such as ``{"faults[0].effectiveness": 0.5}``.
        sections
            The same for keys without dots: ``duration_s=30``.

        Raises
        ------
        InputError
            If a key does not exist or a value is wrong.
        """
        from uavftc.scenario.load import load_scenario  # noqa: PLC0415 - which makes a scenario of what is read

        return load_scenario(self, set={**(values or {}), **sections})

    def __str__(self) -> str:
        """Return it as a file has it."""
        from uavftc.scenario.text import scenario_text  # noqa: PLC0415

        return scenario_text(self)

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"

    @property
    def steps(self) -> int:
        """Number of controller steps N; the history has N + 1 rows."""
        return round(self.duration_s * self.controller.rate_hz)

    def times(self) -> np.ndarray:
        """Return the sample times t_k = k / rate_hz, s, shape (N + 1,), start and end included."""
        return np.arange(self.steps + 1) / self.controller.rate_hz

    @property
    def substeps(self) -> int:
        """Plant steps a controller step, as given or such that one is at most 5 ms."""
        if self.simulation.substeps is not None:
            return self.simulation.substeps
        return max(1, math.ceil(1 / (self.controller.rate_hz * MAX_PLANT_STEP_S) - 1e-9))

    def limits_rad(self) -> np.ndarray:
        """Return the limits about trim, rad, shape (3, 2): [min, max] of aileron, elevator, rudder; inf is none."""
        return limits_rad(self.saturation)
