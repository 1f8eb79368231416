"""A hardover: on [start_s, end_s) the surface runs to its stop, or to `to_deg`, and stays there.

    total deflection = total deflection before + rate (n dt)      until it is there

n counts the plant steps dt since the first one of the window; at that one the surface is where it was. Without a rate
it is there at once. Memory: as of a stuck surface; from the first sample at or after `end_s` it does as commanded.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, beyond_stops, put, struck
from uavftc.config.values import Number, Problem
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s; one that never comes for the other surfaces
        ("end", "f8"),  # s
        ("step", "f8"),  # rad a plant step, >= 0; infinite: at once
        ("to", "f8"),  # rad, about trim
    ]
)
STATE = np.dtype(
    [
        ("held", "f8"),  # rad, about trim
        ("n", "f8"),  # plant steps since the window began
        ("most", "f8"),  # rad, how far it moved the surface
    ]
)


class Config(SurfaceFault):
    """A surface that runs to a stop on [start_s, end_s)."""

    kind: Literal["hardover"] = "hardover"
    """runs to its stop, or to `to_deg`, and stays there"""
    rate_degps: Number | None = None
    """how fast it runs; its sign says to which stop where `to_deg` is left out; `null`: at once, to the upper stop"""
    to_deg: Number | None = None
    """total deflection at which it ends, as the aircraft counts it; `null` is the mechanical stop"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return "hardover" if self.to_deg is None else f"hardover to {self.to_deg:g} deg"


@law
def step(p, s, e, row):
    """Run towards the end inside the window, and remember the deflection outside."""
    if p.start <= row.t < p.end:
        left = p.to - s.held
        way = abs(left) if p.step == np.inf else min(s.n * p.step, abs(left))
        put(s, e, p.to if way == abs(left) else s.held + (way if left > 0.0 else -way))
        s.n += 1.0
    else:
        s.held = e.deflection
        s.n = 0.0


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def ends(entry: Config, given: Given) -> np.ndarray:
    """Return where the fault takes each effector, about trim, shape (n,), rad; infinite where there is no stop."""
    hit = struck(entry, given)
    if entry.to_deg is not None:
        return hit.scale * np.radians(entry.to_deg) - hit.trim
    up = hit.scale * (1.0 if entry.rate_degps is None else entry.rate_degps) >= 0.0
    return np.where(up, given.stops_rad[:, 1], given.stops_rad[:, 0])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault."""
    found = []
    for i, entry in enumerate(config):
        hit, to = struck(entry, given), ends(entry, given)
        n = len(to)
        rate = np.inf if entry.rate_degps is None else abs(np.radians(entry.rate_degps))
        scale = np.abs(np.where(hit.scale == 0.0, 1.0, hit.scale))
        to = np.where(np.isfinite(hit.start), to, 0.0)
        params = records_of(PARAMS, n, start=hit.start, end=hit.end, step=rate * scale * given.plant_step, to=to)
        found.append(stage.block(params, name=f"hardover {i}"))
    return found


def problems(entry: Config, given: Given) -> list[Problem]:
    """Return what cannot be flown: no rate at all, or no stop to run to."""
    if entry.rate_degps == 0.0:
        return [
            Problem(("rate_degps",), "0", "a rate other than 0", "leave it out for a surface that is there at once")
        ]
    members = list(given.targets[entry.surface])
    if np.isfinite(ends(entry, given)[members]).all():
        return []
    return [Problem(("to_deg",), "nothing", f"to_deg, because {entry.surface} has no mechanical stop", "give to_deg")]


def remarks(entry: Config, given: Given) -> list[tuple[str, str]]:
    """Return (key, line) where the end is beyond a stop."""
    return [] if entry.to_deg is None else beyond_stops(entry, given, "to_deg", entry.to_deg)


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return it with each surface where it has run to at the time."""
    for entry in acting(config, rest.t):
        hit, start, to = struck(entry, given), rest.before(entry.start_s), ends(entry, given)
        if entry.rate_degps is not None:
            way = np.abs(hit.scale * np.radians(entry.rate_degps)) * (rest.t - entry.start_s)
            to = start + np.clip(to - start, -way, way)
        reach = reach.put(np.isfinite(hit.start), to)
    return [reach]
