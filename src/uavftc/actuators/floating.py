"""A floating surface: on [start_s, end_s) it is free, and goes to an angle of the local flow.

    T y' = k flow - y,    total deflection = y

with flow the angle of attack or the sideslip at the sample, k the `ratio`, T the `time_constant_s`; exact for a flow
that is held over a plant step: y + (1 - exp(-dt / T)) (k flow - y). It begins where the surface is. Each surface of a
gang floats by itself: k counts as the position of each does. Memory: outside its window it remembers the deflection;
from the first sample at or after `end_s` the surface does as commanded.

A hinged surface without a moment about its hinge floats at -(Ch_alpha / Ch_delta) alpha (Etkin and Reid, Dynamics of
Flight, 3rd ed., section 2.6), and that is k; the hinge moments of the aircraft are not known, so it has to be given.
"""

from __future__ import annotations

from math import exp
from typing import Literal

import numpy as np

from uavftc.actuators.at_rest import Reach, Rest, acting
from uavftc.actuators.fault import SurfaceFault, put, struck
from uavftc.config.values import Number, Positive
from uavftc.core.given import Given
from uavftc.core.stage import Block, Stage, law, records_of

ENTRY_OF = "faults"
REFUSED_ON = {
    "analytic": (
        "no floating surface: the analytic model is rotational only, it has no flow",
        "fly it with plant: jsbsim (--plant jsbsim), or use kind: total-loss",
    )
}

PARAMS = np.dtype(
    [
        ("start", "f8"),  # s; one that never comes for the other surfaces
        ("end", "f8"),  # s
        ("by_alpha", "f8"),  # deflection per angle of attack
        ("by_beta", "f8"),  # deflection per sideslip
        ("share", "f8"),  # 1 - exp(-dt / T), of the way that is left
        ("trim", "f8"),  # rad
    ]
)
STATE = np.dtype([("y", "f8"), ("most", "f8")])  # rad, about trim; rad, how far it moved the surface


class Config(SurfaceFault):
    """A surface that floats on [start_s, end_s)."""

    kind: Literal["float"] = "float"
    """is free, and goes to an angle of the local flow; on JSBSim"""
    ratio: Number
    """total deflection, as the aircraft counts it, over the angle of the flow"""
    time_constant_s: Positive = 0.1
    """time constant with which it goes there"""
    flow: Literal["alpha", "beta"] | None = None
    """`alpha` or `beta`; `null` is `beta` for a surface that yaws, and `alpha` for any other"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        return f"floats, {self.ratio:g} of {self.flow or 'the flow'}"


@law
def step(p, s, e, row):
    """Move on towards the flow inside the window, and remember the deflection outside."""
    if p.start <= row.t < p.end:
        s.y += p.share * (p.by_alpha * row.alpha + p.by_beta * row.beta - p.trim - s.y)
        put(s, e, s.y)
    else:
        s.y = e.deflection


stage = Stage(step, PARAMS, STATE, reads=["t", "alpha", "beta", "deflection"], writes=["deflection"])


def by_sideslip(entry: Config, given: Given) -> np.ndarray:
    """Return whether each effector would float with the sideslip, and not with the angle of attack, shape (n,)."""
    yaws: np.ndarray = np.argmax(np.abs(given.mixing), axis=1) == 2
    return yaws if entry.flow is None else np.full(len(yaws), entry.flow == "beta")


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return a block for each fault."""
    found = []
    for i, entry in enumerate(config):
        hit = struck(entry, given)
        n = len(hit.start)
        beta = by_sideslip(entry, given)
        params = records_of(
            PARAMS,
            n,
            start=hit.start,
            end=hit.end,
            by_alpha=np.where(beta, 0.0, hit.sense * entry.ratio),
            by_beta=np.where(beta, hit.sense * entry.ratio, 0.0),
            share=np.full(n, 1.0 - exp(-given.plant_step / entry.time_constant_s)),
            trim=hit.trim,
        )
        found.append(stage.block(params, name=f"float {i}"))
    return found


def at_rest(config: tuple[Config, ...], given: Given, rest: Rest, reach: Reach) -> list[Reach]:
    """Return it with each floating surface where the flow takes it."""
    for entry in acting(config, rest.t):
        hit, beta = struck(entry, given), by_sideslip(entry, given)
        floats = np.isfinite(hit.start)
        reach = reach.put(floats, -hit.trim)
        ratio = hit.sense * entry.ratio
        reach = reach._replace(
            by_alpha=np.where(floats & ~beta, ratio, reach.by_alpha),
            by_beta=np.where(floats & beta, ratio, reach.by_beta),
        )
    return [reach]
