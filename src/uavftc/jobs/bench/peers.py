"""Others on the same work: JSBSim driven through property names, and jsbgym's C172 task where it is installed."""

from __future__ import annotations

import importlib
from typing import Any

from uavftc.flight.build import build_flight
from uavftc.jobs.bench.flights import jsbsim_plant, scenario
from uavftc.jobs.bench.loop import AIRCRAFT, closed_loop
from uavftc.jobs.bench.measure import Figure, Job, NotMeasuredError, alternately, computed, of, ratios
from uavftc.plants.jsbsim.copy import moment_name
from uavftc.plants.jsbsim.reading import CONTACT, MORE_PROPERTIES, STATE_PROPERTIES, thrust_of

GYM_STEPS = 400  # of jsbgym's task, 12 frames each: about as many frames as scenario 3 has


def peers(rounds: int) -> dict[str, Figure]:
    """Time of each over that of our closed loop (scenario 3, recorded) a frame of the same aircraft, the C172."""
    measures = {"jsbsim_property_loop": _property_loop, "jsbgym": _jsbgym}
    figures = {}
    for name, measure in measures.items():
        try:
            figures[name] = measure(rounds)
        except (NotMeasuredError, ImportError) as reason:
            figures[name] = Figure([], reason=str(reason))
    return figures


def _ours() -> tuple[Job, int]:
    flown = scenario("scenario3", plant="jsbsim", aircraft=AIRCRAFT["c172p"])
    return closed_loop(flown, computed), flown.steps + 1


def _figure(theirs: list[float], ours: list[float], their_frames: int, frames: int, **details: Any) -> Figure:
    a, b = [s / their_frames for s in theirs], [s / frames for s in ours]
    rates = {"frames_per_s": of([1.0 / s for s in a]), "our_frames_per_s": of([1.0 / s for s in b])}
    return Figure(ratios(a, b), {**rates, **details})


def _property_loop(rounds: int) -> Figure:
    """No controller: as many reads and writes by name a frame as our bridge has, then `run()`."""
    ours, frames = _ours()
    flown = scenario("scenario3", plant="jsbsim", aircraft=AIRCRAFT["c172p"])
    reads = writes = 0

    def job() -> float:
        nonlocal reads, writes
        flight = build_flight(flown)
        aircraft, fdm = flight.aircraft, jsbsim_plant(flight).fdm
        read = [*STATE_PROPERTIES, CONTACT, "fcs/throttle-pos-norm[0]", *MORE_PROPERTIES, thrust_of(0)]
        moment = f"external_reactions/{moment_name(aircraft)}"
        assert flight.model is not None
        commands = [e.command for e in flight.model.effectors] + [f"{moment}/{axis}" for axis in "lmn"]
        commands += aircraft.throttle_commands(fdm.get_propulsion().get_num_engines())
        written = [(name, fdm[name]) for name in commands]
        reads, writes = len(read), len(written)

        def frames_by_name() -> None:
            for _ in range(frames):
                for name in read:
                    fdm[name]
                for name, value in written:
                    fdm[name] = value
                fdm.run()

        return computed(frames_by_name)

    theirs, own = alternately(rounds, job, ours)
    return _figure(theirs, own, frames, frames, reads_a_frame=reads, writes_a_frame=writes)


def _jsbgym(rounds: int) -> Figure:
    """Its heading-control task with a fixed action; 12 frames of 1/60 s a step."""
    try:
        environment, tasks, aircraft = (
            importlib.import_module(f"jsbgym.{m}") for m in ("environment", "tasks", "aircraft")
        )
    except ImportError:
        raise NotMeasuredError("jsbgym is not installed (pip install jsbgym)") from None
    env = environment.NoFGJsbSimEnv(aircraft.c172, tasks.HeadingControlTask)
    action = 0.0 * env.action_space.sample()
    frames_a_step = int(env.sim_steps_per_agent_step)

    def job() -> float:
        env.reset(seed=0)

        def steps() -> None:
            for _ in range(GYM_STEPS):
                if env.step(action)[2]:
                    env.reset()

        return computed(steps)

    ours, frames = _ours()
    theirs, own = alternately(rounds, job, ours)
    per_s = of([GYM_STEPS / s for s in theirs])
    return _figure(theirs, own, GYM_STEPS * frames_a_step, frames, steps_per_s=per_s, frames_a_step=frames_a_step)
