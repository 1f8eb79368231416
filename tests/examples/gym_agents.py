"""Two agents of docs/gym.md: one that acts at random, and a rate loop of three gains; each flies one case.

python tests/examples/gym_agents.py
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

import uavftc.gym  # registers the environments

Agent = Callable[[np.ndarray], np.ndarray]

GAINS = np.array([20.0, 27.0, 30.0], np.float32)  # limits per rad/s: 20 1/s over B_m, over limits of 0.1 rad


def scripted(observation: np.ndarray) -> np.ndarray:
    """Command in proportion to the difference of commanded and measured body rates."""
    rates, commanded = observation[5:8], observation[8:11]
    return np.clip(GAINS * (commanded - rates), -1.0, 1.0)


def episode(env: gymnasium.Env[Any, Any], agent: Agent, case: int) -> tuple[float, dict[str, Any]]:
    """Return the sum of rewards of one case, and the verdict."""
    observation, _ = env.reset(seed=case, options={"case": case})
    total = 0.0
    while True:
        observation, reward, terminated, truncated, info = env.step(agent(observation))
        total += float(reward)
        if terminated or truncated:
            return total, info["verdict"]


def main() -> None:
    """Fly both."""
    env = gymnasium.make(uavftc.gym.ID, campaign="paper-faults")
    env.action_space.seed(0)
    agents: dict[str, Agent] = {"random": lambda observation: env.action_space.sample(), "scripted": scripted}
    for name, agent in agents.items():
        total, verdict = episode(env, agent, case=17)
        print(f"{name:9s} return {total:6.3f}   {verdict['outcome']}, margin {verdict['margin']:.3f}")


if __name__ == "__main__":
    main()
