"""Schema errors as messages for the user: file and line, key, what was found, what was expected, how to fix it."""

from __future__ import annotations

import difflib
import typing
from typing import Any

from pydantic import BaseModel, ValidationError

from uavftc.config.document import Document, Key
from uavftc.config.effect import ENGINE, tag_of
from uavftc.config.expression import KNOWN
from uavftc.config.formula import KNOWN as FORMULA
from uavftc.config.values import Problem, key_text
from uavftc.errors import InputError

MAX_SHOWN = 8  # errors reported at once: a message fits on a screen of 40 lines
_UNITS = {
    "degps_per_rthz": "deg/s/sqrt(Hz)",
    "deg_per_rthz": "deg/sqrt(Hz)",
    "degps_per_rts": "deg/s/sqrt(s)",
    "deg_per_rts": "deg/sqrt(s)",
    "degps2": "deg/s^2",
    "degps": "deg/s",
    "deg": "deg",
    "radps": "rad/s",
    "rad": "rad",
    "mps_per_m": "m/s per m",
    "mps": "m/s",
    "m": "m",
    "m2": "m^2",
    "kg": "kg",
    "kgm2": "kg m^2",
    "n": "N",
    "nm": "N m",
    "s": "s",
    "hz": "Hz",
}
_LIMITS = {
    "greater_than": ("gt", "greater than"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "less than"),
    "less_than_equal": ("le", "at most"),
}


def explain(error: ValidationError, document: Document, root: type[BaseModel]) -> list[InputError]:
    """Return the errors of a file in the order of its schema `root`, each with the place of its key in `document`."""
    errors: list[InputError] = []
    items = error.errors(include_url=False)
    for item in items:
        key, model = _locate(item["loc"], root)
        problems = item.get("ctx", {}).get("problems")
        for problem in problems or [_problem(item, key, model, root)]:
            full = (*key, *problem.key) if problems else problem.key
            where = f"{document.place(full)}, key {key_text(full)}" if full else document.place(full)
            errors.append(InputError(where, found=problem.found, expected=problem.expected, remedy=problem.remedy))
    if len(errors) > MAX_SHOWN + 1:  # one more takes no more room than to say so
        more = f"{len(errors) - MAX_SHOWN} more errors"
        del errors[MAX_SHOWN:]
        errors.append(InputError(document.file, found=more, expected="none", remedy="fix those above first"))
    return errors


def _locate(loc: tuple[str | int, ...], root: type[BaseModel]) -> tuple[Key, type[BaseModel]]:
    """Return the key path of a schema location, which names union members too, and the section its last part is in."""
    key: list[str | int] = []
    model = holder = root
    choices: dict[str, type[BaseModel]] = {}
    for part in loc:
        if part in choices and len(choices) > 1:
            model, choices = choices[str(part)], {}
            continue
        if len(choices) == 1 and not isinstance(part, int):
            model = next(iter(choices.values()))
            choices = {}
        key.append(part)
        if isinstance(part, str) and not choices:
            holder = model
            choices = _sections(_annotation(model, part))
    return tuple(key), holder


def _annotation(model: type[BaseModel], key: str) -> Any:
    """Return what may stand under a key of a section: under a name of the user's, what all of these hold."""
    if key in model.model_fields:
        return model.model_fields[key].annotation
    by_name = model.model_config.get("extra") == "allow"
    return typing.get_type_hints(model)["__pydantic_extra__"] if by_name else None


def _sections(annotation: Any) -> dict[str, type[BaseModel]]:
    """Return the sections an annotation admits, by the name that the errors of a union use."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        kind = annotation.model_fields.get("kind")
        return {tag_of(annotation) if kind and isinstance(kind.default, str) else annotation.__name__: annotation}
    return {name: model for part in typing.get_args(annotation) for name, model in _sections(part).items()}


def _problem(item: Any, key: Key, model: type[BaseModel], root: type[BaseModel]) -> Problem:
    kind, value, ctx = item["type"], item["input"], item.get("ctx", {})
    name = str(key[-1]) if key else ""
    found = describe(value)
    unit = _unit(key)
    match kind:
        case "extra_forbidden":
            return _unknown(key, model, root)
        case "missing":
            return Problem(key, "nothing", f"the key {name}{unit}", f"add {name}")
        case "literal_error" | "union_tag_invalid" | "union_tag_not_found":
            return _choice(item, key, value, model)
        case "signal":
            return _signal(key, value, ctx["problem"], unit)
        case "formula":
            said = f"{found}: {ctx['problem'].splitlines()[0]}"
            return Problem(key, said, "a formula such as abs(phi_error_deg) <= 1", f"a formula knows {FORMULA}")
        case "float_type" | "finite_number":
            remedy = "write a number"
            if isinstance(value, str):
                remedy += " without quotes; this key takes no expression of t"
            return Problem(key, found, f"a finite number{unit}", remedy)
        case "bool_type":
            return Problem(key, found, "true or false", "write true or false, without quotes")
        case "int_type":
            return Problem(key, found, "a whole number", "write it without quotes and decimal point")
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal":
            limit, words = _LIMITS[kind]
            return Problem(key, found, f"a number {words} {ctx[limit]:g}{unit}", "choose a value within the limits")
        case "model_type" | "model_attributes_type" | "dict_type":
            return Problem(key, found, "a section: key: value, or {key: value}", "write its keys below it, indented")
        case "tuple_type" | "list_type":
            return Problem(key, found, "a list", "write each entry after a dash, or [a, b]")
        case "too_long" | "too_short":
            expected = ctx.get("max_length", ctx.get("min_length"))
            return Problem(key, f"{ctx['actual_length']} entries", f"{expected} entries", "give as many as expected")
        case "string_type":
            plain = isinstance(value, int | float)
            return Problem(key, found, "a text", "put it in quotes" if plain else "write one text in its place")
        case "string_pattern_mismatch":
            expected = "letters, digits, dot, dash and underscore, beginning with a letter or digit"
            return Problem(key, found, expected, "the name becomes the name of a folder: choose a plain one")
        case "string_too_long" | "string_too_short":
            expected = f"at most {ctx['max_length']}" if "max_length" in ctx else f"at least {ctx['min_length']}"
            return Problem(key, f"{len(value)} characters", f"{expected} characters", "choose another text")
        case "window":
            return Problem(key, f"{value} s", item["msg"], "move end_s, or leave it out for the rest of the flight")
    return Problem(key, found, item["msg"], "change the value")


def _unit(key: Key) -> str:
    """Return the unit a key's suffix names, for the end of a phrase."""
    unit = unit_of(next((part for part in reversed(key) if isinstance(part, str)), ""))
    return f", {unit}" if unit else ""


def unit_of(name: str) -> str:
    """Return the unit that a key's suffix names, or nothing; the m of A_m is none."""
    return apart(name)[1]


def apart(name: str) -> tuple[str, str]:
    """Return a key without the suffix of its unit, and that unit, or nothing."""
    for suffix, unit in _UNITS.items():
        if name.endswith(f"_{suffix}") and name.islower():
            return name.removesuffix(f"_{suffix}"), unit
    return name, ""


def _unknown(key: Key, model: type[BaseModel], root: type[BaseModel]) -> Problem:
    name, known = str(key[-1]), sorted(model.model_fields, key=lambda field: field != "kind")
    near = difflib.get_close_matches(name, known, n=1)
    remedy = f"did you mean {near[0]}?" if near else "remove it"
    siblings = [k for k, other in _siblings(model, root).items() if name in other.model_fields]
    if siblings:
        remedy = f"remove it: it belongs to kind {' and '.join(siblings)}"
    remedy = getattr(model, "remedies", {}).get(name, remedy)
    by_name = ", or the name of a surface with a section of its own" if model.model_config["extra"] == "allow" else ""
    return Problem(key, f"the unknown key {describe(name)}", f"one of {', '.join(known)}{by_name}", remedy)


def _siblings(model: type[BaseModel], root: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Return the sections below `root` that can take the place of `model`, by their kind."""
    for field in root.model_fields.values():
        sections = _sections(field.annotation)
        if model in sections.values() and "kind" in model.model_fields:
            return {k: other for k, other in sections.items() if other is not model}
        for section in sections.values():
            if found := _siblings(model, section):
                return found
    return {}


def _choice(item: Any, key: Key, value: Any, model: type[BaseModel]) -> Problem:
    ctx, absent = item.get("ctx", {}), item["type"] == "union_tag_not_found"
    if item["type"] == "literal_error":
        expected = ctx["expected"]
    else:  # the tag of a union: its key is wrong, not the section
        field = next(part for part in reversed(key) if isinstance(part, str))
        sections = _sections(model.model_fields[field].annotation)
        named = [name for name, section in sections.items() if not getattr(section, "refused", False)]
        key = (*key, "kind")
        of_engine = isinstance(value, dict) and "engine" in value
        if isinstance(value, dict):
            absent = absent or "kind" not in value
            value = value.get("kind")
        kinds = [name.removeprefix(ENGINE) for name in named if name.startswith(ENGINE) == of_engine]
        expected = ", ".join(kinds)
        if (str(value) if of_engine else f"{ENGINE}{value}") in named:  # there is one, of the other
            own, other = ("engine", "surface") if of_engine else ("surface", "engine")
            remedy = f"it is a fault of {'a surface' if of_engine else 'an engine'}: write {other} in place of {own}"
            return Problem(key, describe(value), f"with {own}, one of {expected}", remedy)
    known = [word.strip().strip("'") for word in expected.replace(" or ", ", ").split(",")]
    near = difflib.get_close_matches(str(value), known, n=1)
    found = "nothing" if absent else describe(value)
    if len(known) == 1:
        remedy = getattr(model, "remedies", {}).get(str(key[-1]), f"write {known[0]}, the only one there is")
        return Problem(key, found, known[0], remedy)
    remedy = f"did you mean {near[0]}?" if near else "choose one of them"
    return Problem(key, found, f"one of {', '.join(known)}", remedy)


def _signal(key: Key, value: Any, problem: str, unit: str) -> Problem:
    found = f"{describe(value)}: {problem.splitlines()[0]}"
    return Problem(key, found, f"a finite number or an expression of t{unit}", f"an expression knows {KNOWN}")


def describe(value: object) -> str:
    """Return a value in short, as the user wrote it."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        text = value if len(value) <= 60 else f"{value[:57]}..."
        return f"'{text}'" if text.isprintable() else repr(text)
    if isinstance(value, dict):
        names = [key_text((str(name),)) for name in list(value)[:8]]
        return "a section with the keys " + ", ".join(names) if value else "an empty section"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    text = str(value)
    return text if len(text) <= 40 else f"{text[:20]}... ({len(text)} digits)"
