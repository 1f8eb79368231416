"""The effectors of an aircraft for reading: range, share of each axis, effect and servo, a line each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from uavftc.aircraft.effectors import servo_text
from uavftc.core.signals import AXES, SURFACES

CLOSE = 0.05  # of 1: a full response nearer than this to what the slope gives is not worth a word


def has_table(effectors: Sequence[Mapping[str, Any]]) -> bool:
    """Whether there is more to say than that each axis has its surface."""
    return not {e["name"] for e in effectors} <= set(SURFACES)


def servo_lines(effectors: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return one line for each servo of the XML, with the effectors that have it."""
    found: dict[str, list[str]] = {}
    for e in effectors:
        if text := servo_text(e["servo"]):
            found.setdefault(text, []).append(e["name"])
    everywhere = len(found) == 1 and len(next(iter(found.values()))) == len(effectors)
    return [f"servo: {text} ({'all' if everywhere else ', '.join(names)})" for text, names in found.items()]


def full_lines(effectors: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a line for each effector whose full command does less or more than its slope says."""
    found = []
    for e in effectors:
        if any(abs(part - 1.0) > CLOSE for part in e["full_response"]):
            low, high = (f"{part:.2f}" for part in e["full_response"])
            found.append(f"{e['name']}: full command does {low} and {high} of what its slope in the small gives")
    return found


def rows(effectors: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return (name, limits about trim [deg], weight in roll, pitch, yaw, effect on p, q, r [1/s^2]) of each."""
    largest = {rate: max(abs(e["B"][f"{rate}_dot"]) for e in effectors) for rate in "pqr"}
    return [
        (
            e["name"],
            " .. ".join(f"{math.degrees(limit):.1f}" for limit in e["limits_rad"]),
            *(weight_text(e["per_axis_command"][axis]) for axis in AXES),
            *(effect_text(e["B"][f"{rate}_dot"], largest[rate]) for rate in "pqr"),
        )
        for e in effectors
    ]


def weight_text(weight: float) -> str:
    """Return a weight with two decimals at most, and a dash for none."""
    return "-" if abs(weight) < 5e-3 else f"{weight:.2f}".rstrip("0").rstrip(".")


def effect_text(value: float, largest: float) -> str:
    """Return an effect with three digits, and 0 where it is below a thousandth of the largest about its axis."""
    return "0" if abs(value) <= 1e-3 * largest else f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"
