"""How finely the plant steps, so that a delay falls on its steps."""

from __future__ import annotations

import math

from uavftc.plants.interface import Timing
from uavftc.scenario.checks import most_substeps
from uavftc.scenario.schema import Scenario

MAX_ALIGNING = 8  # how many times finer the plant may step so that a delay falls on its steps


def timing_of(scenario: Scenario, longest_s: float = math.inf) -> Timing:
    """Return the plant's timing; its steps are at most `longest_s`, s, unless the scenario says how many there are.

    A delay of part of a sample changes the command inside a sample. Where the number of plant steps is left open, it
    is chosen such that the change falls between two of them, if up to MAX_ALIGNING times as many allow, and the bounds
    of a scenario's plant steps.
    """
    part = scenario.controller.delay_s * scenario.controller.rate_hz % 1.0
    substeps: int = scenario.substeps
    if scenario.simulation.substeps is None:
        substeps = max(substeps, math.ceil(1.0 / (scenario.controller.rate_hz * longest_s) - 1e-9))
    if 1e-9 < part < 1.0 - 1e-9 and scenario.simulation.substeps is None:
        most = max(substeps, min(MAX_ALIGNING * substeps, most_substeps(scenario)))
        aligned = (n for n in range(substeps, most + 1) if abs(n * part - round(n * part)) < 1e-6)
        substeps = next(aligned, most)
    return Timing(1.0 / scenario.controller.rate_hz, substeps)
