"""The YAML text of a scenario as flown: every key, floats by repr, so that reading it gives the same scenario."""

from __future__ import annotations

import re
from typing import Any

from uavftc.scenario.schema import Scenario

MAX_WIDTH = 110  # columns up to which a list or map stays on one line

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_./-]*(?: [A-Za-z0-9_./-]+)*")
_WORDS = ("null", "true", "false")  # texts YAML would read as something else
_FIRST = ("kind", "surface", "engine")
_ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}


def scenario_text(scenario: Scenario) -> str:
    """Return the scenario as YAML with every default filled in; `load_scenario` on it gives an equal scenario."""
    data = scenario.model_dump()
    if "options" in data["controller"]:
        data["controller"]["options"] = _as_given(data["controller"]["options"])
    return "\n".join(_block(data, 0)) + "\n"


def value_text(value: Any) -> str:
    """Return a value on one line of YAML, as ``--set KEY=VALUE`` takes it; reading it gives the same value."""
    return _flow(value)


class _Given(dict[str, Any]):
    """A map of the user's, whose order is kept."""


def _as_given(value: Any) -> Any:
    if isinstance(value, dict):
        return _Given({key: _as_given(item) for key, item in value.items()})
    return [_as_given(item) for item in value] if isinstance(value, list | tuple) else value


def _block(section: dict[str, Any], indent: int) -> list[str]:
    """Return the lines of a section: short values on one line, long ones below their key."""
    lines: list[str] = []
    for key, value in _ordered(section):
        line = f"{' ' * indent}{_quoted(key)}: {_flow(value)}"
        records = isinstance(value, list | tuple) and bool(value) and all(isinstance(item, dict) for item in value)
        if isinstance(value, dict) and len(line) > MAX_WIDTH:
            lines += [f"{' ' * indent}{_quoted(key)}:", *_block(value, indent + 2)]
        elif records:
            lines.append(f"{' ' * indent}{_quoted(key)}:")
            for item in value:
                lines += _item(item, indent + 2)
        else:
            lines.append(line)
    return lines


def _item(item: dict[str, Any], indent: int) -> list[str]:
    line = f"{' ' * indent}- {_flow(item)}"
    if len(line) <= MAX_WIDTH:
        return [line]
    first, *rest = _block(item, indent + 2)
    return [f"{' ' * indent}- {first.lstrip()}", *rest]


def _ordered(section: dict[str, Any]) -> list[tuple[str, Any]]:
    """Return the keys in the order of the schema, with what the section is about first."""
    if isinstance(section, _Given):
        return list(section.items())
    return sorted(section.items(), key=lambda item: _FIRST.index(item[0]) if item[0] in _FIRST else len(_FIRST))


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_quoted(key)}: {_flow(v)}" for key, v in _ordered(value)) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_flow(v) for v in value) + "]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    return _quoted(value) if isinstance(value, str) else repr(value)


def _quoted(text: str) -> str:
    """Return a text as YAML: bare where that is unmistakable, else in double quotes."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    return '"' + "".join(_escaped(ch) for ch in text) + '"'


def _escaped(ch: str) -> str:
    if ch in _ESCAPES:
        return _ESCAPES[ch]
    if ch.isprintable() and ch != "\ufeff":
        return ch
    return f"\\U{ord(ch):08x}" if ord(ch) > 0xFFFF else f"\\u{ord(ch):04x}"
