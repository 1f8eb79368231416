"""YAML text to plain data that remembers where each key stands.

Plain scalars are read by the YAML 1.2 core rules, so ``1e5`` is a number and ``yes`` a text, whatever the file claims.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from uavftc.config.values import key_text
from uavftc.errors import InputError

MAX_NODES = 20_000  # scalars, lists and maps after aliases are followed; the paper's scenario 3 has about 150
MAX_DEPTH = 50

Key = tuple[str | int, ...]

_INT = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_PLAIN = "null bool int float str map seq timestamp merge value"  # kinds the parser sees by itself, none of them code
_TAGS = {f"tag:yaml.org,2002:{name}" for name in _PLAIN.split()}


@dataclass
class Document:
    """Data of a scenario and the place where each key was written, as a message shows it: ``file, line N``."""

    data: dict[str, Any]
    file: str
    places: dict[Key, str] = field(default_factory=dict)

    def place(self, key: Key) -> str:
        """Return the place of `key`, or of the nearest section around it that was written."""
        for length in range(len(key), 0, -1):
            if key[:length] in self.places:
                return self.places[key[:length]]
        return self.places.get((), self.file)

    def put(self, key: Key, place: str) -> None:
        """Note that the value at `key` now comes from `place`; the caller has changed the data."""
        for known in [k for k in self.places if k[: len(key)] == key]:
            del self.places[known]
        self.places[key] = place


class Origin:
    """Where the keys of a scenario were written. It is no part of what a scenario says, so that two are always equal.

    Without a document the scenario was made in Python.
    """

    def __init__(self, document: Document | None = None) -> None:
        self._document = document

    def place(self, key: Key) -> str:
        """Return the file and line of a key, or that there is none."""
        return "in Python" if self._document is None else self._document.place(key)

    def where(self, key: Key) -> str:
        """Return the place of a key as a message begins with it: ``file, line N, key faults[0].surface``."""
        place = "" if self._document is None else f"{self._document.place(key)}, "
        return f"{place}key {key_text(key)}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Origin)

    def __hash__(self) -> int:
        return 0


def parse(text: str, where: str, *, lines: bool = True) -> tuple[Any, dict[Key, str]]:
    """Return the data of one YAML document and the place of each key.

    Parameters
    ----------
    text
        The document.
    where
        The file or option it comes from; with `lines`, the line is added in errors and places.

    Raises
    ------
    InputError
        If the text is not one plain YAML document: no tags, no duplicate keys, no aliases that grow without bound.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a re-used anchor
            yaml = YAML(typ="safe", pure=True)
            yaml.Composer = _Composer
            node = yaml.compose(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = " ".join(str(error.problem or error.context).split()).removeprefix("found ")[:200]
        begun = error.context_mark
        if lines and begun is not None and mark is not None and begun.line < mark.line:
            problem += f" ({error.context}, begun on line {begun.line + 1})"
        if "another document" in problem:
            problem, remedy = "a second document", "keep one scenario in one file, without '---' between parts"
        elif "'\\t'" in problem:
            problem, remedy = "a tab", "indent with spaces"
        else:
            remedy = "check indentation, quotes, brackets and the space after each colon"
        place = f"{where}, line {mark.line + 1}" if lines and mark is not None else where
        raise InputError(place, found=problem, expected="one YAML document", remedy=remedy) from None
    except YAMLError as error:
        position = getattr(error, "position", None)
        place = f"{where}, line {text.count(chr(10), 0, position) + 1}" if lines and position is not None else where
        found = str(error).splitlines()[0]
        raise InputError(place, found=found, expected="YAML text", remedy="remove the character") from None
    except _TooLargeError as error:
        place = f"{where}, line {error.args[0] + 1}" if lines else where
        raise _too_large(place) from None
    except (RecursionError, ValueError, OverflowError):
        raise _too_large(where) from None
    reader = _Reader(where, lines)
    return (None if node is None else reader.read(node, (), 0)), reader.places


class _TooLargeError(Exception):
    """More values or levels than a scenario needs; holds the line, from 0."""


class _Composer(Composer):
    """Stops at the first value too many: the parser's work grows with the square of the depth."""

    _levels = _values = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self._values += 1
        if self._values > MAX_NODES or self._levels > MAX_DEPTH:
            raise _TooLargeError(self.parser.peek_event().start_mark.line)
        self._levels += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._levels -= 1


def _too_large(place: str) -> InputError:
    limit = f"at most {MAX_NODES} values, {MAX_DEPTH} levels deep, aliases included"
    remedy = "write the values out instead of repeating aliases within aliases, and flatten lists within lists"
    return InputError(place, found="more values or levels than any scenario needs", expected=limit, remedy=remedy)


class _Reader:
    """Turns composed nodes into data."""

    def __init__(self, where: str, lines: bool) -> None:
        self.where = where
        self.lines = lines
        self.places: dict[Key, str] = {}
        self.nodes = 0

    def place(self, node: Node) -> str:
        return f"{self.where}, line {node.start_mark.line + 1}" if self.lines else self.where

    def read(self, node: Node, key: Key, depth: int) -> Any:
        self.nodes += 1
        if self.nodes > MAX_NODES or depth > MAX_DEPTH:
            raise _too_large(self.place(node))
        if str(node.tag) not in _TAGS:
            found = f"the tag {str(node.tag)[:80]}"
            remedy = "remove the tag; numbers, texts, lists and maps need none"
            raise InputError(self.place(node), found=found, expected="plain YAML", remedy=remedy)
        self.places.setdefault(key, self.place(node))
        if isinstance(node, MappingNode):
            return self._mapping(node, key, depth)
        if isinstance(node, SequenceNode):
            return [self.read(item, (*key, i), depth + 1) for i, item in enumerate(node.value)]
        return self._scalar(node)

    def _mapping(self, node: MappingNode, key: Key, depth: int) -> dict[str, Any]:
        data: dict[str, Any] = {}
        first: dict[str, str] = {}
        for key_node, value_node in node.value:
            place = self.place(key_node)
            if not isinstance(key_node, ScalarNode):
                raise InputError(place, found="a list or map as a key", expected="a name", remedy="write key: value")
            name = self._text(key_node)
            if name in data:
                found = f"the key '{name}' a second time; the first is at {first[name]}"
                raise InputError(place, found=found, expected="each key once", remedy="remove one of them")
            first[name] = place
            self.places[(*key, name)] = place
            data[name] = self.read(value_node, (*key, name), depth + 1)
        return data

    def _text(self, node: Node) -> str:
        text = str(node.value)
        if any("\ud800" <= ch <= "\udfff" for ch in text):
            remedy = "write the character itself"
            raise InputError(self.place(node), found="half of a surrogate pair", expected="Unicode text", remedy=remedy)
        return text

    def _scalar(self, node: Node) -> Any:
        text = self._text(node)
        if not isinstance(node, ScalarNode) or node.style is not None:  # quoted, or a block of text
            return text
        if text in _SPECIAL:
            return _SPECIAL[text]
        if _INT.fullmatch(text) and len(text) <= 400:
            return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
        return float(text) if _FLOAT.fullmatch(text) else text
