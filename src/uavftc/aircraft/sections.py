"""Sections of a companion file next to its effectors: condition, mass, ranges and limits, the rotational model."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from uavftc.aircraft.effectors import Property
from uavftc.config.values import Matrix3, Model, Number, Positive, list_of


class InitialCondition(Model):
    """The aircraft's default condition for straight level flight."""

    airspeed_mps: Positive
    """true airspeed at t = 0"""
    altitude_m: Positive
    """altitude above mean sea level at t = 0"""


class MassProperties(Model):
    """What JSBSim must hold after loading, to 1e-6."""

    mass_kg: Positive
    """mass as loaded, fuel included"""
    inertia_kgm2: Matrix3
    """inertia matrix about the centre of gravity, three rows of three, products with the sign of the matrix"""
    wing_area_m2: Positive
    """reference area"""
    span_m: Positive
    """reference span"""
    chord_m: Positive
    """reference chord"""


class Autothrottle(Model):
    """The aircraft's own airspeed hold: its switch (0 or 1) and its set point, ft/s true."""

    switch: Property
    """JSBSim property, 1 switches it on"""
    setpoint_fps: Property
    """JSBSim property of its set point, ft/s true airspeed"""


def _range(value: tuple[float, float]) -> tuple[float, float]:
    if not value[0] < value[1]:
        raise PydanticCustomError("shape", "{expected}", {"expected": RANGE})
    return value


RANGE = "[least, greatest], the first below the second"
Range = Annotated[tuple[Number, Number], list_of(2, RANGE), AfterValidator(_range)]


class Trusted(Model):
    """The ranges within which the aircraft's own documentation trusts the model; a flight that leaves them says so."""

    alpha_deg: Range | None = None
    """angle of attack, [least, greatest]"""
    beta_deg: Range | None = None
    """sideslip, [least, greatest]"""
    airspeed_mps: Range | None = None
    """true airspeed, [least, greatest]"""


class FlightLimits(Model):
    """The envelope that the aircraft is made for; the default requirements ask a flight to stay within it."""

    alpha_deg: Range | None = None
    """angle of attack, [least, greatest]"""
    bank_deg: Annotated[Positive, Field(le=180)] | None = None
    """largest bank to either side, up to 180"""
    load_factor: Range | None = None
    """load factor, 1 in level flight, [least, greatest]"""


class AnalyticModel(Model):
    """The rotational model x2' = gyroscopic + A_l x2 + B_m u2: A_l in 1/s, B_m in 1/s^2."""

    A_l: Matrix3
    """linear part of the plant, 1/s"""
    B_m: Matrix3
    """angular acceleration per rad of aileron, elevator and rudder, 1/s^2"""


def _warnings(value: object) -> object:
    texts = tuple(value) if isinstance(value, list | tuple) else ()
    if value in ("strict", "allow") or (texts and all(isinstance(text, str) and text.strip() for text in texts)):
        return texts or value
    expected = "strict, allow, or a list of texts, one from each complaint that is allowed"
    raise PydanticCustomError("warnings", "{expected}", {"expected": expected})


_TEXTS = {"type": "array", "items": {"type": "string", "pattern": "\\S"}, "minItems": 1}
_SCHEMA = WithJsonSchema({"anyOf": [{"enum": ["strict", "allow"]}, _TEXTS]})
Warnings = Annotated[tuple[str, ...] | str, BeforeValidator(_warnings), _SCHEMA]
