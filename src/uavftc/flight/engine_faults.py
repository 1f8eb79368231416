"""The faults of engines of a scenario, as the plant takes them; and the refusal of those that it cannot have."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavftc.actuators.engine import place_of
from uavftc.config.values import Problem
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.scenario.checks import entries
from uavftc.scenario.schema import Scenario

if TYPE_CHECKING:
    from uavftc.aircraft.definition import Aircraft
    from uavftc.plants.jsbsim.engine_faults import EngineChange
    from uavftc.plants.jsbsim.events import Told


def told_of_engines(scenario: Scenario, model: TrimmedModel) -> list[Told]:
    """Return what JSBSim is told of the faults of engines; nothing in a flight without any."""
    from uavftc.plants.jsbsim.engine_faults import told  # noqa: PLC0415 - JSBSim is imported only where it flies

    changes = [change for _, change in _changes(scenario, model)]
    return [told(changes, scenario.controller.rate_hz)] if changes else []


def impossible(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel) -> list[Problem]:
    """Return the faults of engines that the aircraft cannot have, as tried at the trim.

    An engine whose throttle position is set by flight controls that run last, and one to be lost that goes on pulling.
    """
    from uavftc.plants.jsbsim.engine_faults import LOST_S, is_last, tried  # noqa: PLC0415

    found = []
    for key, fault in _changes(scenario, model):
        if not is_last(aircraft, model, fault.engine):
            what = f"flight controls of {aircraft.name} in a file of their own, which set the throttle after the fault"
            expected = "flight controls in the main file, or such as leave the throttle position to JSBSim"
            remedy = f"move <flight_control> into {aircraft.xml.name}, or leave the fault out"
            found.append(Problem((*key, "engine"), what, expected, remedy))
        elif fault.change.stopped and (seen := tried(aircraft, model, fault.engine)).after_s is None:
            name = model.engine_order[fault.engine]
            what = (
                f"{name} of {aircraft.name} pulls {seen.left_n:.4g} N after {LOST_S:g} s without throttle, fuel and "
                f"ignition, of {seen.before_n:.4g} N at the trim"
            )
            remedy = "write kind: reduced, or kind: stuck with the throttle at which it stays"
            found.append(Problem((*key, "kind"), what, "an engine whose thrust ends", remedy))
    return found


def _changes(scenario: Scenario, model: TrimmedModel) -> list[tuple[tuple[str | int, ...], EngineChange]]:
    """Return the key and the change of each fault of an engine."""
    from uavftc.plants.jsbsim.engine_faults import EngineChange  # noqa: PLC0415

    found = []
    for key, effect, entry in entries(scenario):
        if hasattr(effect, "change"):
            place = place_of(entry.engine, model.engine_order)
            assert place is not None  # `named.refuse_unknown` has looked
            found.append((key, EngineChange(place, effect.change(entry), entry.start_s, entry.end_s)))
    return found
