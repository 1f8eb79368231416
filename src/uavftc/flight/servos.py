"""The servos of a flight: those that the aircraft has by itself, and those that the scenario gives.

What the XML of an aircraft has is not doubled. The common keys of `actuators` leave out an effector with a servo of
its own, on JSBSim, where that acts; a warning says so, with what the model has. Keys under the name of such an
effector, or of its gang, are a wish for both: they act ahead of the aircraft's own servo, and a warning says that. The
analytic plant has no servos but the scenario's.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uavftc.actuators import lag
from uavftc.aircraft.effectors import servo_text
from uavftc.core.given import Given
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.scenario.schema import Scenario


def own_servos(scenario: Scenario, model: TrimmedModel | None) -> tuple[Mapping[str, float], ...]:
    """Return what the servo of each effector in the XML does, in the terms of `aircraft.effectors.SERVO`."""
    if model is None or scenario.plant != "jsbsim":
        return ()
    return tuple(effector.servo for effector in model.effectors)


def acting(scenario: Scenario, model: TrimmedModel | None) -> Scenario:
    """Return the scenario without the common keys where they act on nothing: each effector has the aircraft's servo."""
    own = own_servos(scenario, model)
    if not own or not all(own):
        return scenario
    config = scenario.actuators
    ideal = {key: field.default for key, field in type(config).model_fields.items()}
    return scenario.model_copy(update={"actuators": config.model_copy(update=ideal)})


def published(config: Any, given: Given) -> tuple[str, ...]:
    """Return the effectors whose servo has a place of its own in the history."""
    acts = lag.acts_on(config, given)
    return tuple(name for name, does in zip(given.effectors, acts, strict=True) if does)


def remarks(scenario: Scenario, given: Given) -> list[str]:
    """Return what a user of `actuators` should know of the aircraft's own servos, one line each."""
    config = scenario.actuators
    named = config.named()
    default = {key: field.default for key, field in type(config).model_fields.items()}
    common = any(getattr(config, key) != value for key, value in default.items())
    left: dict[str, list[str]] = {}
    both: dict[tuple[str, str], list[str]] = {}
    for name, servo in zip(given.effectors, given.servos, strict=False):
        if not (text := servo_text(servo)):
            continue
        gang = next((gang for gang, members in given.gangs.items() if name in members and gang in named), None)
        key = name if name in named else gang
        if key is not None:
            if named[key] is not None:
                both.setdefault((key, text), []).append(name)
        elif common:
            left.setdefault(text, []).append(name)
    return [
        *(f"actuators: {', '.join(names)} of {scenario.aircraft} {_have(names)} of {_own(names)} own ({text}), so the "
          f"common keys leave {'them' if len(names) > 1 else 'it'} out" for text, names in left.items()),
        *(f"actuators.{key}: {', '.join(names)} of {scenario.aircraft} {_have(names)} of {_own(names)} own ({text}), "
          f"and what is given here acts ahead: both act" for (key, text), names in both.items()),
    ]  # fmt: skip


def _have(names: list[str]) -> str:
    return "have servos" if len(names) > 1 else "has a servo"


def _own(names: list[str]) -> str:
    return "their" if len(names) > 1 else "its"
