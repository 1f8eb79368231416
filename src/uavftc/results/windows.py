"""What happens in a flight, and when: one list of windows, from the scenario, drawn in every figure of the flight."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, NamedTuple

import numpy as np

from uavftc.config.explain import apart
from uavftc.config.labels import each
from uavftc.config.values import Signal
from uavftc.core.layout import Layout
from uavftc.core.signals import ANGLES, AXES, RATES, SURFACES
from uavftc.scenario.checks import damage_of, entries
from uavftc.scenario.schema import Scenario
from uavftc.sensors import CHAIN as SENSORS

Kind = Literal["fault", "engine", "damage", "air", "disturbance", "sensor"]

VEHICLE = frozenset((*ANGLES, *RATES, *(f"f_{rate}" for rate in RATES), "airspeed", "altitude", "alpha", "beta"))
"""The signals of all of the vehicle, as `FlightWindow.concerns` names them."""

ENGINE = frozenset({"throttle", "airspeed", "altitude"})


class FlightWindow(NamedTuple):
    """Something that acts on [start_s, end_s), s; it may reach past the end of the flight."""

    kind: Kind
    what: str
    """On what it acts: `left aileron`, `engine 1`, `roll gyro`; empty where the label says it."""
    label: str
    """What it is, as its entry in the scenario says it; may have several lines."""
    start_s: float
    end_s: float
    concerns: frozenset[str] = frozenset()
    """The signals whose panels show it: angles (`phi`), rates (`p`), estimates (`d1_phi`, `f_p`), surfaces and
    effectors by name, `throttle`, `airspeed`, `altitude`, `alpha`, `beta`, `wind`."""
    known_from_s: float | None = None
    """When the controller is told of it; None where it never is."""
    known_until_s: float | None = None
    """Until when the controller takes it to last; None where it is never told."""

    @property
    def name(self) -> str:
        """What a list of windows calls it, in one line."""
        label = self.label.replace("\n", ", ")
        return f"{self.what}: {label}" if self.what else label


def windows_of(scenario: Scenario, layout: Layout) -> tuple[FlightWindow, ...]:
    """Return everything that happens in a flight, in the order in which it begins; what comes after its end is none.

    Errors of the sensors that last all flight are among it, with no signal that they concern: a panel that is shaded
    from end to end says nothing.
    """
    found = [*_entries(scenario, layout), *_damage(scenario, layout), *_lasting(scenario)]
    return tuple(sorted((w for w in found if w.start_s < scenario.duration_s), key=lambda w: w.start_s))


def _entries(scenario: Scenario, layout: Layout) -> Iterator[FlightWindow]:
    """Yield the faults, disturbances and windows of sensors."""
    for key, effect, entry in entries(scenario):
        span = entry.start_s, _end(entry.end_s, scenario)
        if key[0] == "faults":
            known = entry.known_from_s, None if entry.known_from_s is None else _end(entry.known_until_s, scenario)
            if hasattr(entry, "surface"):
                what, concerns = entry.surface, _served(layout, entry.surface)
                yield FlightWindow("fault", what.replace("_", " "), entry.label, *span, concerns, *known)
            else:
                name = f"engine {entry.engine}" if isinstance(entry.engine, int) else entry.engine.replace("_", " ")
                yield FlightWindow(
                    "engine", name, entry.label, *span, frozenset({"throttle", "airspeed", "altitude"}), *known
                )
        elif key[0] == "sensors":
            sensor = str(key[1]).partition("_")[0]
            signals = ANGLES if sensor == "attitude" else RATES
            axes = AXES if entry.axis is None else (entry.axis,)
            what = sensor if entry.axis is None else f"{entry.axis} {sensor}"
            places = [AXES.index(axis) for axis in axes]
            estimated = [f"d1_{ANGLES[i]}" for i in places] if sensor == "gyro" else []
            concerns = frozenset((*(signals[i] for i in places), *estimated))
            yield FlightWindow("sensor", what, entry.label, *span, concerns)
        elif "wind_n" in effect.FIELDS:
            yield FlightWindow("air", "", entry.label, *span, VEHICLE | {"wind"})
        else:
            yield FlightWindow("disturbance", "disturbance", entry.label, *span, frozenset(_disturbed(entry)))


def _damage(scenario: Scenario, layout: Layout) -> Iterator[FlightWindow]:
    for _, entry in damage_of(scenario):
        served = (_served(layout, name) for name in entry.control_power)
        concerns = frozenset().union(*served, VEHICLE if entry.changes_mass or entry.acts else ())
        yield FlightWindow("damage", "damage", entry.label, entry.start_s, _end(entry.end_s, scenario), concerns)


def _lasting(scenario: Scenario) -> Iterator[FlightWindow]:
    """Yield the errors of the sensors that have no window."""
    for effect in SENSORS:
        for key, field in effect.Config.model_fields.items() if hasattr(effect, "Config") else ():
            value = getattr(scenario.sensors, key)
            if value != field.default and value and isinstance(value[0], float):
                name, unit = apart(key)
                sensor, _, error = name.partition("_")
                label = f"{error.replace('_', ' ')} {each(value, unit)}"
                yield FlightWindow("sensor", sensor, label, 0.0, scenario.duration_s)


def _served(layout: Layout, name: str) -> frozenset[str]:
    """Return what a surface or gang concerns: its effectors, and the surface, angle, rate and estimate of each axis."""
    members = list(layout.targets.get(name, ()))
    served = [i for i in range(3) if np.any(layout.mixing[members, i])]
    of_axes = (f"{part}" for i in served for part in (SURFACES[i], ANGLES[i], RATES[i], f"f_{RATES[i]}"))
    return frozenset((*(layout.names[j] for j in members), *of_axes))


def _disturbed(entry: Any) -> Iterator[str]:
    """Yield the estimates that a disturbance of angles or rates concerns."""
    for key in type(entry).model_fields:
        value = getattr(entry, key)
        if isinstance(value, Signal) and value.written not in (0, "0"):
            axis = key.partition("_")[0]
            yield f"d1_{axis}" if axis in ANGLES else f"f_{axis}"


def _end(end_s: float | None, scenario: Scenario) -> float:
    return scenario.duration_s if end_s is None else end_s
