"""The wing span of an aircraft, as its files say it."""

from __future__ import annotations

import contextlib
from xml.etree import ElementTree

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim.units import FT_M, IN_M

METRES = {"M": 1.0, "FT": FT_M, "IN": IN_M}


def span(aircraft: Aircraft) -> float | None:
    """Return the wing span, m, of the companion file or the XML; None where it has none."""
    if aircraft.mass_properties is not None:
        return aircraft.mass_properties.span_m
    with contextlib.suppress(OSError, ValueError, ElementTree.ParseError):
        element = ElementTree.parse(aircraft.xml).find("metrics/wingspan")
        if element is not None and element.text:
            return float(element.text) * METRES.get(element.get("unit", "FT").upper(), 1.0) or None
    return None
