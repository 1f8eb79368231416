"""What a companion file claims of effectors, held against what they do: one that does nothing is not passed over."""

from __future__ import annotations

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.authority import RESPONSE_MIN
from uavftc.errors import InputError
from uavftc.plants.jsbsim import engines
from uavftc.plants.jsbsim.rig import Rig
from uavftc.plants.jsbsim.settle import settle

THROTTLES = (0.2, 0.7)


def check_effectors(aircraft: Aircraft, fdm: jsbsim.FGFDMExec, rig: Rig) -> None:
    """Check that each effector that is named acts; the FDM is frozen, its engines running.

    Raises
    ------
    InputError
        If a surface moves no angular acceleration, or a throttle no thrust.
    """
    if not aircraft.effectors:
        return
    full = np.max(np.abs(rig.B[3:]), axis=0) * np.max(np.abs(rig.ranges * rig.scale[:, None]), axis=1)
    dead = {name for name, response in zip(rig.surfaces, full, strict=True) if not response >= RESPONSE_MIN}
    for name, response in zip(rig.surfaces, full, strict=True):
        others = [set(members) - dead for members in rig.gangs.values() if name in members]
        if name in dead and (any(others) or not others):  # an axis of which nothing acts is refused for that
            raise _idle(aircraft, name, f"it moves nothing: {response:.2g} rad/s^2 at full command", "a surface")
    for name, throttle in aircraft.engines().items():
        pulls = []
        for value in THROTTLES:
            fdm[throttle] = value
            settle(fdm, least_s=1.0)
            pulls.append(engines.pull(fdm))
        if not abs(pulls[1] - pulls[0]) > engines.LIVE * engines.weight(fdm):
            found = f"it moves no thrust: {pulls[0]:.3g} N at {THROTTLES[0]:g} and {pulls[1]:.3g} N at {THROTTLES[1]:g}"
            raise _idle(aircraft, name, found, "an engine")


def _idle(aircraft: Aircraft, name: str, found: str, what: str) -> InputError:
    return InputError(
        f"aircraft {aircraft.name}, {aircraft.companion}, key effectors.{name}",
        found=found,
        expected=f"{what} that acts",
        remedy="correct its command, or the component of the XML that should move it, or leave it out",
    )
