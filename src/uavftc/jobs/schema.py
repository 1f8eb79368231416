"""`uavftc schema`: the JSON Schema of scenarios, campaigns and companion files, for editors and other programs.

It is made of the models that check the files, with what the models do in code and pydantic does not see: a `kind` that
may be left out, sections that may be null, keys of which exactly one is given. What concerns several values at once
(a window that ends before it begins, two faults of one surface), and whether a name is one of the aircraft's, it cannot
say: the file passes, and `uavftc` refuses it.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import core_schema

from uavftc import __version__
from uavftc.actuators import effectiveness
from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import NAME, Effector
from uavftc.analysis.metrics import METRICS
from uavftc.config.described import descriptions
from uavftc.config.shipped import aircraft_names
from uavftc.config.values import AtLeast
from uavftc.control import inner, outer
from uavftc.control.whole import NAMES
from uavftc.core.signals import SURFACES
from uavftc.errors import InputError
from uavftc.scenario.campaign import KINDS, Campaign, Vary
from uavftc.scenario.controllers import LOOPS, Controller, CustomController
from uavftc.scenario.requirements import Requirement
from uavftc.scenario.schema import Scenario

DIALECT = "https://json-schema.org/draft/2020-12/schema"
FILES: dict[str, type[BaseModel]] = {"scenario": Scenario, "campaign": Campaign, "aircraft": Aircraft}
"""What there is a schema of."""

_WITHOUT_KIND = (effectiveness.Config, outer.DEFAULT.Config, inner.DEFAULT.Config)
_ONE_OF: dict[type[BaseModel], tuple[str, ...]] = {
    Vary: KINDS,
    Requirement: ("always", "eventually"),
    Effector: ("command", "throttle"),
}
_NAMES: dict[type[BaseModel], dict[str, dict[str, Any]]] = {
    Campaign: {
        "vary": {"not": {"enum": ["name", "description", "plant", "aircraft", "controller"]}},
        "success": {"enum": [metric.name for metric in METRICS]},
    },
    Aircraft: {"gangs": {"enum": list(SURFACES)}, "effectors": {"pattern": f"^{NAME}$", "maxLength": 60}},
}
_EXAMPLES: dict[type[BaseModel], dict[str, list[str]]] = {
    Scenario: {"aircraft": [*aircraft_names(), "jsbsim:c172p"]},
    CustomController: {"kind": list(NAMES)},
}


def schema_of(file: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a kind of file, one of `FILES`.

    Raises
    ------
    InputError
        If there is no such kind.
    """
    if file not in FILES:
        expected = ", ".join(FILES)
        raise InputError("schema", found=f"'{file[:60]}'", expected=f"one of {expected}", remedy="name one of them")
    made = FILES[file].model_json_schema(schema_generator=_Generator)
    names = {name: _plain_name(name) for name in made.get("$defs", {})}
    made = _cleaned(made, names)
    head = {"$schema": DIALECT, "title": f"uavftc {file}", "$comment": f"uavftc {__version__}, uavftc schema {file}"}
    return {**head, **{key: value for key, value in made.items() if key not in head}}


def write_schema(file: str, out: Path | None) -> str:
    """Return the text of a schema; write it to the file `out`, where there is one.

    Raises
    ------
    InputError
        If there is no such kind of file, or `out` cannot be written.
    """
    text = json.dumps(schema_of(file), indent=2, ensure_ascii=False) + "\n"
    if out is not None:
        try:
            out.write_text(text, encoding="utf-8")
        except OSError as error:
            found = error.strerror or str(error)
            remedy = "name another file with --out"
            raise InputError(f"--out {out}", found=found, expected="a file to write", remedy=remedy) from None
    return text


class _Generator(GenerateJsonSchema):
    """Adds to each section what its model does in code, and what its keys mean."""

    def model_schema(self, schema: core_schema.ModelSchema) -> JsonSchemaValue:
        made = super().model_schema(schema)
        cls, keys = schema["cls"], made.get("properties", {})
        meanings = descriptions(cls)
        for name, field in cls.model_fields.items():
            key = keys[field.alias or name]
            meaning = meanings[name] or (made.get("description", "") if name == "kind" else "")
            if meaning:
                key["description"] = _without_links(meaning)
            for low in (item.low for item in field.metadata if isinstance(item, AtLeast)):
                key["anyOf"][0]["minimum"] = low
            if name in _NAMES.get(cls, {}):
                _map(key)["propertyNames"] = _NAMES[cls][name]
            if name in _EXAMPLES.get(cls, {}):
                key["examples"] = _EXAMPLES[cls][name]
        for name in _nullable(cls):
            keys[name] = _or_null(keys[name])
        if "const" in keys.get("kind", {}) and cls not in _WITHOUT_KIND:
            made["required"] = ["kind", *(key for key in made.get("required", []) if key != "kind")]
        if cls in _ONE_OF:
            given = [{"required": [key], "properties": {key: {"not": {"type": "null"}}}} for key in _ONE_OF[cls]]
            made["oneOf"] = given
        return made


def _nullable(cls: type[BaseModel]) -> set[str]:
    """Return the sections of a model that are as left out where they are null."""
    if issubclass(cls, Scenario):
        return cls.nullable()
    return set(LOOPS) if issubclass(cls, Controller) else set()


def _or_null(key: JsonSchemaValue) -> JsonSchemaValue:
    about: dict[str, Any] = {name: key[name] for name in ("description", "default") if name in key}
    return {"anyOf": [{k: v for k, v in key.items() if k not in about}, {"type": "null"}], **about}


def _map(key: JsonSchemaValue) -> JsonSchemaValue:
    """Return the part of a key's schema that is of a map."""
    found: JsonSchemaValue = next(part for part in (key, *key.get("anyOf", ())) if part.get("type") == "object")
    return found


def _plain_name(name: str) -> str:
    """Return a section's name without the package: `actuators.stuck` of `uavftc__actuators__stuck__Config`."""
    return name.removeprefix("uavftc__").removesuffix("__Config").replace("__", ".")


def _without_links(text: str) -> str:
    return re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", text)


def _cleaned(node: Any, names: dict[str, str]) -> Any:
    """Return a schema without titles of keys and defaults of sections, with plain names and lists of one kind.

    A list whose items are all of one kind is `items` with a length: editors that read draft 7 know no `prefixItems`.
    """
    if isinstance(node, list):
        return [_cleaned(item, names) for item in node]
    if not isinstance(node, dict):
        return node
    made: dict[str, Any] = {}
    for key, value in node.items():
        if key == "$defs":
            made[key] = {names[name]: _cleaned(section, names) for name, section in value.items()}
        elif key == "properties":
            made[key] = {name: _cleaned(section, names) for name, section in value.items()}
        elif key == "$ref":
            made[key] = f"#/$defs/{names[value.rpartition('/')[2]]}"
        elif key == "prefixItems" and all(item == value[0] for item in value):
            made["items"] = _cleaned(value[0], names)
        elif key in ("examples", "enum", "const"):
            made[key] = value
        elif key == "patternProperties":  # a map with names of a kind has no others
            made[key] = {name: _cleaned(section, names) for name, section in value.items()}
            made["additionalProperties"] = False
        elif not (key in ("title", "discriminator") or (key == "default" and _is_section(value))):
            made[key] = _cleaned(value, names)
    return made


def _is_section(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and any(isinstance(item, dict) for item in value))
