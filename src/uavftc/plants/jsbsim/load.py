"""Strict loading of a JSBSim aircraft.

JSBSim lets several typing errors pass: an unknown element leaves a mass or an inertia at zero, an unknown operator
leaves a line in the log. Here an `InputError` is raised for anything that JSBSim would pass over in the files
(`strict`), any message of level WARN or worse, and any difference from the mass properties of the companion file.
What JSBSim loads is a copy (`copy`): nothing that an aircraft says may write, open or listen.
"""

from __future__ import annotations

import functools
import os
import threading
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim import strict
from uavftc.plants.jsbsim.copy import Change, copy_of
from uavftc.plants.jsbsim.units import FT_M, SLUG_KG, SLUGFT2_KGM2

FLAT_PLANET = Path(__file__).with_name("flat_planet.xml")
"""Flat, not rotating, constant gravity: the paper's assumptions 2 and 3, for an aircraft that names no planet."""

_NOWHERE = Path(__file__) / "output"
"""Where JSBSim writes: nothing can be made below a file. A component may write simulation/write-state-file."""

_SHOWN = 4  # of JSBSim's complaints; the first ones name the cause
_WARN, _FATAL = int(jsbsim.LogLevel.WARN), int(jsbsim.LogLevel.FATAL)


class _Log(jsbsim.FGLogger):
    """Keeps what JSBSim says instead of printing it."""

    def __init__(self) -> None:
        super().__init__()
        self.records: list[list[Any]] = []

    def set_level(self, level: Any) -> None:
        self.records.append([int(level), ""])
        del self.records[:-200]  # a model that complains at every step must not fill the memory

    def file_location(self, filename: str, line: int) -> None:
        self.records[-1][1] += f"{filename}, line {line}: "

    def message(self, message: str) -> None:
        self.records[-1][1] += message

    def format(self, _format: Any) -> None:
        """Ignore colours."""

    def flush(self) -> None:
        """Keep the record as it is."""

    def complaints(self) -> list[str]:
        return [" ".join(text.split()) for level, text in self.records if _WARN <= level <= _FATAL]


_log: _Log | None = None


def _quiet_log() -> _Log:
    """Return the log, installed at the first call; JSBSim crashes when that happens off the main thread."""
    global _log  # noqa: PLW0603 - one logger a process is JSBSim's own rule
    if _log is None:
        if threading.current_thread() is not threading.main_thread():
            raise RuntimeError("JSBSim must be loaded for the first time on the main thread of the process")
        _log = _Log()
        jsbsim.set_logger(_log)
    _log.records.clear()
    return _log


def prepare_process() -> None:
    """Do what the first load of a process does once, on the main thread, for flights that are on others.

    Raises
    ------
    RuntimeError
        If this is another thread, and nothing was loaded before.
    """
    _quiet_log()


def load(aircraft: Aircraft, dt: float, additions: Sequence[Change] = ()) -> jsbsim.FGFDMExec:
    """Return a fresh FDM with the copy of the aircraft loaded at frame time dt, s; nothing is initialised yet.

    `additions` are put into the copy.

    Raises
    ------
    InputError
        If JSBSim cannot read the aircraft, or complains about it and its companion file does not allow that.
    """
    strict.refuse(aircraft)
    return _loaded(aircraft, dt, missing(aircraft), additions)


def missing(aircraft: Aircraft) -> tuple[str, ...]:
    """Return the properties that an aircraft reads and nothing defines, where its companion file, if any, allows all.

    They are declared, 0, in what is loaded. Usually another program, such as FlightGear, would provide them.

    Raises
    ------
    InputError
        If JSBSim cannot read the aircraft.
    """
    return () if aircraft.strict else _missing(aircraft, aircraft.sha256())


@functools.lru_cache(maxsize=64)
def _missing(aircraft: Aircraft, _checksum: str) -> tuple[str, ...]:
    names = strict.reads(aircraft)
    absent: list[str] = []
    while True:
        try:
            fdm = _loaded(aircraft, 0.01, absent)
            break
        except InputError as error:  # the switch of a channel must exist when it is loaded
            switch = next((n for n in names if n not in absent and f"property, {n} specified" in error.found), None)
            if switch is None:
                raise
            absent.append(switch)
    manager = fdm.get_property_manager()
    return (*absent, *(name for name in names if name not in absent and manager.get_node(name) is None))


def _loaded(
    aircraft: Aircraft, dt: float, declared: Sequence[str], additions: Sequence[Change] = ()
) -> jsbsim.FGFDMExec:
    folder = aircraft.folder.resolve()  # the way from it to the copy counts its parents
    copy = copy_of(aircraft, declared, additions).resolve()
    try:
        model = os.path.relpath(copy.with_suffix(""), folder)
    except ValueError:
        raise InputError(
            f"aircraft {aircraft.name}, {aircraft.xml}",
            found=f"on another drive than the cache, {copy.parent}",
            expected="both on one drive",
            remedy="set UAVFTC_CACHE_DIR to a folder on the drive of the aircraft",
        ) from None
    planet = FLAT_PLANET if aircraft.planet is None else aircraft.folder / aircraft.planet
    log = _quiet_log()

    def complaints() -> list[str]:
        return [text.replace(str(folder / f"{model}.xml"), str(aircraft.xml)) for text in log.complaints()]

    fdm = jsbsim.FGFDMExec(str(folder.parent))
    fdm.set_debug_level(0)
    fdm.set_output_path(str(_NOWHERE))
    fdm.set_aircraft_path(str(folder))
    fdm.set_engine_path(str(aircraft.engine_dir))
    fdm.set_systems_path(str(aircraft.systems_dir))
    fdm.set_dt(dt)  # before load_model: the FCS components keep the frame time they are loaded with
    try:
        loaded = fdm.load_model(model, False)  # all that it includes is found in the aircraft's own folder
        refused = [text for text in complaints() if not aircraft.allows(text)]
        if loaded:
            loaded = fdm.load_planet(str(planet), False)
    except (RuntimeError, OSError) as error:  # jsbsim.BaseError is a RuntimeError
        raise _unreadable(aircraft, [*complaints(), str(error)]) from None
    if not loaded or refused:
        raise _unreadable(aircraft, complaints())
    return fdm


def initialised(aircraft: Aircraft, dt: float, additions: Sequence[Change] = ()) -> jsbsim.FGFDMExec:
    """Return a fresh FDM at frame time dt, s, loaded, initialised and checked against the companion file.

    `additions` are put into the copy that is loaded.

    Raises
    ------
    InputError
        If the aircraft does not load or does not hold what the companion file says.
    """
    fdm = load(aircraft, dt, additions)
    try:
        fdm.run_ic()
        check_initialised(aircraft, fdm)
    except (jsbsim.BaseError, KeyError) as error:
        raise InputError(
            f"aircraft {aircraft.name}, {aircraft.xml}",
            found=f"JSBSim cannot initialise it: {' '.join(str(error).split())}",
            expected="an aircraft whose properties all exist",
            remedy="correct the property name in the XML, or declare it there"
            + (", or write warnings: allow into the companion file" if aircraft.strict else ""),
        ) from None
    return fdm


def _unreadable(aircraft: Aircraft, complaints: Iterable[str]) -> InputError:
    shown = list(dict.fromkeys(" ".join(c.split()) for c in complaints))[:_SHOWN] or ["no reason given"]
    return InputError(
        f"aircraft {aircraft.name}, {aircraft.xml}",
        found=f"JSBSim does not load it: {' | '.join(shown)}",
        expected="an aircraft that JSBSim loads without a warning",
        remedy="correct the XML at the place named",
    )


def check_initialised(aircraft: Aircraft, fdm: jsbsim.FGFDMExec) -> None:
    """Compare what JSBSim holds after `run_ic` with the companion file.

    Raises
    ------
    InputError
        If JSBSim complained since the load, a mass property differs by more than 1e-6, or a property that the
        companion file names does not exist.
    """
    for what, (found, claimed, unit) in mass_properties(aircraft, fdm).items():
        scale = np.max(np.abs(claimed))
        if not np.max(np.abs(np.subtract(found, claimed))) <= 1e-6 * scale:
            raise InputError(
                f"aircraft {aircraft.name}, {aircraft.xml}",
                found=f"{what}: JSBSim holds {_numbers(found)} {unit}",
                expected=f"{_numbers(claimed)} {unit}, as {aircraft.companion.name} says",
                remedy="correct the XML (JSBSim ignores an element whose name it does not know) or the "
                "companion file; give inertias in SLUG*FT2, JSBSim's own KG*M2 factor is 9e-5 off",
            )
    complaints = [] if _log is None else _log.complaints()
    if not all(map(aircraft.allows, complaints)):
        raise _unreadable(aircraft, complaints)
    manager = fdm.get_property_manager()
    for key, name in aircraft.properties():
        if manager.get_node(name) is None:
            raise InputError(
                f"aircraft {aircraft.name}, {aircraft.companion}, key {key}",
                found=name,
                expected="a property that the loaded aircraft has",
                remedy="correct the name, or define the property in the aircraft's XML",
            )


def inertia(fdm: jsbsim.FGFDMExec) -> np.ndarray:
    """Return the inertia matrix, shape (3, 3), kg m^2, matrix signs; after `run_ic`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)  # the binding returns a numpy.matrix
        return np.array(fdm.get_mass_balance().get_J()) * SLUGFT2_KGM2


def mass_properties(aircraft: Aircraft, fdm: jsbsim.FGFDMExec) -> dict[str, tuple[Any, Any, str]]:
    """Return (loaded, claimed, unit) of mass, inertia, wing area, span and chord, in SI; empty without claims."""
    claimed = aircraft.mass_properties
    if claimed is None:
        return {}
    return {
        "mass": (fdm["inertia/mass-slugs"] * SLUG_KG, claimed.mass_kg, "kg"),
        "inertia": (inertia(fdm), np.array(claimed.inertia_kgm2), "kg m^2"),
        "wing area": (fdm["metrics/Sw-sqft"] * FT_M**2, claimed.wing_area_m2, "m^2"),
        "span": (fdm["metrics/bw-ft"] * FT_M, claimed.span_m, "m"),
        "chord": (fdm["metrics/cbarw-ft"] * FT_M, claimed.chord_m, "m"),
    }


def _numbers(value: Any) -> str:
    if np.ndim(value) == 0:
        return f"{float(value):.9g}"
    return np.array2string(np.asarray(value), precision=9, separator=", ").replace("\n", "")
