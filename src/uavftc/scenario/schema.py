"""The scenario: one immutable object that says everything about a flight. Each key carries its unit as a suffix."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from uavftc.config.values import Model, NonNegative, Number, Positive, Signal, Vector3, Whole, refusal
from uavftc.core.signals import SURFACES
from uavftc.scenario.checks import problems
from uavftc.scenario.controllers import AnyController, Controller
from uavftc.scenario.disturbances import ZERO, Disturbance, Window

MAX_PLANT_STEP_S = 5e-3  # s; the JSBSim integrators are at home at 120-200 Hz
SECTIONS = ("initial", "reference", "controller", "faults", "disturbances", "sensors", "envelope", "simulation")
"""Sections that may be left out or null: both mean their defaults."""


class Initial(Model):
    """Condition at t = 0; null is the aircraft's own."""

    airspeed_mps: Positive | None = None
    altitude_m: Positive | None = None


class Reference(Model):
    """Commanded change from the trim attitude, deg: numbers or expressions of t."""

    phi_deg: Signal = ZERO
    theta_deg: Signal = ZERO
    psi_deg: Signal = ZERO


class Limits(Model):
    """Limits of a commanded deflection about trim, rad."""

    min_rad: Annotated[Number, Field(le=0)]
    max_rad: Number

    @field_validator("max_rad")
    @classmethod
    def _ordered(cls, max_rad: float, info: ValidationInfo) -> float:
        if max_rad < 0 or max_rad <= info.data.get("min_rad", -math.inf):
            raise PydanticCustomError("limits", "min <= 0 <= max and min < max")
        return max_rad


class SurfaceLimits(Model):
    """Limits of each surface; null is unlimited."""

    aileron: Limits | None = None
    elevator: Limits | None = None
    rudder: Limits | None = None


def _limits_or_surfaces(value: Any) -> str:
    per_surface = isinstance(value, SurfaceLimits) or (isinstance(value, dict) and any(s in value for s in SURFACES))
    return "SurfaceLimits" if per_surface else "Limits"


Saturation = Annotated[
    Annotated[Limits, Tag("Limits")] | Annotated[SurfaceLimits, Tag("SurfaceLimits")],
    Discriminator(_limits_or_surfaces),
]


class Fault(Window):
    """A surface at `effectiveness` times its limited command, plus `bias_deg`, on [start_s, end_s)."""

    surface: Literal["aileron", "elevator", "rudder"]
    effectiveness: Signal = Signal(1.0)
    bias_deg: Signal = ZERO


class Sensors(Model):
    """What the controller is shown: body rates plus a constant bias [p, q, r], deg/s."""

    gyro_bias_degps: Vector3 = (0.0, 0.0, 0.0)


class Envelope(Model):
    """Outside it the vehicle is lost. Null airspeeds are half and twice the airspeed at t = 0."""

    bank_deg: Annotated[Positive, Field(le=180)] = 90.0
    pitch_deg: Annotated[Positive, Field(le=90)] = 80.0
    min_airspeed_mps: NonNegative | None = None
    max_airspeed_mps: Positive | None = None

    @field_validator("max_airspeed_mps")
    @classmethod
    def _ordered(cls, top: float | None, info: ValidationInfo) -> float | None:
        low = info.data.get("min_airspeed_mps")
        if top is not None and low is not None and top <= low:
            raise PydanticCustomError("airspeeds", "above min_airspeed_mps, {low} m/s", {"low": f"{low:g}"})
        return top


class Simulation(Model):
    """How the plant is stepped: `substeps` plant steps a controller step; null chooses steps of at most 5 ms."""

    substeps: Annotated[Whole, Field(ge=1, le=1000)] | None = None


class Scenario(Model):
    """A flight: what is flown, by which controller, against which limits, faults and disturbances.

    Raises
    ------
    pydantic.ValidationError
        If a value or a combination of values is wrong; `uavftc.scenario.load` turns it into an `InputError`.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    description: str = ""
    duration_s: Positive
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)] = 0
    plant: Literal["jsbsim", "analytic"] = "jsbsim"
    aircraft: Annotated[str, Field(min_length=1, max_length=4096)] = "hale"
    initial: Initial = Initial()
    reference: Reference = Reference()
    controller: AnyController = Controller()
    saturation: Saturation | None = None
    faults: tuple[Fault, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()
    sensors: Sensors = Sensors()
    envelope: Envelope = Envelope()
    simulation: Simulation = Simulation()

    @model_validator(mode="before")
    @classmethod
    def _null_sections(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        return {key: value for key, value in data.items() if not (key in SECTIONS and value is None)}

    @model_validator(mode="after")
    def _checked(self) -> Scenario:
        if found := problems(self):
            raise refusal(found)
        return self

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
        table = np.array([[-np.inf, np.inf]] * 3)
        for i, surface in enumerate(SURFACES):
            s = self.saturation
            limits = getattr(s, surface) if isinstance(s, SurfaceLimits) else s
            if limits is not None:
                table[i] = limits.min_rad, limits.max_rad
        return table
