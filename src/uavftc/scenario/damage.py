"""Damage: what a structure loses for a time, or gains: mass, inertia, forces and moments, control power.

An entry changes the vehicle on [start_s, end_s). Places and vectors are in body axes, [forward, right, down], from the
centre of gravity of the undamaged vehicle. Each entry says what it would change alone; of several at a time the pieces
add up: their masses, and their first and second moments of mass.
"""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, Strict, WithJsonSchema, model_validator
from pydantic_core import PydanticCustomError

from uavftc.config.values import Model, Number, Problem, SurfaceName, Window, list_of, refusal

Vector = Annotated[tuple[Number, Number, Number], list_of(3, "a list of three: [forward, right, down]")]
_NOTHING = (0.0, 0.0, 0.0)

COEFFICIENT = re.compile(r"C([DYLlmn])_(0|alpha|beta|p|q|r)")


class Inertia(Model):
    """A change of the inertia matrix about the centre of gravity; products are integrals: the matrix holds -ixz."""

    ixx_kgm2: Number = 0.0
    """of the moment about the x axis, forward"""
    iyy_kgm2: Number = 0.0
    """about the y axis, right"""
    izz_kgm2: Number = 0.0
    """about the z axis, down"""
    ixy_kgm2: Number = 0.0
    """of the integral of x y over the mass"""
    ixz_kgm2: Number = 0.0
    """of the integral of x z"""
    iyz_kgm2: Number = 0.0
    """of the integral of y z"""

    def matrix(self) -> np.ndarray:
        """Return it as a matrix, shape (3, 3), kg m^2, matrix signs."""
        return np.array(
            [
                [self.ixx_kgm2, -self.ixy_kgm2, -self.ixz_kgm2],
                [-self.ixy_kgm2, self.iyy_kgm2, -self.iyz_kgm2],
                [-self.ixz_kgm2, -self.iyz_kgm2, self.izz_kgm2],
            ]
        )


class LiftLost(Model):
    """Lift that one side no longer makes: a share of half of the aircraft's lift, whatever it is at the moment."""

    side: Literal["left", "right"]
    """`left` or `right`"""
    fraction: Annotated[Number, Field(gt=0, le=1)]
    """of the lift of that side, above 0, up to 1"""
    span_position: Annotated[Number, Field(ge=0, le=1)] | None = None
    """where it acted, from 0 in the middle to 1 at the tip; `null` is the centre of the outer part that carries that
    share of an elliptic lift"""

    @property
    def position(self) -> float:
        """Where it acted, as a share of the half span."""
        return outer_part(self.fraction) if self.span_position is None else self.span_position


def outer_part(fraction: float) -> float:
    """Return the centre of the outer part of a half wing that carries this share of its elliptic lift, 0..1.

    With eta = sin(x) the part outside eta carries f = 1 - (2 x + sin 2x)/pi, and its centre is
    4 cos^3(x)/(3 pi f).
    """
    low, high = 0.0, math.pi / 2
    for _ in range(60):
        x = 0.5 * (low + high)
        low, high = (low, x) if 1.0 - (2.0 * x + math.sin(2.0 * x)) / math.pi < fraction else (x, high)
    x = 0.5 * (low + high)
    return min(1.0, 4.0 * math.cos(x) ** 3 / (3.0 * math.pi * fraction))


def _coefficient(name: str) -> str:
    if COEFFICIENT.fullmatch(name) is None:
        expected = "C, one of D Y L l m n, _, and one of 0 alpha beta p q r: CY_beta, Cn_beta, Cl_0"
        raise PydanticCustomError("name", "{expected}", {"expected": expected})
    return name


_NAMES = {"type": "string", "pattern": f"^{COEFFICIENT.pattern}$"}
Coefficient = Annotated[str, Strict(), AfterValidator(_coefficient), WithJsonSchema(_NAMES)]
Share = Annotated[Number, Field(ge=0, le=1)]


class Damage(Window):
    """A change of the vehicle on [start_s, end_s)."""

    name: Annotated[str, Field(max_length=60)] = ""
    """what figures and messages call it; free text, at most 60 characters"""
    mass_kg: Number = 0.0
    """change of the mass; negative is lost"""
    cg_m: Vector = _NOTHING
    """shift of the centre of gravity that it makes alone, [forward, right, down]"""
    inertia_kgm2: Inertia = Inertia()
    """[change of the inertia](#damage) about the centre of gravity, wherever that is then"""
    lift_lost: LiftLost | None = None
    """[lift lost](#damage) on one side"""
    drag_area_m2: Number = 0.0
    """further drag over dynamic pressure (CD S), against the airspeed; negative is drag lost"""
    drag_at_m: Vector = _NOTHING
    """where that acts"""
    force_n: Vector = _NOTHING
    """constant force in body axes"""
    force_area_m2: Vector = _NOTHING
    """force in body axes over dynamic pressure"""
    force_at_m: Vector = _NOTHING
    """where both act"""
    moment_nm: Vector = _NOTHING
    """constant moment about the body axes"""
    coefficients: dict[Coefficient, Number] = Field(default_factory=dict)
    """further aerodynamic coefficients, by name: `CY_beta: 0.2`; per rad, rates by b/2V (p, r) or c/2V (q)"""
    control_power: dict[SurfaceName, Share] = Field(default_factory=dict)
    """what is left of the effect of an effector, or of all of an axis, on its total deflection: 0, nothing, to 1"""

    @model_validator(mode="after")
    def _changes_something(self) -> Damage:
        if not (self.changes_mass or self.acts or self.control_power):
            found = "an entry that changes nothing"
            expected = "a change of mass, inertia, force or moment, or control_power"
            raise refusal([Problem((), found, expected, "say what the damage changes, or leave the entry out")])
        return self

    @property
    def changes_mass(self) -> bool:
        """Whether it changes mass, centre of gravity or inertia."""
        return bool(self.mass_kg or any(self.cg_m) or self.inertia_kgm2.matrix().any())

    @property
    def acts(self) -> bool:
        """Whether it adds a force or a moment."""
        vectors = (*self.force_n, *self.force_area_m2, *self.moment_nm)
        return bool(self.lift_lost or self.drag_area_m2 or any(vectors) or any(self.coefficients.values()))

    @property
    def label(self) -> str:
        """What figures and messages call it."""
        return self.name or ", ".join(self._said())

    def _said(self) -> list[str]:
        """Return what it changes, in short."""
        said = [f"{self.mass_kg:+g} kg"] if self.mass_kg else []
        said += ["CG"] if any(self.cg_m) else []
        said += ["inertia"] if self.inertia_kgm2.matrix().any() else []
        if self.lift_lost is not None:
            said.append(f"{100 * self.lift_lost.fraction:g} % of the {self.lift_lost.side} lift")
        said += ["drag"] if self.drag_area_m2 else []
        said += ["force"] if any((*self.force_n, *self.force_area_m2)) else []
        said += ["moment"] if any(self.moment_nm) else []
        said += ["aerodynamics"] if any(self.coefficients.values()) else []
        return said + [f"{name} {100 * left:g} %" for name, left in self.control_power.items()]

    def part(self, share: float) -> Damage | None:
        """Return a part of it, 0..1: each change times the share, each control power that much nearer; None of 0."""
        if share <= 0.0:
            return None
        inertia = {name: share * value for name, value in self.inertia_kgm2}
        lost = self.lift_lost
        return self.model_copy(
            update={
                **{key: share * getattr(self, key) for key in ("mass_kg", "drag_area_m2")},
                **{
                    key: tuple(share * x for x in getattr(self, key))
                    for key in ("cg_m", "force_n", "force_area_m2", "moment_nm")
                },
                "inertia_kgm2": self.inertia_kgm2.model_copy(update=inertia),
                "lift_lost": lost and lost.model_copy(update={"fraction": share * lost.fraction}),
                "coefficients": {name: share * value for name, value in self.coefficients.items()},
                "control_power": {name: 1.0 - share * (1.0 - left) for name, left in self.control_power.items()},
            }
        )
