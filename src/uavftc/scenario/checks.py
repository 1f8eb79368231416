"""What concerns several keys of a scenario at once: sampling, windows, the plant's abilities; and the warnings."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from uavftc.actuators import CHAIN, ENGINES, servo_delay
from uavftc.config.effect import faults
from uavftc.config.values import AtLeast, Problem, Signal, Window, key_text, window_of
from uavftc.environment import KINDS
from uavftc.scenario import requirements
from uavftc.scenario.controllers import LOOPS, Controller
from uavftc.sensors import CHAIN as SENSORS

Scenario = Any  # of `schema.py`, which imports this file

MAX_SAMPLES = 20_000_000
MAX_SUBSTEPS = 1000  # plant steps a controller step
MAX_PLANT_STEPS = 200_000_000  # of a flight: JSBSim takes about an hour for them
MAX_DELAY_STEPS = 10_000_000  # plant steps that a command waits, 8 bytes each for every effector
MIN_JSBSIM_STEP_S = 5e-6  # s; JSBSim settles for 5 s before a flight, a million steps: some 5 s of waiting
WHOLE = 1e-9  # relative; how near duration_s * rate_hz must be to a whole number
_WHOM = {"controller": "a surface", "actuators": "its surface", "faults": "the surface in its window"}
_CHUNK = 1_000_000  # samples checked at once, to bound the memory


def problems(scenario: Scenario) -> list[Problem]:
    """Return everything that is wrong with the combination of values; empty if the scenario can be flown."""
    found = _sampling(scenario)
    signals = [] if found else [p for key, entry, s in _signals(scenario) for p in _finite(scenario, key, entry, s)]
    times = [] if found else requirements.problems(scenario)
    return [*found, *signals, *overlaps(scenario, lambda surface: (surface,)), *_plant(scenario), *times]


def warnings(scenario: Scenario) -> list[str]:
    """Return what is allowed and worth knowing, one readable line each."""
    lines = []
    times = None
    for key, effect, entry in entries(scenario):
        if hasattr(effect, "warnings"):
            times = scenario.times() if times is None else times  # once: of a long flight they are many
            found = effect.warnings(entry, times[window_of(entry, times)], _window(scenario, entry))
            lines += [f"{key_text((*key, field))}: {line}" for field, line in found]
    windows = [*((key, entry) for key, _, entry in entries(scenario)), *damage_of(scenario)]
    for key, entry in windows:
        if entry.start_s > scenario.duration_s:
            lines.append(
                f"{key_text(key)}: starts at {entry.start_s:g} s, after the end of the flight at "
                f"{scenario.duration_s:g} s; it has no effect"
            )
    lines += _told_nothing(scenario)
    controller = scenario.controller
    for loop in LOOPS if isinstance(controller, Controller) else ():
        config = getattr(controller, loop)
        found = config.warnings(controller.rate_hz) if hasattr(config, "warnings") else []
        lines += [f"controller.{loop}.{field}: {line}" for field, line in found]
    return lines + _never_arrive(scenario)


def _never_arrive(scenario: Scenario) -> list[str]:
    """Return a line for each delay that no command outlasts; what a named servo has in common with all is said once."""
    common = scenario.actuators.delay_s
    return [
        f"{key_text(key)}: no shorter than the flight, so no command reaches {_WHOM[str(key[0])]}"
        for key, delay_s in delays(scenario)
        if delay_s >= scenario.duration_s and not (key[0] == "actuators" and len(key) == 3 and delay_s == common)
    ]


def _told_nothing(scenario: Scenario) -> list[str]:
    """Return a line for each fault that says when the controller is told, and of which it never is."""
    lines = []
    for i, fault in enumerate(scenario.faults):
        told = fault.known_from_s
        if told is None and fault.known_after_s:
            lines.append(f"faults[{i}].known_after_s: without known: true the controller is told nothing")
        elif told is not None and told > scenario.duration_s >= fault.start_s:
            lines.append(
                f"faults[{i}].known_after_s: the flight ends before {told:g} s, so the controller is told nothing"
            )
    return lines


def entries(scenario: Scenario) -> Iterator[tuple[tuple[str | int, ...], Any, Any]]:
    """Yield the key, the effect and the entry of each fault, disturbance and window of a sensor, in their order."""
    for section in ("faults", "disturbances"):
        for i, entry in enumerate(getattr(scenario, section)):
            config: Any = type(entry)
            yield from (((section, i), effect, entry) for effect in _effects_of(section, config))
    for effect, name in _OF_SENSORS:
        value = getattr(scenario.sensors, name)
        windows = value if isinstance(value, tuple) and value and isinstance(value[0], Window) else ()
        yield from ((("sensors", name, i), effect, entry) for i, entry in enumerate(windows))


_OF_SENSORS = tuple(
    (effect, name) for effect in SENSORS if hasattr(effect, "Config") for name in effect.Config.model_fields
)


@functools.cache
def _effects_of(section: str, config: Any) -> tuple[Any, ...]:
    """Return the effects of an entry of this class."""
    known = faults((*CHAIN, *ENGINES)) if section == "faults" else [(kind, kind.Config) for kind in KINDS]
    return tuple(effect for effect, of in known if issubclass(config, of))


def damage_of(scenario: Scenario) -> list[tuple[tuple[str | int, ...], Any]]:
    """Return the key and the entry of each damage."""
    return [(("damage", i), entry) for i, entry in enumerate(scenario.damage)]


def _sampling(scenario: Scenario) -> list[Problem]:
    rate = scenario.controller.rate_hz
    samples = scenario.duration_s * rate
    found = f"{scenario.duration_s!r} s, {samples:.10g} samples at controller.rate_hz = {rate:g}"
    if samples > MAX_SAMPLES:
        expected = f"at most {MAX_SAMPLES} samples: {MAX_SAMPLES / rate:g} s at this rate"
        return [Problem(("duration_s",), found, expected, "shorten the flight or lower controller.rate_hz")]
    whole = max(1, round(samples))
    if abs(samples - whole) > WHOLE * whole:
        expected = f"a whole number of samples, at least 1; the nearest is {whole / rate!r} s ({whole} samples)"
        remedy = f"set duration_s to {whole / rate!r} or change controller.rate_hz"
        return [Problem(("duration_s",), found, expected, remedy)]
    return _plant_steps(scenario)


def _plant_steps(scenario: Scenario) -> list[Problem]:
    """Return what makes the plant take more steps than can be waited for, or held in memory; the first one only."""
    steps, substeps, rate = scenario.steps, scenario.substeps, scenario.controller.rate_hz
    key = ("simulation", "substeps")
    if substeps * steps > MAX_PLANT_STEPS:
        found = f"{substeps} plant steps in each of {steps} controller steps: {substeps * steps} plant steps"
        expected = f"at most {MAX_PLANT_STEPS} plant steps a flight"
        return [Problem(key, found, expected, "shorten duration_s, or lower simulation.substeps where it is given")]
    if scenario.plant == "jsbsim" and rate * substeps * MIN_JSBSIM_STEP_S > 1.0 + 1e-9:
        found = (
            f"{substeps} plant steps in each of {rate:g} controller steps a second: {1 / (rate * substeps):.3g} s each"
        )
        expected = f"plant steps of at least {MIN_JSBSIM_STEP_S:g} s on JSBSim, which settles for 5 s before a flight"
        remedy = f"lower it to {int(1 / (rate * MIN_JSBSIM_STEP_S) + 1e-9)}, or lower controller.rate_hz"
        return [Problem(key, found, expected, remedy)]
    for at, delay_s in delays(scenario):
        if (delayed := _samples_of(scenario, delay_s) * substeps) > MAX_DELAY_STEPS:
            found = f"{delay_s:g} s, {delayed:.0f} plant steps"
            expected = f"at most {MAX_DELAY_STEPS} plant steps between command and surface"
            remedy = "shorten the delay, or lower controller.rate_hz or simulation.substeps"
            return [Problem(at, found, expected, remedy)]
    return []


def most_substeps(scenario: Scenario) -> int:
    """Return how many plant steps a controller step may have within the bounds of this file."""
    bounds = [MAX_SUBSTEPS, MAX_PLANT_STEPS // max(1, scenario.steps)]
    if scenario.plant == "jsbsim":
        bounds.append(int(1 / (scenario.controller.rate_hz * MIN_JSBSIM_STEP_S) + 1e-9))
    if (delay := max(_samples_of(scenario, delay_s) for _, delay_s in delays(scenario))) > 0.0:
        bounds.append(int(min(MAX_DELAY_STEPS / delay, MAX_SUBSTEPS)))
    return min(bounds)


def delays(scenario: Scenario) -> list[tuple[tuple[str | int, ...], float]]:
    """Return each delay between command and surface, s, with its key: of the loop, of servos, with those of faults."""
    servos = {None: scenario.actuators, **scenario.actuators.named()}
    own = {name: 0.0 if keys is None else keys.delay_s for name, keys in servos.items()}
    return [
        (("controller", "delay_s"), scenario.controller.delay_s),
        *((("actuators", *(() if name is None else (name,)), "delay_s"), delay_s) for name, delay_s in own.items()),
        *(
            (("faults", i, "delay_s"), own.get(fault.surface, own[None]) + fault.delay_s)
            for i, fault in enumerate(scenario.faults)
            if isinstance(fault, servo_delay.FAULT)
        ),
    ]


def _samples_of(scenario: Scenario, delay_s: float) -> float:
    """Return how many controller steps a command waits; one longer than the flight waits as long as the flight."""
    samples: float = min(delay_s, scenario.duration_s) * scenario.controller.rate_hz
    return samples


def _signals(scenario: Scenario) -> Iterator[tuple[tuple[str | int, ...], Window, Signal]]:
    """Yield each number or expression of t with its key and the window it acts on."""
    whole = Window()
    for name in type(scenario.reference).model_fields:
        yield ("reference", name), whole, getattr(scenario.reference, name)
    for key, _, entry in entries(scenario):
        for name in type(entry).model_fields:
            if isinstance(value := getattr(entry, name), Signal):
                yield (*key, name), entry, value


def _samples(scenario: Scenario, window: Window, signal: Signal) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield (t, values) of `signal` at the samples of its window inside the flight, in pieces."""
    for start in range(0, scenario.steps + 1, _CHUNK):
        ends = window.end_s is not None and start / scenario.controller.rate_hz >= window.end_s
        if ends or (start + _CHUNK) / scenario.controller.rate_hz < window.start_s:
            continue  # no sample of these is in the window
        t = np.arange(start, min(start + _CHUNK, scenario.steps + 1)) / scenario.controller.rate_hz
        t = t[window_of(window, t)]
        if t.size and signal.constant is not None:
            t = t[:1]
        if t.size:
            yield t, signal.sample(t)


def _finite(scenario: Scenario, key: tuple[str | int, ...], entry: Any, signal: Signal) -> list[Problem]:
    """Return the first sample at which `signal` is not finite, or lower than it may be."""
    field = type(entry).model_fields.get(str(key[-1]))
    floor = next((m for m in field.metadata if isinstance(m, AtLeast)), None) if field else None
    if signal.constant is not None:
        if floor is None or signal.constant >= floor.low:
            return []
        return [Problem(key, f"{signal.constant:g}", floor.expected, floor.remedy)]
    for t, values in _samples(scenario, entry, signal):
        bad = ~np.isfinite(values) | (False if floor is None else values < floor.low)
        if bad.any():
            k = int(np.argmax(bad))
            found = f"{signal.text}, which is {values[k]:.6g} at t = {t[k]:.10g} s"
            kind = "finite values" if floor is None else f"finite values >= {floor.low:g}"
            expected = f"{kind} at every sample of {_window(scenario, entry)}"
            remedy = "change the expression, bound it with min and max, or move the window"
            return [Problem(key, found, expected, remedy)]
    return []


def overlaps(scenario: Scenario, members: Callable[[Any], Iterable[str]], key: str = "surface") -> list[Problem]:
    """Return the faults that begin while another one acts on the same effector.

    `members` of what a fault names by `key`: `surface`, or `engine`.
    """
    found = []
    last: dict[str, tuple[int, Any]] = {}
    named = [(i, fault) for i, fault in enumerate(scenario.faults) if hasattr(fault, key)]
    for i, fault in sorted(named, key=lambda item: item[1].start_s):
        reported = set()
        for name in members(getattr(fault, key)):
            j, earlier = last.get(name, (i, None))
            if earlier is not None and (earlier.end_s is None or fault.start_s < earlier.end_s) and j not in reported:
                reported.add(j)
                pair = (
                    f"{key_text(('faults', i))} on {_interval(fault)} overlaps "
                    f"{key_text(('faults', j))} on {_interval(earlier)}, both on the {name}"
                )
                one = "an engine" if key == "engine" else "a surface"
                expected = f"at most one fault at a time on {one}; windows are [start_s, end_s)"
                found.append(Problem(("faults", i), pair, expected, "move one of the windows, or join the two faults"))
            longer = earlier is None or (
                earlier.end_s is not None and (fault.end_s is None or fault.end_s > earlier.end_s)
            )
            if longer:
                last[name] = (i, fault)
    return found


def _plant(scenario: Scenario) -> list[Problem]:
    found = []
    for key, effect, entry in entries(scenario):
        if scenario.plant in (refused := getattr(effect, "REFUSED_ON", {})):
            expected, remedy = refused[scenario.plant]
            found.append(Problem((*key, "kind"), f"{entry.kind} on plant: {scenario.plant}", expected, remedy))
    return found


def _window(scenario: Scenario, window: Window) -> str:
    end = scenario.duration_s if window.end_s is None else min(window.end_s, scenario.duration_s)
    return f"{window.start_s:g}-{end:g} s"


def _interval(window: Window) -> str:
    return f"[{window.start_s:g}, {'end' if window.end_s is None else f'{window.end_s:g}'}) s"
