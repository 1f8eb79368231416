"""The copy that JSBSim loads: an aircraft's main file without anything that writes, opens or listens.

- <output> and <input> of the aircraft are taken out: files, sockets. Those of components name properties and stay.
  JSBSim reads neither in an included file. A <child>, another aircraft with outputs of its own, is refused.
- A moment input is added to an aircraft that has none, for the disturbance d2: the body moment J d2.
- Properties that nothing defines are declared, 0, where the caller says so (`load.missing`).
- What a fault of this flight needs is put at the end of a section (`Addition`), or into a new one, and a factor is put
  on an aerodynamic function (`Factor`); a flight without either has the copy that it always had.

The author's files are never touched. The copy is in the user's cache under its own checksum; whatever else the
aircraft reads, it reads from the author's folder. Lines keep their numbers.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

from uavftc.aircraft.definition import Aircraft
from uavftc.core.cache import cache_folder
from uavftc.errors import InputError
from uavftc.plants.jsbsim.functions import Factor, plain_utf8, scaled

MOMENT = "uavftc-disturbance"
_ELEMENT = f'<moment name="{MOMENT}" frame="BODY"><direction><x>1</x><y>0</y><z>0</z></direction></moment>'
_MOMENTS = "external_reactions"
_TAKEN_OUT = ("output", "input")


class Addition(NamedTuple):
    """XML put at the end of a section of the copy, behind all that the author has there."""

    section: str
    """A child of the root, such as `mass_balance`; made where there is none."""
    xml: str
    """ASCII, without a line break, so that lines keep their numbers."""


Change = Addition | Factor
"""What the copy has for one flight."""


def moment_name(aircraft: Aircraft) -> str:
    """Return the name of the moment that carries d2."""
    return aircraft.disturbance_moment or MOMENT


def copy_of(aircraft: Aircraft, declared: Sequence[str] = (), additions: Sequence[Change] = ()) -> Path:
    """Return the copy of the aircraft's main file, properties declared, additions and factors in it; made if need be.

    Raises
    ------
    InputError
        If the file cannot be read, is not well-formed, declares entities, or carries another aircraft.
    """
    try:
        copy, checksum = _edited(aircraft, aircraft.sha256(), tuple(declared), tuple(additions))
    except OSError as error:
        raise _unusable(aircraft, error.strerror or str(error), "a file that can be read") from None
    except expat.ExpatError as error:
        found = f"line {error.lineno}, malformed XML: {expat.errors.messages[error.code]}"
        raise _unusable(aircraft, found, "well-formed XML") from None
    except _RefusedError as error:
        raise _unusable(aircraft, *error.args) from None
    file = cache_folder("aircraft", checksum[:32]) / aircraft.xml.name
    if not file.is_file() or file.read_bytes() != copy:
        partial = file.with_suffix(f".{os.getpid()}")
        partial.write_bytes(copy)
        partial.replace(file)
    return file


@functools.lru_cache(maxsize=64)
def _edited(
    aircraft: Aircraft, _checksum: str, declared: tuple[str, ...], additions: tuple[Addition, ...]
) -> tuple[bytes, str]:
    """Return the copy and its checksum."""
    data = aircraft.xml.read_bytes()
    copy = edited(data, moment=aircraft.disturbance_moment is None, declared=declared, additions=additions)
    return copy, hashlib.sha256(copy).hexdigest()


def _unusable(aircraft: Aircraft, found: str, expected: str) -> InputError:
    return InputError(
        f"aircraft {aircraft.name}, {aircraft.xml}",
        found=found,
        expected=expected,
        remedy="correct the XML at the place named",
    )


def edited(xml: bytes, *, moment: bool, declared: Sequence[str] = (), additions: Sequence[Change] = ()) -> bytes:
    """Return an aircraft's XML without outputs and inputs, with a moment, properties declared, additions, factors.

    Raises
    ------
    expat.ExpatError
        If it is not well-formed.
    """
    xml = plain_utf8(xml)  # what is put in is ASCII
    sections, inside, end = _sections(xml)
    changes = scaled(xml, (change for change in additions if isinstance(change, Factor)))
    added = [change for change in additions if isinstance(change, Addition)]
    for section in sections:
        if section.tag in _TAKEN_OUT:
            changes.append((section.begin, section.end, b"\n" * xml.count(b"\n", section.begin, section.end)))
    if declared:
        lines = "".join(f'<property value="0">{name}</property>' for name in declared)
        changes.append((inside, inside, f'<system name="uavftc-declared">{lines}</system>'.encode()))
    tags = ([_MOMENTS] if moment else []) + [addition.section for addition in added]
    for tag in dict.fromkeys(tags):
        first = _ELEMENT if moment and tag == _MOMENTS else ""
        last = "".join(addition.xml for addition in added if addition.section == tag)
        changes += _put(tag, first, last, sections, end, xml)
    for begin, stop, text in sorted(changes, reverse=True):
        xml = xml[:begin] + text + xml[stop:]
    return xml


@dataclass
class _Section:
    """A child of the root: its place in the file, in bytes."""

    tag: str
    begin: int
    inside: int = -1
    """Behind its start tag."""
    close: int = -1
    """Before its end tag."""
    end: int = -1
    """Behind its end tag; `inside` of an empty tag, <tag/>."""


class _RefusedError(ValueError):
    """What was found, and what is expected."""


def _put(
    tag: str, first: str, last: str, sections: list[_Section], end: int, xml: bytes
) -> list[tuple[int, int, bytes]]:
    """Return the changes that put text at the two ends of the section that JSBSim reads, or into a new one."""
    section = next((s for s in sections if s.tag == tag), None)
    if section is None:
        return [(end, end, f"<{tag}>{first}{last}</{tag}>".encode())]
    if section.inside >= section.end:
        closed = f">{first}{last}</{tag}>".encode()
        return [(xml.rindex(b"/", section.begin, section.end), section.end, closed)]
    places = ((section.inside, first), (section.close, last))
    return [(place, place, text.encode()) for place, text in places if text]


def _sections(xml: bytes) -> tuple[list[_Section], int, int]:
    """Return the children of the root, where the root's start tag ends, and where its end tag begins."""
    parser = expat.ParserCreate()
    sections: list[_Section] = []
    root = _Section("", 0)
    depth = 0
    # an event does not say where it ends; the next one begins there
    waiting: list[tuple[_Section, str]] = []

    def event(*_: object) -> None:
        while waiting:
            section, edge = waiting.pop()
            setattr(section, edge, parser.CurrentByteIndex)

    def start(tag: str, _attributes: dict[str, str]) -> None:
        nonlocal depth
        event()
        if depth == 0:
            waiting.append((root, "inside"))
        elif depth == 1:
            if tag == "child":
                raise _RefusedError(f"line {parser.CurrentLineNumber}, <child>", "one aircraft, not a second with it")
            sections.append(_Section(tag, parser.CurrentByteIndex))
            waiting.append((sections[-1], "inside"))
        depth += 1

    def stop(_tag: str) -> None:
        nonlocal depth
        event()
        depth -= 1
        if depth == 0:
            root.end = parser.CurrentByteIndex
        elif depth == 1:
            sections[-1].close = parser.CurrentByteIndex
            waiting.append((sections[-1], "end"))

    def entity(*_: object) -> None:
        # what it stands for would be read by JSBSim, and not be seen here
        raise _RefusedError(f"line {parser.CurrentLineNumber}, <!ENTITY>", "no entities: text as it is meant")

    parser.StartElementHandler, parser.EndElementHandler = start, stop
    parser.EntityDeclHandler = entity
    parser.DefaultHandler = event  # text, comments and all the rest
    parser.Parse(xml, True)
    return sections, root.inside, root.end
