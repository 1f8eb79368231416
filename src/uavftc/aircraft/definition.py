"""Aircraft definitions: a JSBSim model, and what the project needs beyond the XML.

    NAME/NAME.xml       the JSBSim model; engine/ and systems/ next to it if it has any
    NAME/uavftc.yaml    the companion: initial condition, surfaces, mass properties to check, what range of flight to
                        trust, the analytic model

The companion is optional, and so is each of its keys: what it does not say is measured
(`plants/jsbsim/model.py`), with JSBSim's standard property names. JSBSim's own aircraft are `jsbsim:NAME`.
"""

from __future__ import annotations

import difflib
import functools
import hashlib
import importlib.util
import os
import re
from pathlib import Path
from typing import Annotated

from pydantic import Field, PrivateAttr, ValidationError, model_validator

from uavftc.aircraft.effectors import Effector, Surface, Surfaces, Throttle, Weight, problems
from uavftc.aircraft.sections import (
    AnalyticModel,
    Autothrottle,
    FlightLimits,
    InitialCondition,
    MassProperties,
    Trusted,
    Warnings,
)
from uavftc.config.document import Document
from uavftc.config.explain import explain
from uavftc.config.shipped import aircraft_dir, aircraft_names
from uavftc.config.values import Model, refusal
from uavftc.errors import InputError, join
from uavftc.scenario.load import read_document

COMPANION = "uavftc.yaml"
STOCK = "jsbsim:"


class Aircraft(Model):
    """An aircraft definition, read from its companion file."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """what messages and results call it"""
    description: str = ""
    """free text"""
    initial: InitialCondition | None = None
    """its condition at t = 0 where a scenario gives none"""
    mass_properties: MassProperties | None = None
    """what JSBSim must hold after loading, to 1e-6"""
    surfaces: Surfaces = Surfaces()
    """the short form of three surfaces, one an axis; else `effectors` and `gangs`"""
    effectors: dict[str, Effector] = Field(default_factory=dict)
    """surfaces and engines by name; left out, they are found by their response"""
    gangs: dict[str, dict[str, Weight]] = Field(default_factory=dict)
    """how aileron, elevator and rudder are shared among the surfaces: `aileron: {left: 1, right: -1}`"""
    throttle: Throttle | None = None
    """throttle commands that the trim sets"""
    autothrottle: Autothrottle | None = None
    """the aircraft's own airspeed hold"""
    disturbance_moment: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")] | None = None
    """moment of `external_reactions` by which disturbances act"""
    trusted: Trusted = Trusted()
    """the ranges within which the model is trusted"""
    limits: FlightLimits = FlightLimits()
    """the envelope that the aircraft is made for"""
    planet: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*\.xml$")] | None = None
    """file of a planet of its own, in its folder"""
    analytic: AnalyticModel | None = None
    """the rotational model of `plant: analytic`"""
    warnings: Warnings = "strict"
    """`strict`: complaints about its files are errors; `allow`: none is; or texts, one from each that is allowed"""

    @model_validator(mode="after")
    def _consistent(self) -> Aircraft:
        if found := problems(self.effectors, self.gangs, self.model_fields_set):
            raise refusal(found)
        return self

    _folder: Path = PrivateAttr(default=Path())
    _stock: bool = PrivateAttr(default=False)
    _checked: bool = PrivateAttr(default=True)

    def __hash__(self) -> int:  # its dictionaries have no hash
        return hash((self.name, self._folder))

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

    @property
    def reference(self) -> str:
        """What `load_aircraft` takes to read it again."""
        return f"{STOCK}{self.name}" if self._stock else str(self.folder)

    @property
    def strict(self) -> bool:
        """Whether a complaint about its files is an error: with a companion file, unless that allows all."""
        return self._checked and self.warnings != "allow"

    def allows(self, complaint: str) -> bool:
        """Return whether a complaint about its files is a warning only."""
        texts = self.warnings if isinstance(self.warnings, tuple) else ()
        return not self.strict or any(text in complaint for text in texts)

    @property
    def engine_dir(self) -> Path:
        """Where JSBSim looks for engines and propellers."""
        return self.folder.parents[1] / "engine" if self._stock else self.folder / "engine"

    @property
    def systems_dir(self) -> Path:
        """Where JSBSim looks for systems."""
        return self.folder.parents[1] / "systems" if self._stock else self.folder / "systems"

    def named_effectors(self) -> dict[str, Surface]:
        """Return the surfaces by name, in their order in a row; empty where they are to be found."""
        return dict(self._surfaces)

    @functools.cached_property
    def _surfaces(self) -> dict[str, Surface]:
        if self.effectors:
            return {name: e.surface() for name, e in self.effectors.items() if e.throttle is None}
        if self._stock or not self._checked:
            return {}
        return dict(zip(Surfaces.model_fields, self.surface_list(), strict=True))

    def engines(self) -> dict[str, str]:
        """Return the throttle command of each engine that the companion file names."""
        return {name: e.throttle for name, e in self.effectors.items() if e.throttle is not None}

    def surface_list(self) -> tuple[Surface, Surface, Surface]:
        """Return aileron, elevator and rudder."""
        return self.surfaces.aileron, self.surfaces.elevator, self.surfaces.rudder

    def throttle_commands(self, engines: int) -> tuple[str, ...]:
        """Return the throttle command properties, for an aircraft of so many engines."""
        if self.throttle is not None:
            return self.throttle.command
        if engines_named := self.engines():
            return tuple(engines_named.values())
        return tuple(f"fcs/throttle-cmd-norm[{i}]" for i in range(engines))

    def properties(self) -> list[tuple[str, str]]:
        """Return (key, property) of every JSBSim property that the aircraft is flown by."""
        named = []
        key = "effectors" if self.effectors else "surfaces"
        for name, surface in self.named_effectors().items():
            named.append((f"{key}.{name}.command", surface.command))
            if surface.position is not None:
                named.append((f"{key}.{name}.position", surface.position))
        named += [(f"effectors.{name}.throttle", throttle) for name, throttle in self.engines().items()]
        if self.throttle is not None:
            named += [("throttle.command", name) for name in self.throttle.command]
            named += [("throttle.position", name) for name in self.throttle.position or ()]
        if self.autothrottle is not None:
            named += [
                ("autothrottle.switch", self.autothrottle.switch),
                ("autothrottle.setpoint_fps", self.autothrottle.setpoint_fps),
            ]
        if self.disturbance_moment is not None:
            base = f"external_reactions/{self.disturbance_moment}"
            named += [("disturbance_moment", f"{base}/{part}") for part in ("l", "m", "n", "magnitude-lbsft")]
        return named

    def sha256(self) -> str:
        """Return the checksum of all files of the definition, names included."""
        return _checksum(self.folder, stamp(self.folder))


Stamp = tuple[tuple[str, int, int, int, int], ...]
"""Of each file of a folder its name and what changes with its content: inode, size, times of content and entry, ns."""


def stamp(folder: Path) -> Stamp:
    """Return what tells one state of the files of a definition from another without reading them."""
    found, waiting = [], [str(folder)]
    while waiting:
        try:
            entries = list(os.scandir(waiting.pop()))
        except OSError:
            continue
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                waiting.append(entry.path)
            elif entry.name.endswith((".xml", ".yaml")) and entry.is_file():
                state = os.stat(entry.path)
                found.append((entry.path, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns))
    return tuple(sorted(found))


@functools.lru_cache(maxsize=64)
def _checksum(folder: Path, _stamp: Stamp) -> str:
    digest = hashlib.sha256()
    for file in sorted(p for p in folder.rglob("*") if p.suffix in (".xml", ".yaml") and p.is_file()):
        digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()


def load_aircraft(aircraft: str, where: str = "aircraft") -> Aircraft:
    """Return the definition of a shipped aircraft by name, of a folder by path, or of one that JSBSim ships.

    Parameters
    ----------
    aircraft
        A name under aircraft/, the path of a folder, or jsbsim:NAME.
    where
        What the user set to this value, for the message.

    Raises
    ------
    InputError
        If there is no such aircraft, or its companion file is wrong.
    """
    if aircraft.startswith(STOCK):
        return _stock(aircraft.removeprefix(STOCK), where)
    folder = _folder(aircraft, where)
    xml = folder / f"{folder.name}.xml"
    if not xml.is_file():
        others = sorted(p.name for p in folder.glob("*.xml") if p.name != "flat_planet.xml")
        rename = f"rename {others[0]} to {xml.name}" if len(others) == 1 else f"add {xml.name}"
        raise InputError(
            where,
            found=f"{folder}, without {xml.name}",
            expected=f"a folder with the JSBSim model {xml.name}: folder and model must have one name",
            remedy=f"{rename}, or name another aircraft",
        )
    companion = folder / COMPANION
    if not companion.is_file():
        return _bare(folder.name, folder)
    return _companion(companion, folder, stamp(folder))


@functools.lru_cache(maxsize=64)
def _companion(companion: Path, folder: Path, _stamp: Stamp) -> Aircraft:
    return _validated(read_document(companion, what="companion file of an aircraft"), folder)


def _validated(document: Document, folder: Path) -> Aircraft:
    try:
        aircraft = Aircraft.model_validate(document.data)
    except ValidationError as error:
        raise join(explain(error, document, Aircraft)) from None
    aircraft._folder = folder
    return aircraft


def _bare(name: str, folder: Path, *, stock: bool = False) -> Aircraft:
    """Return the definition of an aircraft about which nothing is known but its XML."""
    aircraft = Aircraft(name=re.sub(r"[^A-Za-z0-9._-]", "-", name))
    aircraft._folder, aircraft._stock, aircraft._checked = folder, stock, False
    return aircraft


def stock_dir() -> Path:
    """Return the folder of the aircraft that JSBSim ships, without importing it."""
    spec = importlib.util.find_spec("jsbsim")
    places = spec.submodule_search_locations if spec is not None else None
    return Path(places[0] if places else "jsbsim") / "aircraft"


def stock_names() -> list[str]:
    """Return the names of the aircraft that JSBSim ships, sorted."""
    folder = stock_dir()
    return sorted(p.name for p in folder.iterdir() if (p / f"{p.name}.xml").is_file()) if folder.is_dir() else []


def _stock(name: str, where: str) -> Aircraft:
    names = stock_names()
    if name not in names:
        near = [f"{STOCK}{found}" for found in _near(name, names)]
        meant = " or ".join(filter(None, (", ".join(near[:-1]), *near[-1:])))
        raise InputError(
            where,
            found=f"'{STOCK}{name}', which JSBSim does not ship",
            expected=f"jsbsim: and one of {', '.join(names)}",
            remedy=(f"did you mean {meant}?" if near else "choose one of them")
            + " (uavftc aircraft says which of them the controller flies)",
        )
    return _bare(name, stock_dir() / name, stock=True)


def _near(name: str, names: list[str]) -> list[str]:
    """Return up to three names that may have been meant, the nearest first; those equally near in their order."""
    found = [known for known in names if difflib.get_close_matches(name.lower(), [known.lower()])]
    return sorted(found, key=lambda known: -difflib.SequenceMatcher(None, name.lower(), known.lower()).ratio())[:3]


def _folder(aircraft: str, where: str) -> Path:
    shipped = aircraft_dir() / aircraft
    if aircraft in aircraft_names():
        return shipped.resolve()
    folder = Path(aircraft).expanduser()
    if folder.is_dir():
        return folder.resolve()
    stock = f"; or {STOCK}{aircraft}" if aircraft in stock_names() else ""
    raise InputError(
        where,
        found=f"'{aircraft}', which is neither a shipped aircraft nor a folder",
        expected=f"a shipped aircraft ({', '.join(aircraft_names())}), the path of an aircraft folder, or jsbsim:NAME",
        remedy=f"check the spelling{stock}; a relative path counts from the scenario file, with --aircraft from here",
    )
