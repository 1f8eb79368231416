"""Aircraft definitions: a folder with a JSBSim model, and beside it what the project needs beyond the XML.

NAME/NAME.xml       the JSBSim model; engine/ and systems/ beside it if it has any
NAME/uavftc.yaml    the companion: initial condition, surfaces, mass properties to check, the analytic model
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field, PrivateAttr, ValidationError
from pydantic_core import PydanticCustomError

from uavftc.errors import InputError, join
from uavftc.resources import aircraft_dir, aircraft_names
from uavftc.scenario.document import Document
from uavftc.scenario.explain import explain
from uavftc.scenario.load import read_document
from uavftc.scenario.values import Matrix3, Model, Positive

COMPANION = "uavftc.yaml"

# JSBSim aborts the process when asked for a name that is no XML name, so no other ever reaches it.
_PROPERTY = r"[A-Za-z_][A-Za-z0-9_.-]*(\[[0-9]+\])?(/[A-Za-z_][A-Za-z0-9_.-]*(\[[0-9]+\])?)*"


def _property(name: str) -> str:
    if len(name) > 200 or not re.fullmatch(_PROPERTY, name):
        raise PydanticCustomError("property", "the path of a JSBSim property, such as fcs/aileron-cmd-norm or a/b[1]")
    return name


Property = Annotated[str, AfterValidator(_property)]


class InitialCondition(Model):
    """The aircraft's own condition for straight level flight."""

    airspeed_mps: Positive
    altitude_m: Positive


class MassProperties(Model):
    """What JSBSim must hold after loading, to 1e-6."""

    mass_kg: Positive
    inertia_kgm2: Matrix3
    wing_area_m2: Positive
    span_m: Positive
    chord_m: Positive


class Surface(Model):
    """A control surface: its command and position properties, rad, and its mechanical stop, rad."""

    command: Property
    position: Property
    stop_rad: Positive


class Surfaces(Model):
    """The three surfaces; positive deflection gives a positive moment about the surface's axis."""

    aileron: Surface
    elevator: Surface
    rudder: Surface


class Throttle(Model):
    """Commands that the trim sets, 0..1, and the positions that result."""

    command: Annotated[tuple[Property, ...], Field(min_length=1)]
    position: Annotated[tuple[Property, ...], Field(min_length=1)]


class Autothrottle(Model):
    """The aircraft's own airspeed hold: its switch (0 or 1) and its set point, ft/s true."""

    switch: Property
    setpoint_fps: Property


class AnalyticModel(Model):
    """The rotational model x2' = gyroscopic + A_l x2 + B_m u2: A_l in 1/s, B_m in 1/s^2."""

    A_l: Matrix3
    B_m: Matrix3


class Aircraft(Model):
    """An aircraft definition, read from its companion file."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    description: str = ""
    initial: InitialCondition
    mass_properties: MassProperties
    surfaces: Surfaces
    throttle: Throttle
    autothrottle: Autothrottle | None = None
    disturbance_moment: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")] | None = None
    planet: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*\.xml$")] | None = None
    analytic: AnalyticModel

    _folder: Path = PrivateAttr(default=Path())

    @property
    def folder(self) -> Path:
        """The folder it was read from."""
        return self._folder

    @property
    def companion(self) -> Path:
        """The companion file."""
        return self.folder / COMPANION

    @property
    def xml(self) -> Path:
        """The JSBSim model."""
        return self.folder / f"{self.folder.name}.xml"

    def properties(self) -> list[tuple[str, str]]:
        """Return (key, property) of every JSBSim property that the companion file names."""
        named = [
            (f"surfaces.{name}.{what}", getattr(getattr(self.surfaces, name), what))
            for name in Surfaces.model_fields
            for what in ("command", "position")
        ]
        named += [("throttle.command", name) for name in self.throttle.command]
        named += [("throttle.position", name) for name in self.throttle.position]
        if self.autothrottle is not None:
            named += [
                ("autothrottle.switch", self.autothrottle.switch),
                ("autothrottle.setpoint_fps", self.autothrottle.setpoint_fps),
            ]
        if self.disturbance_moment is not None:
            base = f"external_reactions/{self.disturbance_moment}"
            named += [("disturbance_moment", f"{base}/{part}") for part in ("l", "m", "n", "magnitude-lbsft")]
        return named

    def stops_rad(self) -> np.ndarray:
        """Return the mechanical stops of aileron, elevator and rudder, shape (3,), rad, either side of neutral."""
        return np.array([getattr(self.surfaces, name).stop_rad for name in Surfaces.model_fields])

    def sha256(self) -> str:
        """Return the checksum of all files of the definition, names included."""
        digest = hashlib.sha256()
        for file in sorted(p for p in self.folder.rglob("*") if p.suffix in (".xml", ".yaml") and p.is_file()):
            digest.update(file.relative_to(self.folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
        return digest.hexdigest()


def load_aircraft(aircraft: str, where: str = "aircraft") -> Aircraft:
    """Return the definition of a shipped aircraft by name, or of a folder by path.

    Parameters
    ----------
    aircraft
        A name under aircraft/, or the path of a folder.
    where
        What the user set to this value, for the error.

    Raises
    ------
    InputError
        If there is no such aircraft, or its companion file is wrong.
    """
    folder = _folder(aircraft, where)
    companion, xml = folder / COMPANION, folder / f"{folder.name}.xml"
    for file, what in ((companion, "the companion file"), (xml, "the JSBSim model")):
        if not file.is_file():
            raise InputError(
                where,
                found=f"{folder}, without {file.name}",
                expected=f"a folder with {what} {file.name}",
                remedy=f"add {file.name} (aircraft/hale has one of each), or name another aircraft",
            )
    document = read_document(companion, what="companion file of an aircraft")
    return _validated(document, folder)


def _validated(document: Document, folder: Path) -> Aircraft:
    try:
        aircraft = Aircraft.model_validate(document.data)
    except ValidationError as error:
        raise join(explain(error, document, Aircraft)) from None
    aircraft._folder = folder
    return aircraft


def _folder(aircraft: str, where: str) -> Path:
    shipped = aircraft_dir() / aircraft
    if aircraft in aircraft_names():
        return shipped.resolve()
    folder = Path(aircraft).expanduser()
    if folder.is_dir():
        return folder.resolve()
    if aircraft.startswith("jsbsim:"):
        raise InputError(
            where,
            found=f"'{aircraft}': flying JSBSim's own aircraft is not available yet",
            expected=f"a shipped aircraft ({', '.join(aircraft_names())}) or the path of an aircraft folder",
            remedy=f"copy the aircraft into a folder of its own and write a {COMPANION} beside its XML",
        )
    raise InputError(
        where,
        found=f"'{aircraft}', which is neither a shipped aircraft nor a folder",
        expected=f"a shipped aircraft ({', '.join(aircraft_names())}) or the path of an aircraft folder",
        remedy="check the spelling; a relative path counts from the scenario file, with --aircraft from here",
    )
