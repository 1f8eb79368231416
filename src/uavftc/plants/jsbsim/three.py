"""The effectors of a trimmed model without any: three, one an axis, that follow their commands as gains do."""

from __future__ import annotations

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import Measured
from uavftc.core.layout import OWN_GANGS
from uavftc.core.signals import SURFACES
from uavftc.plants.jsbsim.model import TrimmedModel


def three(model: TrimmedModel, aircraft: Aircraft) -> TrimmedModel:
    """Return a model that has effectors."""
    if model.effectors:
        return model
    effectors = []
    for j, (name, surface) in enumerate(zip(SURFACES, aircraft.surface_list(), strict=True)):
        rad, trim, reach = model.rad_per_command[j], model.trim["surfaces"][j], aircraft.command_limits()[j]
        measured = Measured(
            name=name,
            command=surface.command,
            position=surface.position,
            position_rad=1.0 if rad > 0.0 else -1.0,
            rad_per_command=rad,
            measured=model.measured_rad[j],
            trim_command=trim,
            trim_rad=rad * trim,
            commands=[-reach, reach],
            limits_rad=model.limits_rad[j],
            ideal=True,
            B=[row[j] for row in model.B],
            full_response=[1.0, 1.0],
            nonlinearity=model.nonlinearity[j],
            servo={},
        )
        effectors.append(measured)
    gangs = {gang: dict(members) for gang, members in OWN_GANGS.items()}
    return model._replace(effectors=effectors, mixing=np.eye(3).tolist(), gangs=gangs)
