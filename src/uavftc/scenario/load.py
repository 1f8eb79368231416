"""From a file, or the name of a shipped scenario, to a checked `Scenario`."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import ValidationError

from uavftc.config import shipped as resources
from uavftc.config.document import Document, Origin, parse
from uavftc.config.explain import describe, explain
from uavftc.control.custom import in_memory
from uavftc.errors import InputError, join
from uavftc.scenario.checks import warnings
from uavftc.scenario.controllers import CustomController, spelling
from uavftc.scenario.overrides import apply, custom_name, put, resolve_controller, set_controller
from uavftc.scenario.schema import Scenario
from uavftc.scenario.text import scenario_text

__all__ = ["MAX_BYTES", "controller_name", "find_scenario", "load_scenario", "scenario_of", "scenario_text", "warnings"]

MAX_BYTES = 1_000_000


def load_scenario(
    source: str | os.PathLike[str] | Mapping[str, Any] | Scenario,
    *,
    overrides: Sequence[str] = (),
    plant: str | None = None,
    aircraft: str | os.PathLike[str] | None = None,
    controller: str | os.PathLike[str] | Callable[..., Any] | ModuleType | None = None,
    changes: Sequence[tuple[str, str]] = (),
    set: Mapping[str, Any] | None = None,
) -> Scenario:
    """Read, change and check a scenario.

    Parameters
    ----------
    source
        A YAML file, or the name of a shipped scenario, with or without `.yaml`; or its data as a dict; or a scenario.
    overrides
        ``dotted.key=value`` each, value in YAML; applied in order, after the other options.
    plant, aircraft
        Replace those of the file. A relative path to an aircraft starts at the working directory here, and at the
        folder of the file when the file has it.
    controller
        ``<outer>-<inner>``, such as ``ndi-l1``: sets the two kinds, keeps the parameters that the new kinds know. Any
        other name, or the path of a .py file, is that of a custom controller (docs/custom-controller.md). In Python it
        may be the controller itself: a function ``step(t, x1_c, x1, x2)``, a function ``create(design, h, options)``,
        or a module.
    changes
        More overrides, applied after the others, each after the option that it was given by.
    set
        Values by dotted key, such as ``{"faults[0].effectiveness": 0.5}``, applied last.

    Raises
    ------
    InputError
        If anything is wrong with the file, an option or the scenario they make; all errors of the scenario at once.
    """
    document, folder = _document_of(source)
    for key, value in (("plant", plant), ("aircraft", None if aircraft is None else os.fspath(aircraft))):
        if value is not None:
            document.data[key] = value
            document.put((key,), f"--{key} {value}")
    if controller is not None:
        named = isinstance(controller, str | os.PathLike)
        set_controller(document, os.fspath(controller) if named else in_memory.register(controller))  # type: ignore[arg-type]
    for override in overrides:
        apply(document, override)
    for option, override in changes:
        apply(document, override, option)
    for key, value in (set or {}).items():
        put(document, key, plain_data(value), f"{key} = {value!r}"[:200])
    _resolve_aircraft(document, folder)
    resolve_controller(document, folder)
    return scenario_of(document)


def make_scenario(data: Mapping[str, Any] | None = None, **sections: Any) -> Scenario:
    """Return a scenario made in Python: ``make_scenario(name="mine", duration_s=10, reference={"phi_deg": 5})``.

    Parameters
    ----------
    data
        Its sections as a file has them.
    sections
        The same as keyword arguments; they go first.

    Raises
    ------
    InputError
        All that is wrong with it.
    """
    return load_scenario({**(data or {}), **sections})


def _document_of(source: str | os.PathLike[str] | Mapping[str, Any] | Scenario) -> tuple[Document, Path]:
    """Return the data of a scenario, and the folder that relative paths in it start at."""
    if isinstance(source, Scenario):
        return Document(plain_data(source.model_dump()), f"the scenario {source.name}"), Path.cwd()
    if isinstance(source, Mapping):
        return Document(plain_data(source), "the scenario given as a dict"), Path.cwd()
    path = find_scenario(source)
    return read_document(path), path.parent


def plain_data(value: Any) -> Any:
    """Return a value as YAML would give it: lists for tuples and arrays, Python's own numbers."""
    if isinstance(value, Mapping):
        return {key: plain_data(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return [plain_data(item) for item in value] if isinstance(value, list | tuple) else value


def scenario_of(document: Document) -> Scenario:
    """Return the scenario that a document describes, checked.

    Raises
    ------
    InputError
        All that is wrong with it, each with its place.
    """
    try:
        scenario = Scenario.model_validate(document.data)
    except ValidationError as error:
        raise join(explain(error, document, Scenario)) from None
    scenario._origin = Origin(document)
    return scenario


def controller_name(scenario: Scenario) -> str:
    """Return the controller's name as `--controller` takes it, such as ``nndondi-l1``; of a custom one a short name."""
    controller = scenario.controller
    if isinstance(controller, CustomController):
        return custom_name(controller.kind)
    return spelling(controller.outer.kind, controller.inner.kind)


def find_scenario(source: str | os.PathLike[str]) -> Path:
    """Return the file of a scenario given as a path or by the name of a shipped one; an existing file goes first.

    Raises
    ------
    InputError
        If there is neither.
    """
    text, path = os.fspath(source), Path(source)
    try:
        exists, folder = path.exists(), path.is_dir()
    except (OSError, ValueError):  # a name no file can have
        exists = folder = False
    if exists and not folder:
        return path
    names = resources.scenario_names()
    grouped = [name for group in resources.GROUPS for name in resources.scenario_names(group)]
    name = text.removesuffix(".yaml")
    if name in names or name in grouped:
        return resources.scenario_dir() / f"{name}.yaml"
    near = difflib.get_close_matches(name, [*names, *grouped], n=1)
    near = near or [other for other in grouped if other.rpartition("/")[2] == path.stem]
    raise InputError(
        (text if text.isprintable() else repr(text))[:200] or "SCENARIO",
        found="a folder" if folder else "no such file",
        expected=f"a scenario file, or one of {', '.join([*names, *(f'{group}/...' for group in resources.GROUPS)])}",
        remedy=f"did you mean {near[0]}?" if near else "check the path",
    )


def read_document(path: Path, what: str = "scenario") -> Document:
    """Return the data of a YAML file, called a `what` in messages, with the line of each key, unchecked.

    Raises
    ------
    InputError
        If the file cannot be read, is longer than `MAX_BYTES`, or is no YAML map.
    """
    file = str(path)
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
    except OSError as error:
        found = f"a file that cannot be read: {error.strerror or error}"
        remedy = "check its permissions"
        raise InputError(file, found=found, expected=f"a readable {what}", remedy=remedy) from None
    if len(raw) > MAX_BYTES:
        remedy = f"give a {what}, not a result or a log"
        raise InputError(file, found="a longer file", expected=f"at most {MAX_BYTES} bytes", remedy=remedy)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        where = f"{file}, line {raw.count(10, 0, error.start) + 1}"
        found = f"the byte 0x{raw[error.start]:02x}, which is not UTF-8"
        raise InputError(where, found=found, expected="UTF-8 text", remedy="save the file as UTF-8") from None
    data, places = parse(text, file)
    if not isinstance(data, dict):
        found = "an empty file" if data is None else f"{describe(data)} at the top"
        remedy = "begin with name:, as the shipped ones do"
        raise InputError(f"{file}, line 1", found=found, expected="key: value pairs", remedy=remedy)
    return Document(data, file, places)


def _resolve_aircraft(document: Document, folder: Path) -> None:
    """Make a path to an aircraft absolute; a name, and one that JSBSim ships (``jsbsim:c172p``), stays as it is."""
    text = document.data.get("aircraft")
    if not isinstance(text, str) or not text or text.startswith("jsbsim:") or text in resources.aircraft_names():
        return
    place = document.place(("aircraft",))
    bases = [Path.cwd()] if place.startswith("--") else [folder, Path.cwd()]
    is_path = any(sep in text for sep in (os.sep, os.altsep) if sep) or text in (".", "..")
    for base in bases:
        try:
            if (base / text).exists() if is_path else (base / text).is_dir():
                document.data["aircraft"] = str((base / text).resolve())
                return
        except (OSError, ValueError):
            continue
    if is_path:
        looked = " and ".join(dict.fromkeys(str(base.resolve()) for base in bases))
        raise InputError(
            f"{place}, key aircraft",
            found=f"{describe(text)}, which does not exist (looked in {looked})",
            expected="the folder of an aircraft, the name of a shipped one, or jsbsim:NAME",
            remedy=f"check the path; shipped: {', '.join(resources.aircraft_names())}",
        )
