"""The step check: how finely an aircraft must be stepped, as a property of its trim and never of a controller.

From the exact start of a flight, engines settled, the trim commands and one small smooth pulse on each controlled axis
are flown open loop at frames of h, h/2 and h/4. Compared every 5 ms are attitude, body rates, airspeed, flow angles,
propeller speed and thrust. With x_h(t) what is flown at h, and for each of these `GROUPS`

    motion  M  = max |x_h/4(t) - x_h/4(0)|, and no less than the group's floor
    first   D1 = max |x_h - x_h/2| / M
    second  D2 = max |x_h/2 - x_h/4| / M

h passes if all values are finite and in every group D1 is at most `FRACTION`, and D2 at most `RATIO` * D1 or below
`NEGLIGIBLE`. Forces are held over a frame, so what is sound converges at first order, D2 = D1 / 2. D1 alone would
accept what happens to be small and grows; D2 / D1 alone is fooled by an impulse in proportion to h, which halves too.

The frames of `engines.FRAMES_S` are tried from the longest that the engines allow until one passes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim import engines
from uavftc.plants.jsbsim.engines import has
from uavftc.plants.jsbsim.load import initialised
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.plants.jsbsim.plant import INTEGRATORS
from uavftc.plants.jsbsim.trim import Trim, start
from uavftc.plants.jsbsim.units import FT_M, LBF_N

FRACTION = 0.05
RATIO = 0.6
NEGLIGIBLE = 1e-3
FLOWN_S, PULSE_S = 2.0, 1.0
SAMPLE_S = 5e-3
SHARE = 0.05  # of the larger limit of an axis: the height of its pulse

GROUPS = ("attitude", "body rates", "airspeed", "flow angles", "propeller speed", "thrust")
FLOORS = (0.01, 0.01, 0.01, 0.01, 0.1, 0.1)
"""Least motion that counts: rad, rad/s, of the airspeed, rad, of the speed at trim, of the weight."""


class Motion(NamedTuple):
    """What was flown at one frame time."""

    groups: tuple[np.ndarray, ...]
    """Of each of `GROUPS`, shape (samples, members)."""
    weight: float
    """N."""

    @property
    def finite(self) -> bool:
        """Whether every value is."""
        return all(bool(np.all(np.isfinite(g))) for g in self.groups)

    def floors(self) -> list[float]:
        """Return the least motion that counts of each group, in its unit."""
        at = (1.0, 1.0, self.groups[2][0, 0], 1.0, float(np.max(np.abs(self.groups[4][0]), initial=0.0)), self.weight)
        return [max(f * a, 1e-9) for f, a in zip(FLOORS, at, strict=True)]


def check(aircraft: Aircraft, model: TrimmedModel) -> dict[str, Any]:
    """Return the longest frame of `engines.FRAMES_S`, from `model.frame_s` on, that passes, and how it was found.

    Returns
    -------
    frame_s, of that frame or else of the finest; passed; first_difference, second_difference and ratio, of the group
    named by `worst`, at that frame; and `tried`, the same of each frame. A difference of what is not finite is None.

    Raises
    ------
    InputError
        If the aircraft does not load.
    """
    flown: dict[float, Motion] = {}

    def at(dt: float) -> Motion:
        if dt not in flown:
            flown[dt] = fly(aircraft, model, dt)
        return flown[dt]

    tried: list[dict[str, Any]] = []
    for h in (f for f in engines.FRAMES_S if f <= model.frame_s * (1.0 + 1e-9)):
        tried.append({"frame_s": h, **judged(at, h)})
        if tried[-1]["passed"]:
            break
    return {**tried[-1], "tried": tried}


def judged(at: Callable[[float], Motion], h: float) -> dict[str, Any]:
    """Return whether h passes, with the differences of the group that is furthest from passing."""
    nothing = {"first_difference": None, "second_difference": None, "ratio": None}
    motions: list[Motion] = []
    for dt in (h, h / 2.0, h / 4.0):
        motions.append(at(dt))
        if not motions[-1].finite:
            return {"passed": False, "worst": "a value that is not finite", **nothing}
    found = []
    for i, floor in enumerate(motions[0].floors()):
        coarse, middle, fine = (m.groups[i] for m in motions)
        if fine.size:
            motion = max(float(np.max(np.abs(fine - fine[0]))), floor)
            first, second = (float(np.max(np.abs(a - b))) / motion for a, b in ((coarse, middle), (middle, fine)))
            ratio = second / first if first > 0.0 else 0.0
            converges = second < NEGLIGIBLE or ratio <= RATIO
            found.append((first <= FRACTION and converges, first, second, ratio, GROUPS[i]))
    passed, first, second, ratio, worst = max(found, key=lambda f: (not f[0], f[1]))
    differences = {"first_difference": first, "second_difference": second, "ratio": ratio}
    return {"passed": passed, "worst": worst, **differences}


def fly(aircraft: Aircraft, model: TrimmedModel, dt: float) -> Motion:
    """Fly trim and pulses open loop at frames of `dt`, s, to the end or to the first value that is not finite."""
    trim = Trim(**model.trim)
    fdm = initialised(aircraft, dt)
    start(fdm, aircraft, trim, np.zeros(3), INTEGRATORS)
    read, weight = _reader(fdm, engines.count(fdm)), engines.weight(fdm)
    size = np.array(model.mixing) @ _heights(model)
    moved = [
        (_node(fdm, e.command).set_double_value, u, e.rad_per_command, at, e.commands)
        for e, u, at in zip(model.effectors, size, trim.surfaces, strict=True)
        if u
    ]
    each = round(SAMPLE_S / dt)
    samples = [read()]
    for k in range(round(FLOWN_S / dt)):
        t = k * dt
        shape = 0.5 * (1.0 - math.cos(2.0 * math.pi * t / PULSE_S)) if t < PULSE_S else 0.0
        for write, u, per_command, at, (least, greatest) in moved:
            write(min(max(at + shape * u / per_command, least), greatest))
        fdm.run()
        if (k + 1) % each == 0:
            samples.append(read())
            if not all(map(math.isfinite, (x for group in samples[-1] for x in group))):
                break
    groups = [np.array([s[i] for s in samples]) for i in range(len(GROUPS))]
    groups[0][:, 2] = np.unwrap(groups[0][:, 2]) if np.all(np.isfinite(groups[0])) else math.nan
    return Motion(tuple(groups), weight)


def _heights(model: TrimmedModel) -> np.ndarray:
    """Return the pulse of each axis, rad, towards its larger limit, shape (3,)."""
    low, high = np.array(model.limits_rad).T
    return np.where(model.axes, SHARE * np.where(high >= -low, high, low), 0.0)


def _node(fdm: jsbsim.FGFDMExec, name: str) -> jsbsim.FGPropertyNode:
    node = fdm.get_property_manager().get_node(name)
    assert node is not None  # measured at the trim
    return node


def _reader(fdm: jsbsim.FGFDMExec, count: int) -> Callable[[], list[list[float]]]:
    """Return a function that reads all groups; SI, and rpm."""

    def named(*names: str) -> list[Callable[[], float]]:
        return [_node(fdm, name).get_double_value for name in names if has(fdm, name)]

    of = ["propulsion/engine", *(f"propulsion/engine[{i}]" for i in range(1, count))][:count]
    getters = [
        (1.0, named("attitude/phi-rad", "attitude/theta-rad", "attitude/psi-rad")),
        (1.0, named("velocities/p-rad_sec", "velocities/q-rad_sec", "velocities/r-rad_sec")),
        (FT_M, named("velocities/vt-fps")),
        (1.0, named("aero/alpha-rad", "aero/beta-rad")),
        (1.0, named(*(f"{e}/propeller-rpm" for e in of))),
        (LBF_N, named(*(f"{e}/thrust-lbs" for e in of))),
    ]
    return lambda: [[unit * get() for get in group] for unit, group in getters]
