"""`uavftc/FaultTolerantAttitude-v0`: an agent that commands the three axes of a flight, sample by sample.

It is the flight that `uavftc-fly` flies, its program cut in two before the agent: what a row needs before a command
runs when the sample begins, the rest when the agent has acted. One and the same laws, plant and faults, to the bit.

An episode of N samples has a return of

    1/N sum over its steps of m_k  +  margin of the verdict

m_k is the margin of the worst requirement at the sample (`reward.py`), the margin of the verdict that of
`summary.json`: at most 1, 0 at the limit of the worst requirement, -1 to -2 where the vehicle is lost. It comes with
the last step. An episode terminates where the vehicle is lost, and is truncated at the end of the flight.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

from uavftc.analysis.verdict import Verdict, verdict_of
from uavftc.control import agent as agents
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import params_of
from uavftc.errors import InputError
from uavftc.flight import envelope
from uavftc.flight.build import Flight, build_flight
from uavftc.gym import look
from uavftc.gym.draw import Draw
from uavftc.gym.reward import Margins


class FaultTolerantAttitude(gymnasium.Env[np.ndarray, np.ndarray]):
    """An agent in the loop of a flight; docs/gym.md.

    Parameters
    ----------
    campaign
        File or name of a campaign from which each episode draws its case; None and no scenario is `paper-faults`.
    scenario
        File or name of a scenario that every episode flies, in place of a campaign.
    mode
        `replace`: the action is the command, in place of the inner loop; `assist`: it is added to the controller's.
    hold
        Samples for which an action is held: the agent steps at the controller's rate over this.
    controller, plant, aircraft, set
        In place of what the scenario or campaign says; `set` by dotted key.

    Raises
    ------
    InputError
        If one of them is wrong.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": []}  # type: ignore[misc]

    def __init__(
        self,
        campaign: str | Path | None = None,
        scenario: str | Path | None = None,
        *,
        mode: str = agents.REPLACE,
        hold: int = 1,
        controller: str | None = None,
        plant: str | None = None,
        aircraft: str | None = None,
        set: Mapping[str, Any] | None = None,
        render_mode: str | None = None,
    ) -> None:
        if mode not in agents.MODES:
            raise InputError("mode", found=repr(mode)[:60], expected="replace or assist", remedy="name one of them")
        if not (isinstance(hold, int) and hold >= 1):
            expected = "a whole number of samples, 1 or more"
            raise InputError("hold", found=repr(hold)[:60], expected=expected, remedy="write hold=1")
        named = "paper-faults" if campaign is None and scenario is None else campaign
        self._draw = Draw(named, scenario, controller=controller, plant=plant, aircraft=aircraft, set=set)
        self._mode, self._hold = mode, hold
        self.render_mode = render_mode
        self.action_space = spaces.Box(-1.0, 1.0, (3,), np.float32)
        bounds = look.BOUNDS.astype(np.float32)
        self.observation_space = spaces.Box(-bounds, bounds, dtype=np.float32)
        self._bounds = bounds
        self._k, self._end = 0, -1

    @property
    def flight(self) -> Flight:
        """The flight of the episode.

        Raises
        ------
        AttributeError
            Before the first `reset`.
        """
        return self._flight

    @property
    def records(self) -> np.ndarray:
        """The rows of the episode so far, dtype `signals.row_type`, as `fly_to_memory` returns them."""
        return self._records[: self._k + 1]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; `options` may give its `case` and `variant`, which are drawn otherwise.

        Raises
        ------
        InputError
            If there is no such case, or it cannot be flown.
        """
        super().reset(seed=seed)
        asked = options or {}
        drawn = self._draw(self.np_random, asked.get("case"), asked.get("variant"))
        state = np.zeros(1, agents.STATE)
        self._action = state["action"][0]
        self._flight = flight = build_flight(drawn.scenario, drawn.aircraft, agents.Agent(self._mode, state))
        if flight.program.in_python:
            raise InputError(
                "the controller",
                found="a step in plain Python",
                expected="a compiled controller, whose program can be cut before the agent",
                remedy="assist one of nndondi-l1, ndi-l1, nndondi-mrac, ndi-mrac, pid, lqi",
            )
        seen = look.stage.block(
            params_of(
                look.PARAMS,
                limits=np.array(flight.given.design.limits_rad, dtype=float),
                assists=float(self._mode == agents.ASSIST),
                bounds=look.BOUNDS,
            ),
            name="look",
        )
        before, self._rest = flight.program.split(agents.NAME)
        watch = envelope.stage.block(flight.envelope, name="watch")
        self._sense = Program([*before.blocks, seen, watch])
        self._seen, self._last = seen.state["seen"][0], seen.state["action"][0]
        self._rows = empty_rows(flight.steps + 1, flight.shape)
        self._records = as_records(self._rows, flight.shape)
        flight.inputs.fill(self._records, 0)
        self._margins, self._weight = Margins(flight), 1.0 / flight.steps
        self._k, self._end = 0, flight.steps
        flight.plant.look()
        self._sense.run(self._rows, 0, 1)
        return self._seen.astype(np.float32), drawn.info

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Command and fly on for `hold` samples.

        Raises
        ------
        RuntimeError
            Where the episode is over, or has not begun.
        """
        k = self._k
        if k >= self._end:
            raise RuntimeError("the episode is over: call reset")
        rows = self._rows
        self._action[:] = action
        begun, until, run = k, min(k + self._hold, self._end), self._flight.plant.run
        k = run(self._rest, rows, k, k + 1)
        if begun < k < until:  # the samples that an action is held for are flown as one
            k = run(self._flight.program, rows, k, until)
        lost = k < until
        reward = self._weight * self._margins(rows, begun, k)
        if not lost:
            self._last[:] = self._action
            lost = self._sense.run(rows, k, k + 1) == k
        self._k = k
        ended = lost or k == self._end
        info: dict[str, Any] = {}
        if ended:
            self._end = k  # no step follows
            if not lost:
                self._flight.plant.run(self._rest, rows, k, k + 1)  # the last row, as every flight has it
            verdict = self._verdict(lost)
            reward += verdict.margin
            info = {"verdict": verdict.document(), "ended_because": self._reason() if lost else None}
        return self._seen.astype(np.float32), float(reward), bool(lost), ended and not lost, info

    def _verdict(self, lost: bool) -> Verdict:
        k, monitor = self._k, self._flight.monitor()
        keep = k + (not lost or self._records["status"][k] > envelope.NOT_A_NUMBER)
        monitor.take(self._records[:keep])
        scenario = self._flight.scenario
        at = float(self._records["t"][k]) if lost else None
        return verdict_of(monitor.found(), completed=not lost, ended_at_s=at, duration_s=scenario.duration_s)

    def _reason(self) -> str:
        return envelope.reason(self._flight.envelope[0], self._records[self._k])
