"""What is flown to reproduce section 4: the paper's cases, and the variants that explain the differences."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from uavftc.jobs.campaign.pool import Flown
from uavftc.jobs.paper import printed
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

CASES = tuple(dict.fromkeys((p.shipped, p.controller) for p in printed.tables()))
"""(shipped scenario, controller) of every flight behind Tables 2, 3 and 5."""

L1, NDI_L1, MRAC = "nndondi-l1", "ndi-l1", "nndondi-mrac"
GYRO_BIAS_DEGPS = 0.3  # a MEMS rate gyro after warm-up; large enough to see, small enough to fly
DELAYS_MS = (0.0, 2.5, 5.0, 7.5, 10.0, 15.0, 20.0, 25.0)
CLAIM_DELAY_MS = 10.0  # two samples at 200 Hz: computation and actuator of an ordinary autopilot
COARSE = tuple(round(1.0 + 0.1 * i, 2) for i in range(21))  # scales of the additive fault, first pass
RADIAN_DEG = math.degrees(1.0)
EXPLICIT_HZ = 1000.0  # rate of the explicit Euler variant: a step of 1 ms
RUDDER_CONSTANT = 0.2  # the rudder's effectiveness 0.2 t of scenario 3, read without its t
FINE_STEP, FINE_REACH = 0.01, 0.1
PRINTED_GAIN = "controller.inner.reference_gain=printed"
EXPLICIT = "controller.inner.integration=explicit"


class Key(NamedTuple):
    """Names one flight: the variant it belongs to, plant, scenario, controller, and the variant's value."""

    variant: str
    plant: str
    scenario: str
    controller: str
    value: float = 0.0


Plan = dict[Key, Scenario]
Flights = Mapping[Key, Flown]


def of_variant(flights: Flights, plant: str, variant: str, value: float = 0.0) -> dict[tuple[str, str], Flown]:
    """Return the flights of one variant and plant by (scenario, controller)."""
    return {
        (k.scenario, k.controller): flown
        for k, flown in flights.items()
        if (k.variant, k.plant, k.value) == (variant, plant, value)
    }


def _load(key: Key, overrides: Sequence[str] = ()) -> tuple[Key, Scenario]:
    return key, load_scenario(key.scenario, plant=key.plant, controller=key.controller, overrides=overrides)


def cases(plant: str) -> Plan:
    """Return the flights of the paper."""
    return dict(_load(Key("paper", plant, scenario, controller)) for scenario, controller in CASES)


def variants(plant: str) -> Plan:
    """Return the flights behind the findings, the search for the fault scale apart."""
    plan: Plan = {}

    def add(variant: str, scenario: str, controllers: Iterable[str], *overrides: str, value: float = 0.0) -> None:
        plan.update(_load(Key(variant, plant, scenario, c, value), overrides) for c in controllers)

    bias = f"sensors.gyro_bias_degps={GYRO_BIAS_DEGPS}"
    for scenario in ("scenario1", "scenario2", "scenario3"):
        add("gyro bias", scenario, (L1, NDI_L1), bias)
    for ms in DELAYS_MS:
        add("delay", "scenario2", (L1, MRAC), f"controller.delay_s={ms / 1e3!r}", value=ms)
    add("delay", "scenario3", (L1, MRAC), f"controller.delay_s={CLAIM_DELAY_MS / 1e3!r}", value=CLAIM_DELAY_MS)
    for scenario, controller in CASES:
        if controller == L1:
            add("printed gain", scenario, (L1,), PRINTED_GAIN)
    for scenario in ("scenario2", "scenario3"):
        add("explicit", scenario, (L1, MRAC), EXPLICIT, f"controller.rate_hz={EXPLICIT_HZ:g}")
    plan.update((key._replace(variant="fault in rad"), s) for key, s in scaled(plant, [RADIAN_DEG]).items())
    add("constant rudder effectiveness", "scenario3", (L1,), rudder_override(load_scenario("scenario3")))
    return plan


def rudder_fault(scenario: Scenario) -> tuple[int, Any]:
    """Return the rudder's fault of scenario 3, and its place among the faults."""
    return next((i, fault) for i, fault in enumerate(scenario.faults) if getattr(fault, "surface", "") == "rudder")


def rudder_override(scenario: Scenario) -> str:
    """Return what gives the rudder's fault a constant effectiveness."""
    return f"faults[{rudder_fault(scenario)[0]}].effectiveness={RUDDER_CONSTANT}"


def scaled(plant: str, scales: Iterable[float]) -> Plan:
    """Return scenario 3 with its additive fault multiplied by each scale (deg per printed unit)."""
    base = load_scenario("scenario3", plant=plant)
    plan: Plan = {}
    for scale in scales:
        overrides = [
            f'faults[{i}].bias_deg="{scale!r}*({fault.bias_deg.written})"'
            for i, fault in enumerate(base.faults)
            if fault.bias_deg.constant != 0.0
        ]
        plan.update([_load(Key("fault scale", plant, "scenario3", L1, scale), overrides)])
    return plan


def finer(best: float, flown: Iterable[float]) -> list[float]:
    """Return the scales of the second pass around the best of the first, without those already flown."""
    count = round(FINE_REACH / FINE_STEP)
    known = {round(s, 4) for s in flown}
    return [s for i in range(-count, count + 1) if (s := round(best + FINE_STEP * i, 4)) not in known]
