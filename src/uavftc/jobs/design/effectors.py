"""The effectors of a trimmed aircraft as numbers: what each does, how far it goes, and what each axis asks of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavftc.core.layout import shares
from uavftc.core.signals import AXES, SURFACES
from uavftc.plants.jsbsim.model import TrimmedModel

RATES = ("p_dot", "q_dot", "r_dot")


def effector_list(model: TrimmedModel) -> list[dict[str, Any]]:
    """Return the surfaces of a trimmed model, in their order in a row; SI and radians, commands in their own units."""
    return [
        {
            "name": e.name,
            "command": e.command,
            "position": e.position,
            "trim_command": e.trim_command,
            "trim_rad": e.trim_rad,
            "commands": e.commands,
            "limits_rad": e.limits_rad,
            "rad_per_command": e.rad_per_command,
            "deflection_measured": e.measured,
            "B": dict(zip(RATES, e.B[3:], strict=True)),
            "per_axis_command": dict(zip(AXES, weights, strict=True)),
            "full_response": e.full_response,
            "nonlinearity": e.nonlinearity,
            "ideal": e.ideal,
            "servo": e.servo,
        }
        for e, weights in zip(model.effectors, model.mixing, strict=True)
    ]


def engines_section(model: TrimmedModel) -> dict[str, Any]:
    """Return the engines: names, throttle commands, how they are started, and the longest plant step they allow, s."""
    return {
        "names": list(model.engine_names) if model.engines else [],
        "throttles": list(model.trim.get("throttles", ())) if model.engines else [],
        "started": model.trim.get("way", "running") if model.engines else None,
        "frame_s": model.frame_s,
    }


def axis_deflections(model: TrimmedModel) -> np.ndarray:
    """Return what the trim gives to each axis, (3,), rad: the deflections of its effectors from neutral, shared."""
    if model.names == SURFACES:  # the commands tell: a position may have an offset of its own
        trim = model.trim
        return (np.array(trim["surfaces"]) + np.array(trim["trim_commands"])) * np.array(model.rad_per_command)
    deflections: np.ndarray = shares(np.array(model.mixing)).T @ np.array([e.trim_rad for e in model.effectors])
    return deflections
