"""Agent steps per second of the environment next to jsbgym's, on the same aircraft at the same rate of JSBSim.

    python tools/gym_speed.py --jsbgym /tmp/jsbgym/bin/python

`--jsbgym` is the Python of an environment with jsbgym (pip install jsbgym) in it; left out, only ours is measured. Both
fly a Cessna 172 in frames of 1/60 s with actions of zero, resets apart, the agent at 60 Hz (a step a frame) and at 5 Hz
(a step twelve frames, jsbgym's default). Rounds alternate, and the best of each counts: the one least disturbed. Bare
JSBSim is what no environment can be faster than. Times are of the processor, so that other processes count little.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys

FRAMES_HZ = 60
AGENTS_HZ = (60, 5)
SECONDS = 20  # of flight in a round
ROUNDS = 3

JSBGYM = """
import json, sys, time, warnings
warnings.simplefilter("ignore")
import numpy as np
from jsbgym.aircraft import c172
from jsbgym.environment import JsbSimEnv
from jsbgym.tasks import HeadingControlTask, Shaping
hz, steps = int(sys.argv[1]), int(sys.argv[2])
env = JsbSimEnv(c172, HeadingControlTask, hz, Shaping.STANDARD)
action = np.zeros(env.action_space.shape)
env.reset(seed=0)
done, spent = 0, 0.0
while done < steps:
    started = time.process_time()
    result = env.step(action)
    spent += time.process_time() - started
    done += 1
    if result[2] or result[3]:
        env.reset()
print("us", json.dumps(1e6 * spent / steps))
"""


def ours(hz: int, plant: str) -> dict[str, float]:
    """Return the processor time of a step of ours and of a bare frame, us."""
    import time

    import numpy as np

    from uavftc.gym.env import FaultTolerantAttitude

    changed = {"controller.rate_hz": FRAMES_HZ, "simulation.substeps": 1, "saturation": None, "duration_s": SECONDS + 5}
    env = FaultTolerantAttitude(
        scenario="scenario1", mode="assist", hold=FRAMES_HZ // hz, plant=plant, aircraft="jsbsim:c172p", set=changed
    )
    env.reset(seed=0)
    zero = np.zeros(3, np.float32)
    steps, spent = SECONDS * hz, 0.0
    for _ in range(steps):
        started = time.process_time()
        result = env.step(zero)
        spent += time.process_time() - started
        if result[2] or result[3]:
            raise SystemExit("the flight ended early")
    found = {"step": 1e6 * spent / steps}
    if plant == "jsbsim":
        run, frames = env.flight.plant.fdm.run, 2000  # type: ignore[attr-defined]
        started = time.process_time()
        for _ in range(frames):
            run()
        found["frame"] = 1e6 * (time.process_time() - started) / frames
    return found


def theirs(python: str, hz: int) -> float:
    """Return the processor time of a step of jsbgym, us."""
    command = [python, "-c", JSBGYM, str(hz), str(SECONDS * hz)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    return float(json.loads(next(line for line in lines if line.startswith("us "))[3:]))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Agent steps per second next to jsbgym's.")
    parser.add_argument("--jsbgym", metavar="PYTHON", help="Python of an environment with jsbgym")
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    arguments = parser.parse_args()
    print("agent   ours    analytic   frames alone   jsbgym   ours/jsbgym   (us of processor a step)")
    for hz in AGENTS_HZ:
        rounds = []
        for _ in range(arguments.rounds):
            jsbsim, analytic = ours(hz, "jsbsim"), ours(hz, "analytic")["step"]
            other = theirs(arguments.jsbgym, hz) if arguments.jsbgym else float("nan")
            rounds.append((jsbsim["step"], analytic, jsbsim["frame"] * FRAMES_HZ / hz, other))
        step, analytic, frames, other = (min(column) for column in zip(*rounds, strict=True))
        print(f"{hz:3d} Hz {step:7.1f} {analytic:9.1f} {frames:12.1f} {other:11.1f} {other / step:10.1f}x")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
