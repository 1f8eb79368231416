"""What the XML says of an aircraft's flight controls: properties read by nothing's output, and servos.

Read for discovery only; what counts is measured on the loaded aircraft.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import is_property

Element = ElementTree.Element

CONTROLS = ("flight_control", "autopilot", "system")
READS = ("input", "property", "p", "independentVar", "trigger")
SERVO = {"lag": "lag_radps", "delay": "delay_s", "hysteresis_width": "backlash_rad", "rate_limit": "rate_radps"}
LOOK_BACK = 4  # components from a position to its actuator, at most


def sections(aircraft: Aircraft, tags: tuple[str, ...]) -> Iterator[Element]:
    """Yield the sections of the aircraft with these tags, from its XML and from the files that it includes."""
    try:
        root = ElementTree.parse(aircraft.xml).getroot()
    except (OSError, ElementTree.ParseError):
        return
    for element in root:
        if element.tag not in tags:
            continue
        yield element
        if (name := element.get("file")) is not None and (path := _included(aircraft, name)) is not None:
            try:
                yield ElementTree.parse(path).getroot()
            except (OSError, ElementTree.ParseError):
                continue


def _included(aircraft: Aircraft, name: str) -> Path | None:
    folders = (aircraft.folder, aircraft.folder / "Systems", aircraft.folder / "systems", aircraft.systems_dir)
    names = (name, f"{name}.xml")
    return next((f / n for f in folders for n in names if (f / n).is_file()), None)


def bare(text: str | None) -> str:
    """Return the property that a text names, without its sign; empty where it names none."""
    name = (text or "").strip().lstrip("-+")
    return name if is_property(name) and not re.fullmatch(r"[0-9.eE+-]+", name) else ""


def components(aircraft: Aircraft) -> list[Element]:
    """Return the components of all channels: summers, gains, actuators and so on."""
    return [
        component
        for section in sections(aircraft, CONTROLS)
        for channel in section.iter("channel")
        for component in channel
        if component.tag not in ("property", "description", "documentation")
    ]


def outputs(component: Element) -> list[str]:
    """Return the properties that a component writes: its outputs, and the one of its name."""
    found = [bare(e.text) for e in component.findall("output")]
    name = component.get("name", "")
    own = name if "/" in name else "fcs/" + re.sub(r"\s+", "-", name.strip().lower())
    return [p for p in (*found, bare(own)) if p]


def inputs(component: Element) -> list[str]:
    """Return the properties that a component reads."""
    found = [bare(e.text) for e in component.iter() if e.tag in READS]
    for test in component.iter("test"):
        words = (test.text or "").split()
        found += [bare(word) for word in words[::3]]
    return [p for p in found if p]


def unwritten(aircraft: Aircraft) -> list[str]:
    """Return the properties that the flight controls and the aerodynamics read and nothing in the XML writes."""
    parts = components(aircraft)
    written = {name for part in parts for name in outputs(part)}
    written |= {
        bare(f.get("name")) for s in sections(aircraft, (*CONTROLS, "aerodynamics")) for f in s.iter("function")
    }
    read = [name for part in parts for name in inputs(part)]
    for section in sections(aircraft, ("aerodynamics",)):
        read += [name for name in (bare(e.text) for e in section.iter() if e.tag in READS) if name.startswith("fcs/")]
    return [name for name in dict.fromkeys(read) if name not in written]


def aerodynamic_inputs(aircraft: Aircraft) -> list[str]:
    """Return the properties that aerodynamics and its functions read, in the order of the XML."""
    found = [bare(e.text) for s in sections(aircraft, ("aerodynamics", "external_reactions")) for e in s.iter()
             if e.tag in READS]  # fmt: skip
    return [name for name in dict.fromkeys(found) if name]


def servo(aircraft: Aircraft, position: str | None) -> dict[str, float]:
    """Return what the actuator before a position does, in `SERVO`'s terms; empty where there is none."""
    parts = {name: part for part in components(aircraft) for name in outputs(part)}
    for _ in range(LOOK_BACK):
        part = parts.get(position or "")
        if part is None:
            return {}
        if part.tag == "actuator":
            return _servo(part)
        read = inputs(part)
        position = read[0] if len(read) == 1 else None
    return {}


def _servo(actuator: Element) -> dict[str, float]:
    found = {}
    for tag, name in SERVO.items():
        element = actuator.find(tag)
        try:
            value = float(element.text or "") if element is not None else 0.0
        except ValueError:  # a property: it is known in flight only
            continue
        if element is not None and tag == "delay" and element.get("type") == "frames":
            continue
        if value > 0.0:
            found[name] = value
    return found
