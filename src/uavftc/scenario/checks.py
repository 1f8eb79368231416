"""What concerns several keys of a scenario at once: sampling, windows, the plant's abilities; and the warnings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from uavftc.config.values import Problem, Signal, key_text
from uavftc.control.inner.matrices import is_hurwitz
from uavftc.scenario.controllers import Controller
from uavftc.scenario.disturbances import AIR, AttitudeRate, Gust, Window

if TYPE_CHECKING:
    from uavftc.scenario.schema import Fault, Scenario

MAX_SAMPLES = 20_000_000
WHOLE = 1e-9  # relative; how near duration_s * rate_hz must be to a whole number
_CHUNK = 1_000_000  # samples checked at once, to bound the memory


def problems(scenario: Scenario) -> list[Problem]:
    """Return everything that is wrong with the combination of values; empty if the scenario can be flown."""
    found = _sampling(scenario)
    signals = [] if found else [p for s in _signals(scenario) for p in _finite(scenario, *s)]
    return [*found, *signals, *_overlaps(scenario), *_plant(scenario)]


def warnings(scenario: Scenario) -> list[str]:
    """Return what is allowed and worth knowing, one readable line each."""
    lines = []
    for i, fault in enumerate(scenario.faults):
        key = ("faults", i, "effectiveness")
        peak = max((float(v.max()) for _, v in _samples(scenario, fault, fault.effectiveness)), default=0.0)
        if peak > 1:
            lines.append(
                f"{key_text(key)}: {_shown(fault.effectiveness)} reaches {peak:.3g} on {_window(scenario, fault)}; "
                f"over 1 the {fault.surface} does more than it is told, flown as written"
            )
    for section in ("faults", "disturbances"):
        for i, item in enumerate(getattr(scenario, section)):
            if item.start_s > scenario.duration_s:
                lines.append(
                    f"{section}[{i}]: starts at {item.start_s:g} s, after the end of the flight at "
                    f"{scenario.duration_s:g} s; it has no effect"
                )
    if isinstance(scenario.controller, Controller) and not is_hurwitz(np.array(scenario.controller.inner.A_m)):
        lines.append("controller.inner.A_m: not Hurwitz, the body rates are asked to follow an unstable model")
    controller = scenario.controller
    if controller.delay_s >= scenario.duration_s:
        lines.append("controller.delay_s: no shorter than the flight, so no command reaches a surface")
    if isinstance(controller, Controller) and controller.inner.integration == "explicit" and controller.rate_hz < 1000:
        lines.append("controller.inner.integration: explicit below 1000 Hz diverges; it is there to show that")
    return lines


def _sampling(scenario: Scenario) -> list[Problem]:
    rate = scenario.controller.rate_hz
    samples = scenario.duration_s * rate
    found = f"{scenario.duration_s!r} s, {samples:.10g} samples at controller.rate_hz = {rate:g}"
    if samples > MAX_SAMPLES:
        wanted = f"at most {MAX_SAMPLES} samples: {MAX_SAMPLES / rate:g} s at this rate"
        return [Problem(("duration_s",), found, wanted, "shorten the flight or lower controller.rate_hz")]
    whole = max(1, round(samples))
    if abs(samples - whole) > WHOLE * whole:
        wanted = f"a whole number of samples, at least 1; the nearest is {whole / rate!r} s ({whole} samples)"
        remedy = f"set duration_s to {whole / rate!r} or change controller.rate_hz"
        return [Problem(("duration_s",), found, wanted, remedy)]
    return []


def _signals(scenario: Scenario) -> Iterator[tuple[tuple[str | int, ...], Window, Signal]]:
    """Yield each number or expression of t with its key and the window it acts on."""
    whole = Window()
    for name in type(scenario.reference).model_fields:
        yield ("reference", name), whole, getattr(scenario.reference, name)
    for section in ("faults", "disturbances"):
        for i, item in enumerate(getattr(scenario, section)):
            for name in type(item).model_fields:
                if isinstance(value := getattr(item, name), Signal):
                    yield (section, i, name), item, value


def _samples(scenario: Scenario, window: Window, signal: Signal) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield (t, values) of `signal` at the samples of its window inside the flight, in pieces."""
    for start in range(0, scenario.steps + 1, _CHUNK):
        t = np.arange(start, min(start + _CHUNK, scenario.steps + 1)) / scenario.controller.rate_hz
        t = t[window.active(t)]
        if t.size and signal.constant is not None:
            t = t[:1]
        if t.size:
            yield t, signal.sample(t)


def _finite(scenario: Scenario, key: tuple[str | int, ...], window: Window, signal: Signal) -> list[Problem]:
    """Return the first sample at which `signal` is not finite, or an effectiveness negative."""
    effectiveness = key[-1] == "effectiveness"
    if signal.constant is not None:
        if not (effectiveness and signal.constant < 0):
            return []
        return [Problem(key, f"{signal.constant:g}", "an effectiveness >= 0", "0 is a surface without effect")]
    for t, values in _samples(scenario, window, signal):
        bad = ~np.isfinite(values) | (effectiveness & (values < 0))
        if bad.any():
            k = int(np.argmax(bad))
            found = f"{_shown(signal)}, which is {values[k]:.6g} at t = {t[k]:.10g} s"
            kind = "finite values >= 0" if effectiveness else "finite values"
            expected = f"{kind} at every sample of {_window(scenario, window)}"
            remedy = "change the expression, bound it with min and max, or move the window"
            return [Problem(key, found, expected, remedy)]
    return []


def _overlaps(scenario: Scenario) -> list[Problem]:
    found = []
    last: dict[str, tuple[int, Fault]] = {}
    for i, fault in sorted(enumerate(scenario.faults), key=lambda item: item[1].start_s):
        if fault.surface in last:
            j, earlier = last[fault.surface]
            if earlier.end_s is None or fault.start_s < earlier.end_s:
                told = (
                    f"{key_text(('faults', i))} on {_interval(fault)} overlaps "
                    f"{key_text(('faults', j))} on {_interval(earlier)}, both on the {fault.surface}"
                )
                expected = "at most one fault at a time on a surface; windows are [start_s, end_s)"
                found.append(Problem(("faults", i), told, expected, "move one of the windows, or join the two faults"))
        later = last.get(fault.surface)
        if later is None or (later[1].end_s is not None and (fault.end_s is None or fault.end_s > later[1].end_s)):
            last[fault.surface] = (i, fault)
    return found


def _plant(scenario: Scenario) -> list[Problem]:
    found = []
    for i, item in enumerate(scenario.disturbances):
        key = ("disturbances", i, "kind")
        told = f"{item.kind} on plant: {scenario.plant}"
        if scenario.plant == "analytic" and isinstance(item, AIR):
            expected = "no moving air: the analytic model is rotational only, it has no airspeed for the air to change"
            found.append(Problem(key, told, expected, "fly it with plant: jsbsim (--plant jsbsim)"))
        elif scenario.plant == "jsbsim" and isinstance(item, AttitudeRate):
            expected = "no attitude-rate: on JSBSim the kinematics are exact, d1 is a device of the analytic model"
            remedy = "use sensors.gyro_bias_degps, or plant: analytic (--plant analytic)"
            found.append(Problem(key, told, expected, remedy))
    return found


def _shown(signal: Signal) -> str:
    return str(signal.written) if signal.constant is None else f"{signal.constant:g}"


def _window(scenario: Scenario, window: Window) -> str:
    end = scenario.duration_s if window.end_s is None else min(window.end_s, scenario.duration_s)
    return f"{window.start_s:g}-{end:g} s"


def _interval(window: Window | Gust) -> str:
    return f"[{window.start_s:g}, {'end' if window.end_s is None else f'{window.end_s:g}'}) s"
