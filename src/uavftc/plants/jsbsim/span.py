"""The wing span of an aircraft, as its files say it."""

from __future__ import annotations

import contextlib

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim.controls_xml import sections
from uavftc.plants.jsbsim.units import FT_M, IN_M

METRES = {"M": 1.0, "FT": FT_M, "IN": IN_M}


def span(aircraft: Aircraft) -> float | None:
    """Return the wing span, m, of the companion file, the XML or a file that it includes; None where there is none."""
    if aircraft.mass_properties is not None:
        return aircraft.mass_properties.span_m
    for section in sections(aircraft, ("metrics",)):
        element = section.find("wingspan")
        if element is not None and element.text:
            with contextlib.suppress(ValueError):
                return float(element.text) * METRES.get(element.get("unit", "FT").upper(), 1.0) or None
    return None
