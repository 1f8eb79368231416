"""The closed loop: whole flights, over bare JSBSim and by themselves."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from uavftc.flight.build import build_flight
from uavftc.flight.recorder import MemoryRecorder
from uavftc.jobs.bench.flights import fly_all_of, jsbsim_plant, scenario
from uavftc.jobs.bench.measure import Figure, Job, NotMeasuredError, alternately, computed, of, ratios, timed
from uavftc.jobs.campaign.pool import fly_one
from uavftc.scenario.load import load_scenario
from uavftc.scenario.schema import Scenario

AIRCRAFT = {"hale": "hale", "c172p": "jsbsim:c172p", "737": "jsbsim:737"}
FLIGHTS_A_ROUND = 5


def closed_loop_over_bare_jsbsim(rounds: int) -> dict[str, Figure]:
    """Scenario 3 flown, every row recorded in memory, over as many bare `run()` on the same trimmed aircraft."""
    figures = {}
    for name, aircraft in AIRCRAFT.items():
        try:
            figures[name] = _over_bare(scenario("scenario3", plant="jsbsim", aircraft=aircraft), rounds)
        except NotMeasuredError as reason:
            figures[name] = Figure([], reason=str(reason))
    return figures


def _over_bare(flown: Scenario, rounds: int) -> Figure:
    rows = flown.steps + 1
    frames = rows * flown.substeps
    closed, bare = alternately(rounds, closed_loop(flown, computed), bare_jsbsim(flown, frames))
    details = {"closed_us": of([1e6 * s / rows for s in closed]), "bare_us": of([1e6 * s / rows for s in bare])}
    return Figure(ratios(closed, bare), details)


def closed_loop(flown: Scenario, clock: Callable[[Callable[[], object]], float] = timed) -> Job:
    """Return the job of flying a scenario: inputs sampled, loop, recording in memory; load and trim are not timed."""

    def job() -> float:
        flight, recorder = build_flight(flown), MemoryRecorder()
        return clock(lambda: fly_all_of(flight, recorder))

    return job


def bare_jsbsim(flown: Scenario, frames: int) -> Job:
    """Return the job of running that many frames of the scenario's aircraft from the same trim, and nothing else."""

    def job() -> float:
        run = jsbsim_plant(build_flight(flown)).fdm.run

        def frames_only() -> None:
            for _ in range(frames):
                run()

        return computed(frames_only)

    return job


def analytic_step_us(rounds: int) -> Figure:
    """One sample of the whole loop on the analytic plant, in a flight of 20 s at 200 Hz."""
    flown = scenario("scenario3", plant="analytic")
    (seconds,) = alternately(rounds, lambda: fly_all_of(build_flight(flown)))
    return Figure([1e6 * s / (flown.steps + 1) for s in seconds])


def analytic_flight_ms(rounds: int) -> Figure:
    """Scenario 3 on the analytic plant: inputs sampled, loop, every row recorded in memory."""
    (seconds,) = alternately(rounds, closed_loop(scenario("scenario3", plant="analytic")))
    return Figure([1e3 * s for s in seconds])


def margin_over_flight(rounds: int) -> dict[str, Figure]:
    """Scenario 3 with the default requirements, over the same with none: aircraft, trim, loop, metrics, no files."""

    def flights(plant: str, overrides: Sequence[str]) -> Job:
        asked = load_scenario("scenario3", plant=plant, overrides=overrides)

        def some() -> None:
            for _ in range(FLIGHTS_A_ROUND):
                fly_one(asked, keep_history=False)

        return lambda: timed(some)

    found = {}
    for plant in ("analytic", "jsbsim"):
        judged, bare = alternately(rounds, flights(plant, ()), flights(plant, ("requirements=[]",)))
        found[plant] = Figure(ratios(judged, bare))
    return found


def flights_per_second(rounds: int) -> dict[str, Figure]:
    """Scenario 3 again and again in one process: scenario read, aircraft loaded, trim, loop, metrics, no files."""

    def flights(plant: str) -> Job:
        def some() -> None:
            for _ in range(FLIGHTS_A_ROUND):
                fly_one(load_scenario("scenario3", plant=plant), keep_history=False)

        return lambda: timed(some)

    plants = ("analytic", "jsbsim")
    seconds = alternately(rounds, *map(flights, plants))
    return {p: Figure([FLIGHTS_A_ROUND / s for s in column]) for p, column in zip(plants, seconds, strict=True)}
