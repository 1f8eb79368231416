"""Uncertainty: how the vehicle that flies differs from the one that the controller is designed for.

Trim, linear model, limits, gains and laws are those of the nominal aircraft; the vehicle has another mass, centre of
gravity or inertia, or other aerodynamics, from the start of the flight to its end.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import BeforeValidator, Field, Strict

from uavftc.config.values import Model, Number, Positive, list_of, three, three_schema

MOST = 1000.0  # of a factor, and of a shift in m: no aircraft is so far from what it was taken for
Factor = Annotated[Positive, Field(le=MOST)]
Shift = Annotated[Number, Field(ge=-MOST, le=MOST)]
Shifts = Annotated[tuple[Shift, Shift, Shift], list_of(3, "a list of three: [forward, right, down]")]
_FACTOR = {"type": "number", "exclusiveMinimum": 0, "maximum": MOST}
Factors = Annotated[tuple[Factor, Factor, Factor], BeforeValidator(three), three_schema(_FACTOR)]
Name = Annotated[str, Strict(), Field(min_length=1, max_length=200)]


class Uncertainty(Model):
    """The vehicle that flies, as changes of the nominal aircraft; the controller knows nothing of it."""

    mass_factor: Factor = 1.0
    """mass over that of the nominal aircraft, above 0, up to 1000"""
    inertia_factor: Factors = (1.0, 1.0, 1.0)
    """moments of inertia about the centre of gravity over the nominal ones, about roll, pitch and yaw, above
    0, up to 1000; a product of
    inertia is multiplied by the root of the factors of its two axes"""
    cg_shift_m: Shifts = (0.0, 0.0, 0.0)
    """shift of the centre of gravity, [forward, right, down]"""
    coefficients: dict[Name, Number] = Field(default_factory=dict)
    """factors on aerodynamic functions of the aircraft's XML, by name or its last part: `Cl_p: 1.3`"""

    @property
    def changes_inertia(self) -> bool:
        """Whether the inertia is another."""
        return any(factor != 1.0 for factor in self.inertia_factor)

    @property
    def changes_mass(self) -> bool:
        """Whether mass, centre of gravity or inertia are others."""
        return self.mass_factor != 1.0 or any(self.cg_shift_m) or self.changes_inertia

    def inertia(self, J: np.ndarray) -> np.ndarray:
        """Return the inertia about the centre of gravity of a vehicle whose nominal one is J, shape (3, 3), kg m^2."""
        if not self.changes_inertia:
            return J
        root = np.sqrt(np.array(self.inertia_factor))
        return J * np.outer(root, root)
