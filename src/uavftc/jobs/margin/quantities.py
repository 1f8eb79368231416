"""What may be varied to find where a verdict changes: each quantity, its range, and how a scenario gets it.

delay                  delay of the loop, s                    0 to 0.5
gain                   gain of the loop, up                    1 to 100
gain_reduction         gain of the loop, down                  1 to 0.01
actuator_bandwidth     of a first-order servo, rad/s           1000 down to 1
effectiveness          of one effector or gang, all the time   1 down to 0, times that of the scenario's faults
bias                   of one effector or gang, all the time   0 to 20 deg, on top of that of the scenario's faults
gyro_noise             density, deg/s/sqrt(Hz), each axis      0 to 10
KEY                    any number of the scenario              as given, KEY=LOW..HIGH
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from uavftc.config.document import Document
from uavftc.config.explain import unit_of
from uavftc.errors import InputError
from uavftc.jobs.margin.search import scan
from uavftc.scenario.overrides import put

DELAYS_S = (0.0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5)
NOISE = (0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
BIASES_DEG = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0)

Data = dict[str, Any]
"""A scenario as plain data, as `Scenario.model_dump` gives it."""


class Quantity(NamedTuple):
    """One quantity."""

    name: str
    unit: str
    values: Sequence[float]
    """Of the scan, from where a flight should survive on."""
    put: Callable[[Document, float], None]
    """Write a value into the data of a scenario."""
    of: str | None = None
    """The effector or gang that it is of."""

    @property
    def title(self) -> str:
        """Name, and of what."""
        return self.name if self.of is None else f"{self.name} of {self.of}"


def _at(key: str) -> Callable[[Document, float], None]:
    return lambda document, value: put(document, key, value, f"{key} = {value!r}")


def _always(data: Data, surface: str, change: Callable[[Data], None]) -> None:
    """Give a surface a fault of eq. (6) all the time, together with those that it has."""
    own = [fault for fault in data["faults"] if fault.get("surface") == surface]
    windows = sorted(((fault["start_s"], fault["end_s"]) for fault in own), key=lambda window: window[0])
    faults = list(data["faults"])
    for fault in own:
        if "effectiveness" in fault:
            change(fault)
    begin: float | None = 0.0
    for start, end in [*windows, (None, None)]:
        if begin is not None and (start is None or start > begin):
            free: Data = {"surface": surface, "start_s": begin, "end_s": start, "effectiveness": 1.0, "bias_deg": 0.0}
            change(free)
            faults.append(free)
        begin = end
        if end is None:
            break
    data["faults"] = faults


def _effectiveness(surface: str) -> Callable[[Document, float], None]:
    return lambda document, value: _always(
        document.data, surface, lambda fault: fault.update(effectiveness=_times(value, fault["effectiveness"]))
    )


def _bias(surface: str) -> Callable[[Document, float], None]:
    return lambda document, value: _always(
        document.data, surface, lambda fault: fault.update(bias_deg=_plus(value, fault["bias_deg"]))
    )


def _times(value: float, other: float | str) -> float | str:
    return f"{value!r}*({other})" if isinstance(other, str) else value * other


def _plus(value: float, other: float | str) -> float | str:
    return f"{value!r} + ({other})" if isinstance(other, str) else value + other


LOOP: Mapping[str, Quantity] = {
    one.name: one
    for one in (
        Quantity("delay", "s", DELAYS_S, _at("controller.delay_s")),
        Quantity("gain", "", scan(1.0, 100.0, steps=13), _at("controller.loop_gain")),
        Quantity("gain_reduction", "", scan(1.0, 0.01, steps=13), _at("controller.loop_gain")),
        Quantity("actuator_bandwidth", "rad/s", scan(1000.0, 1.0, steps=13), _at("actuators.bandwidth_radps")),
        Quantity("gyro_noise", "deg/s/sqrt(Hz)", NOISE, _at("sensors.gyro_noise_density_degps_per_rthz")),
    )
}
OF_EFFECTORS: Mapping[str, Callable[[str], Quantity]] = {
    "effectiveness": lambda name: Quantity("effectiveness", "", scan(1.0, 0.0, steps=11), _effectiveness(name), name),
    "bias": lambda name: Quantity("bias", "deg", BIASES_DEG, _bias(name), name),
}
NAMES = ("delay", "gain", "gain_reduction", "actuator_bandwidth", "effectiveness", "bias", "gyro_noise")
"""In the order in which they are looked for."""

_OVER = re.compile(r"\s*([^=\s]+)\s*=\s*(\S+?)\s*\.\.\s*(\S+)\s*")


def chosen(names: Sequence[str] | None, over: Sequence[str], targets: Sequence[str]) -> list[Quantity]:
    """Return the quantities that options name.

    Parameters
    ----------
    names
        Of `NAMES`, `effectiveness` and `bias` with `:EFFECTOR` behind them for one of them; None is all, or none where
        `over` has some.
    over
        KEY=LOW..HIGH each.
    targets
        Effectors and gangs of the aircraft.

    Raises
    ------
    InputError
        If one does not exist.
    """
    found: list[Quantity] = []
    for text in NAMES if names is None and not over else names or ():
        name, _, of = text.partition(":")
        if name in OF_EFFECTORS and (not of or of in targets):
            found += [OF_EFFECTORS[name](target) for target in ([of] if of else targets)]
        elif name in LOOP and not of:
            found.append(LOOP[name])
        else:
            expected = f"one of {', '.join(NAMES)}; effectiveness and bias with :NAME for one of {', '.join(targets)}"
            raise InputError(
                f"--quantity {text[:100]}", found=f"'{text[:100]}'", expected=expected, remedy="choose one"
            )
    return [*found, *(_key(text) for text in over)]


def _key(text: str) -> Quantity:
    match = _OVER.fullmatch(text)
    try:
        low, high = (float(match[2]), float(match[3])) if match else (0.0, 0.0)
    except ValueError:
        match = None
    where = f"--over {text[:100]}"
    if match is None or not abs(low) + abs(high) < float("inf"):
        remedy = "for example --over faults[0].effectiveness=1..0"
        raise InputError(where, found=f"'{text[:100]}'", expected="KEY=LOW..HIGH, two numbers", remedy=remedy)
    if low == high:
        remedy = "give two numbers, first the one at which the flight should survive"
        raise InputError(where, found="a range without width", expected="two different numbers", remedy=remedy)
    key = match[1]
    unit = unit_of(key.rpartition(".")[2])
    return Quantity(key, unit, scan(low, high), _at(key))
