"""How finely the plant steps, so that delays fall on its steps, and servos move little in one."""

from __future__ import annotations

import math

from uavftc.actuators import lag, servo_delay
from uavftc.plants.interface import Timing
from uavftc.scenario.checks import delays, most_substeps
from uavftc.scenario.schema import Scenario

MAX_ALIGNING = 8  # how many times finer the plant may step for delays and servos
PART_OF_SERVO = 0.05  # w dt; a loop near its margin is right to some 0.1 % of its integrals then, see docs/theory.md
LONGEST_S = 0.00125  # with a servo that has a delay or a limit of its rate and no lag, or a fault that is one


def timing_of(scenario: Scenario, longest_s: float = math.inf) -> Timing:
    """Return the plant's timing; its steps are at most `longest_s`, s, unless the scenario says how many there are.

    A delay of part of a sample changes the command inside a sample. Where the number of plant steps is left open, it
    is chosen such that the changes fall between two of them, and that one is at most `PART_OF_SERVO` of the time
    constant of the fastest servo, and LONGEST_S, if up to MAX_ALIGNING times as many allow, and the bounds of a
    scenario's steps.
    """
    rate, substeps = scenario.controller.rate_hz, int(scenario.substeps)
    if scenario.simulation.substeps is not None:
        return Timing(1.0 / rate, substeps)
    substeps = max(substeps, math.ceil(1.0 / (rate * longest_s) - 1e-9))
    most = max(substeps, min(MAX_ALIGNING * substeps, most_substeps(scenario)))
    substeps = min(most, max(substeps, math.ceil(1.0 / (rate * longest_of_servos(scenario)) - 1e-9)))
    parts = [part for _, delay_s in delays(scenario) if 1e-9 < (part := delay_s * rate % 1.0) < 1.0 - 1e-9]
    if parts:
        aligned = (n for n in range(substeps, most + 1) if all(abs(n * p - round(n * p)) < 1e-6 for p in parts))
        substeps = next(aligned, most)
    return Timing(1.0 / rate, substeps)


def longest_of_servos(scenario: Scenario) -> float:
    """Return the longest plant step that resolves the servos of a scenario, s; inf where all are ideal."""
    longest = math.inf
    for keys in (scenario.actuators, *scenario.actuators.named().values()):
        if keys is None:
            continue
        if keys.bandwidth_radps is not None:
            longest = min(longest, PART_OF_SERVO / keys.bandwidth_radps)
        elif keys.delay_s > 0.0 or keys.rate_limit_degps is not None:
            longest = min(longest, LONGEST_S)
    if any(isinstance(fault, lag.FAULT | servo_delay.FAULT) for fault in scenario.faults):
        longest = min(longest, LONGEST_S)
    return longest
