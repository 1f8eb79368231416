"""Cases of a campaign in a worker."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.core.program import Program
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly
from uavftc.jobs.bench.measure import Figure, alternately, computed, of, ratios
from uavftc.jobs.bench.processes import python
from uavftc.jobs.campaign.cases import Cases
from uavftc.jobs.campaign.evaluate import Evaluator, Job, Plan
from uavftc.jobs.campaign.variants import variants_of
from uavftc.plants.interface import Plant
from uavftc.scenario.campaign import load_campaign
from uavftc.scenario.changed import changed
from uavftc.scenario.schema import Scenario

CASES_A_ROUND = 5
CAMPAIGN = "paper-faults"
MEMORY = """
name: memory
base: scenario1
cases: 1000
vary: {reference.phi_deg: {uniform: [1, 5]}, duration_s: {choice: [1.0]}}
plants: [analytic]
"""
SWEEP = """
import resource, sys
from uavftc.cli.app import umbrella

if __name__ == "__main__":
    umbrella(["sweep", *sys.argv[1:], "--quiet"], standalone_mode=False)
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def campaign_case_over_loop(rounds: int) -> dict[str, Figure]:
    """Cases of `paper-faults` in a worker, histories off, over the loops of their flights alone; processor time."""
    return {plant: _over_loop(plant, rounds) for plant in ("analytic", "jsbsim")}


def _over_loop(plant: str, rounds: int) -> Figure:
    overrides = [f"cases={CASES_A_ROUND}", f"plants=[{plant}]", "controllers=[nndondi-l1]"]
    campaign = load_campaign(CAMPAIGN, overrides)
    variants, cases = variants_of(campaign), list(Cases(campaign))
    evaluate = Evaluator(Plan(variants, campaign.success, "none"))

    def whole() -> float:
        return computed(lambda: [evaluate(Job(case, 0, values)) for case, values in enumerate(cases)])

    def loops() -> float:
        return sum(_loop_alone(changed(variants[0].scenario, values)) for values in cases)

    took, flown = alternately(rounds, whole, loops)
    each = 1e3 / CASES_A_ROUND
    details = {"case_ms": of([each * s for s in took]), "loop_ms": of([each * s for s in flown])}
    return Figure(ratios(took, flown), details)


def campaign_memory_growth_mb(_rounds: int) -> Figure:
    """Peak memory of the process of `uavftc sweep` with 10,000 cases above that with 1,000; flights of 1 s, one round.

    The workers' memory does not count.
    """
    if sys.platform == "win32":
        return Figure([], reason="this system does not count the peak memory of a process")
    mb = 1e-6 if sys.platform == "darwin" else 1e-3  # bytes there, kB elsewhere
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "memory.yaml"
        file.write_text(MEMORY, encoding="utf-8")
        few, many = (
            mb * float(python(SWEEP, str(file), "--set", f"cases={cases}", "--out", str(Path(folder) / str(cases))))
            for cases in (1000, 10_000)
        )
    return Figure([many - few], {"cases_10000_mb": of([many]), "cases_1000_mb": of([few])})


class _Timed:
    """A plant whose loop is timed."""

    def __init__(self, plant: Plant) -> None:
        self._plant, self.seconds = plant, 0.0

    def run(self, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        flown: list[int] = []
        self.seconds += computed(lambda: flown.append(self._plant.run(program, rows, first, last)))
        return flown[0]

    def __getattr__(self, name: str) -> Any:
        return getattr(self._plant, name)


def _loop_alone(scenario: Scenario) -> float:
    """Return the processor time of the loop of a flight, s."""
    flight = build_flight(scenario)
    plant = _Timed(flight.plant)
    fly(replace(flight, plant=plant))
    return plant.seconds
