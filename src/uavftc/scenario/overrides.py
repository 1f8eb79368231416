"""Changes to a scenario's data before it is checked: ``--set KEY=VALUE`` and ``--controller NAME``."""

from __future__ import annotations

import difflib
import os
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from uavftc.config.document import Document, Key, parse
from uavftc.config.effect import default_kind
from uavftc.config.values import key_text
from uavftc.control.custom import in_memory
from uavftc.control.custom.module import HOW, SHIPPED, is_path, is_there, registered
from uavftc.errors import InputError
from uavftc.scenario.controllers import CONTROLLERS, LOOPS, kinds

_PART = re.compile(r"([A-Za-z_][A-Za-z0-9_-]*|[0-9]+)((?:\[[0-9]+\])*)")


def set_controller(document: Document, name: str) -> None:
    """Set the two kinds, or the one of a custom controller; what the new kinds lack is dropped, the others kept.

    A name that is not a pair of kinds is taken as a custom controller; `resolve_controller` checks that there is one.
    """
    if document.data.get("controller") is None:
        document.data["controller"] = {}
    section = document.data["controller"]
    if not isinstance(section, dict):
        return  # the schema reports what is wrong with it
    if section.get("kind", name) != name:  # another controller's options
        section.pop("options", None)
    if section.pop("kind", None) is not None and name in CONTROLLERS:
        section.pop("timeout_s", None)  # a pair of laws is compiled, and not timed
    if name not in CONTROLLERS:
        for part in ("outer", "inner"):
            section.pop(part, None)
        section["kind"] = name
        document.put(("controller", "kind"), f"--controller {name}")
        return
    for part, kind in zip(LOOPS, CONTROLLERS[name], strict=True):
        models, default = kinds(part), default_kind(LOOPS[part].DEFAULT.Config)
        loop = section.get(part)
        if loop is None:
            loop = {}
        if not isinstance(loop, dict):
            continue
        old = models.get(str(loop.get("kind", default)))
        lacking = set(old.Config.model_fields) - set(models[kind].Config.model_fields) if old else set()
        section[part] = {**{k: v for k, v in loop.items() if k not in lacking}, "kind": kind}
        document.places[("controller", part, "kind")] = f"--controller {name}"


def custom_name(kind: str) -> str:
    """Return a short name, fit for a folder, of a custom controller: the last part of its import path, or its stem."""
    kind = kind.removeprefix(in_memory.PREFIX)
    last = re.split(r"[/\\]", kind.removesuffix(".py"))[-1] if is_path(kind) else kind.rpartition(".")[2]
    name = re.sub(r"[^A-Za-z0-9_-]", "_", last)[:100]
    taken = name in CONTROLLERS or (name in SHIPPED and kind != name) or not name[:1].isalnum()
    return f"own-{name}" if taken else name


def resolve_controller(document: Document, folder: Path) -> None:
    """Make the path of a custom controller absolute, and check that one given by name exists.

    A path starts at `folder`, then at the working directory; given as an option, at the working directory.

    Raises
    ------
    InputError
        If there is no such file, or nothing that this name could mean.
    """
    section = document.data.get("controller")
    kind = section.get("kind") if isinstance(section, dict) else None
    if not isinstance(section, dict) or not isinstance(kind, str) or not kind:
        return
    place = document.place(("controller", "kind"))
    where = f"{place}, key controller.kind"
    if is_path(kind):
        bases = [Path.cwd()] if place.startswith("--") else [folder, Path.cwd()]
        for base in bases:
            with suppress(OSError, ValueError):
                file = os.path.abspath(base / Path(kind).expanduser())
                if os.path.isfile(file):
                    section["kind"] = file
                    return
        looked = " and ".join(dict.fromkeys(str(base.resolve()) for base in bases))
        found = f"{kind!r}, which is not a file (looked in {looked})"
        raise _error(where, found, "the path of a Python file", "check the path")
    if kind in CONTROLLERS:
        outer, inner = CONTROLLERS[kind]
        remedy = f"write outer: {{kind: {outer}}} and inner: {{kind: {inner}}} in its place"
        raise _error(where, f"'{kind}', which is a pair of laws", "the module of a controller", remedy)
    if not is_there(kind):
        if kind.startswith(in_memory.PREFIX):
            raise in_memory.missing(kind, where)
        known = [*CONTROLLERS, *registered()]
        near = _nearest(kind, known)
        raise _error(
            where,
            f"{kind!r}, which is neither a known controller nor a module that can be found",
            f"one of {', '.join(known)}, or a custom controller",
            f"{f'{near} ' if near else ''}A custom controller is given as {HOW}",
        )


def apply(document: Document, override: str, where: str | None = None) -> None:
    """Set one key from ``dotted.key=value``; the value is YAML, missing sections are created.

    `where` is the option that it was given by; None is ``--set``.

    Raises
    ------
    InputError
        If the key is not a path, leads through something that is neither section nor list, or past the end of a list.
    """
    where = where or f"--set {override[:200]}"
    text, equals, value_text = override.partition("=")
    if not equals:
        raise _error(where, "no '='", "--set KEY=VALUE", "for example --set reference.phi_deg=3")
    value, _ = parse(value_text, where, lines=False)
    put(document, text.strip(), value, where)


def put(document: Document, text: str, value: Any, where: str) -> None:
    """Set the value at a dotted key; missing sections are created.

    Raises
    ------
    InputError
        As `apply`.
    """
    key = _path(text, where)
    target: Any = document.data
    taken: Key = ()
    for i, written in enumerate(key):
        part = _fitting(target, written, taken, where)
        taken = (*taken, part)
        if i == len(key) - 1:
            target[part] = value
        elif isinstance(target, dict) and target.get(part) is None:
            target[part] = {}
            document.put(taken, where)
        target = target[part]
    document.put(taken, where)


def _path(text: str, where: str) -> Key:
    key: list[str | int] = []
    for piece in text.split("."):
        match = _PART.fullmatch(piece)
        if match is None:
            raise _error(where, f"the key '{text}'", "a dotted key", "write it as faults[0].effectiveness")
        key.append(match[1])
        key.extend(int(index[:18]) for index in re.findall(r"[0-9]+", match[2]))
    return tuple(key)


def _fitting(target: Any, part: str | int, here: Key, where: str) -> Any:
    """Return `part` as `target` is indexed: a name in a section, a whole number in a list."""
    name = key_text(here) or "the scenario"
    if isinstance(target, list):
        if not isinstance(part, int) and not part.isdigit():
            raise _error(where, f"'{part}', where {name} is a list", "an index", f"write {name}[0] for its first entry")
        if int(part) >= len(target):
            held = f"{name} has {len(target)} {'entry' if len(target) == 1 else 'entries'}"
            remedy = f"set the whole list: {_setting(name, where)}"
            raise _error(where, f"index {part}; {held}", f"an index below {len(target)}", remedy)
        return int(part)
    if isinstance(target, dict):
        if isinstance(part, int):
            found = f"index {part}, where {name} holds no list"
            raise _error(where, found, "the name of a key", f"set the whole list: {_setting(name, where)}")
        return part
    found = f"{name}, which is neither a section nor a list"
    raise _error(where, found, "a key of the scenario", f"set {name} as a whole")


def _setting(name: str, where: str) -> str:
    """Return how a list is set as a whole: as an option, or in Python."""
    return f"--set '{name}=[...]'" if where.startswith("--") else f'{{"{name}": [...]}}'


def _error(where: str, found: str, expected: str, remedy: str) -> InputError:
    return InputError(where, found=found, expected=expected, remedy=remedy)


def _nearest(word: str, known: list[str]) -> str | None:
    near = difflib.get_close_matches(word, known, n=1)
    return f"did you mean {near[0]}?" if near else None
