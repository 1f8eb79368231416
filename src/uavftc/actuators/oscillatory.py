"""An oscillatory failure: on [start_s, end_s) the surface oscillates, `liquid` or `solid`.

    liquid    deflection = deflection + A sin(2 pi f n dt)      added to what is commanded
    solid     deflection = A sin(2 pi f n dt)                   in its place, about trim

n counts the plant steps dt since the first one of the window. Liquid and solid are the two that the literature on
oscillatory failures of the control surfaces of Airbus aircraft tells apart (Goupil, Oscillatory failure case detection
in the A380 electrical flight control system by analytical redundancy, Control Engineering Practice 18, 2010). No memory
beyond the window.
"""

from __future__ import annotations

from math import pi, sin
from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, put, struck
from uavftc.config.values import Number, Positive, Problem
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s; one that never comes for the other surfaces
        ("end", "f8"),  # s
        ("amplitude", "f8"),  # rad
        ("turns", "f8"),  # of the oscillation, a plant step
        ("kept", "f8"),  # 1 where the commanded deflection stays (liquid), 0 where it does not (solid)
    ]
)
STATE = np.dtype([("n", "f8"), ("most", "f8")])  # plant steps since the window began; rad, how far it moved the surface


class Config(SurfaceFault):
    """A surface that oscillates on [start_s, end_s)."""

    kind: Literal["oscillatory"] = "oscillatory"
    """oscillates, about what is commanded (`liquid`) or in its place (`solid`)"""
    amplitude_deg: Number
    """amplitude of the oscillation"""
    frequency_hz: Positive
    """its frequency, below half the rate of the plant steps"""
    mode: Literal["liquid", "solid"] = "liquid"
    """`liquid`: added to the command; `solid`: in its place, about trim"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"{self.mode} oscillation\n{self.amplitude_deg:g} deg, {self.frequency_hz:g} Hz"


@law
def step(p, s, e, row):
    """Oscillate inside the window."""
    if p.start <= row.t < p.end:
        turns = s.n * p.turns
        put(s, e, p.kept * e.deflection + p.amplitude * sin(2.0 * pi * (turns - np.floor(turns))))
        s.n += 1.0
    else:
        s.n = 0.0


stage = Stage(step, PARAMS, STATE, reads=["t", "deflection"], writes=["deflection"])


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault."""
    found = []
    for i, entry in enumerate(config):
        hit = struck(entry, given)
        n = len(hit.start)
        params = records_of(
            PARAMS,
            n,
            start=hit.start,
            end=hit.end,
            amplitude=hit.scale * np.radians(entry.amplitude_deg),
            turns=np.full(n, entry.frequency_hz * given.plant_step),
            kept=np.full(n, float(entry.mode == "liquid")),
        )
        found.append(stage.block(params, name=f"oscillatory {i}"))
    return found


def problems(entry: Config, given: Given) -> list[Problem]:
    """Return what cannot be flown: an oscillation that plant steps do not show."""
    highest = 0.5 / given.plant_step
    if entry.frequency_hz < highest:
        return []
    expected = f"below {highest:g} Hz, half the rate of the plant steps"
    return [Problem(("frequency_hz",), f"{entry.frequency_hz:g}", expected, "lower it, or raise simulation.substeps")]


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return what is reached at either end of each oscillation, as if it stayed there."""
    found = [reach]
    for entry in acting(config, rest.t):
        hit = struck(entry, given)
        ends = [sign * hit.scale * np.radians(entry.amplitude_deg) for sign in (1.0, -1.0)]
        if entry.mode == "solid":
            found = [one.put(np.isfinite(hit.start), end) for one in found for end in ends]
        else:
            found = [one.scaled(np.ones(len(end)), end) for one in found for end in ends]
    return found
