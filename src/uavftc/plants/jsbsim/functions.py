"""The aerodynamic functions of an aircraft's XML: which there are, what a name means, and a factor on one.

A function is that of JSBSim's <aerodynamics>, inside an axis or before them. It has one term. A factor makes a product
of it, <product><value>k</value>term</product>, in the copy that is loaded.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.parsers import expat

SECTION = "aerodynamics"
_NO_TERM = ("description", "documentation")
MAX_NAMES = 100
"""Names that a message lists."""


class Factor(NamedTuple):
    """A factor on a function of the copy."""

    function: str
    """Its whole name."""
    value: float


@dataclass
class Function:
    """A function: its name, and the place of its term in the file, in bytes."""

    name: str
    begin: int = -1
    end: int = -1


class Found(NamedTuple):
    """The functions of a file."""

    functions: list[Function]
    elsewhere: str | None
    """The file that <aerodynamics> is in, where the main file only names it."""

    @property
    def names(self) -> list[str]:
        """Their names, in the order of the file."""
        return [function.name for function in self.functions]


class Meant(NamedTuple):
    """What a name means: a function, or what is wrong with it."""

    function: str | None
    expected: str = ""
    remedy: str = ""


def plain_utf8(xml: bytes) -> bytes:
    """Return an XML file in an encoding that has ASCII as it is: UTF-16 as UTF-8, all else as it was."""
    if xml[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return re.sub(r"\A<\?xml.*?\?>", '<?xml version="1.0"?>', xml.decode("utf-16"), flags=re.DOTALL).encode()
    return xml


def functions(xml: bytes) -> Found:
    """Return the aerodynamic functions of an aircraft's main file, from `plain_utf8`.

    Raises
    ------
    expat.ExpatError
        If it is not well-formed.
    """
    parser = expat.ParserCreate()
    found: list[Function] = []
    path: list[str] = []
    waiting: list[Function] = []  # an event does not say where it ends; the next one begins there
    inside = False  # of the first <aerodynamics>, the one that JSBSim reads
    seen = 0
    function: int | None = None  # depth of the function that is open
    file: str | None = None

    def event(*_: object) -> None:
        while waiting:
            waiting.pop().end = parser.CurrentByteIndex

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal inside, seen, function, file
        event()
        if len(path) == 1 and tag == SECTION:
            seen += 1
            if seen == 1:
                inside, file = True, attributes.get("file")
        elif inside and function is None and tag == "function":
            function = len(path)
            found.append(Function(" ".join(attributes.get("name", "").split())))
        elif function is not None and len(path) == function + 1 and tag not in _NO_TERM and found[-1].begin < 0:
            found[-1].begin = parser.CurrentByteIndex
        path.append(tag)

    def stop(_tag: str) -> None:
        nonlocal inside, function
        event()
        path.pop()
        if function is not None and len(path) == function + 1 and found[-1].begin >= 0 > found[-1].end:
            waiting.append(found[-1])
        elif function == len(path):
            function = None
        elif len(path) == 1:
            inside = False

    parser.StartElementHandler, parser.EndElementHandler, parser.DefaultHandler = start, stop, event
    parser.Parse(xml, True)
    return Found([one for one in found if one.name and one.end > 0], file)


def meant(name: str, names: Sequence[str]) -> Meant:
    """Return which of the functions with these names a name means: the whole name, or its last part, to the letter."""
    last = {full: full.rpartition("/")[2] for full in names}
    those = [full for full in names if full == name] or [full for full in names if last[full] == name]
    if len(those) == 1:
        return Meant(those[0])
    if those:
        whole = ", ".join(dict.fromkeys(those))
        if len(set(those)) == 1:
            return Meant(None, f"a function whose name stands once in the XML; {whole} stands {len(those)} times",
                         "give each a name of its own there")  # fmt: skip
        return Meant(None, f"one function; it is the last part of {whole}", "write the whole name of one of them")
    known = list(dict.fromkeys(last.values()))
    near = difflib.get_close_matches(name, [*known, *names], n=1)
    return Meant(None, f"one of {listed(known)}", f"did you mean {near[0]}?" if near else "choose one of them")


def listed(names: Sequence[str]) -> str:
    """Return names as a message shows them."""
    more = f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
    return ", ".join(names[:MAX_NAMES]) + more


def scaled(xml: bytes, factors: Iterable[Factor]) -> list[tuple[int, int, bytes]]:
    """Return the changes (from, to, text) of a file that put the factors on its functions.

    Raises
    ------
    KeyError
        If there is no such function.
    """
    wanted = list(factors)
    if not wanted:
        return []
    by_name = {function.name: function for function in functions(xml).functions}
    changes = []
    for name, value in wanted:
        function = by_name[name]
        changes.append((function.begin, function.begin, f"<product><value>{value!r}</value>".encode()))
        changes.append((function.end, function.end, b"</product>"))
    return changes
