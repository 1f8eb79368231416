"""How finely the plant steps, so that delays fall on its steps, and servos move little in one."""

from __future__ import annotations

import math

from uavftc.plants.interface import Timing
from uavftc.scenario.checks import delays, most_substeps
from uavftc.scenario.schema import Scenario

MAX_ALIGNING = 8  # how many times finer the plant may step for delays and servos
PART_OF_SERVO = 0.075  # w dt; a loop near its margin is right to some 0.1 % of its integrals then, see docs/theory.md


def timing_of(scenario: Scenario, longest_s: float = math.inf) -> Timing:
    """Return the plant's timing; its steps are at most `longest_s`, s, unless the scenario says how many there are.

    A delay of part of a sample changes the command inside a sample. Where the number of plant steps is left open, it
    is chosen such that the changes fall between two of them, and that one is at most `PART_OF_SERVO` of the time
    constant of the fastest servo, if up to MAX_ALIGNING times as many allow, and the bounds of a scenario's steps.
    """
    rate, substeps = scenario.controller.rate_hz, int(scenario.substeps)
    if scenario.simulation.substeps is not None:
        return Timing(1.0 / rate, substeps)
    substeps = max(substeps, math.ceil(1.0 / (rate * longest_s) - 1e-9))
    most = max(substeps, min(MAX_ALIGNING * substeps, most_substeps(scenario)))
    substeps = min(most, max(substeps, math.ceil(fastest_radps(scenario) / (rate * PART_OF_SERVO) - 1e-9)))
    parts = [part for _, delay_s in delays(scenario) if 1e-9 < (part := delay_s * rate % 1.0) < 1.0 - 1e-9]
    if parts:
        aligned = (n for n in range(substeps, most + 1) if all(abs(n * p - round(n * p)) < 1e-6 for p in parts))
        substeps = next(aligned, most)
    return Timing(1.0 / rate, substeps)


def fastest_radps(scenario: Scenario) -> float:
    """Return the bandwidth of the fastest servo, rad/s; 0 where there is none."""
    servos = (scenario.actuators, *scenario.actuators.named().values())
    return max(0.0 if keys is None or keys.bandwidth_radps is None else keys.bandwidth_radps for keys in servos)
