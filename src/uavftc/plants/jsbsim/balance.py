"""What a JSBSim aircraft does in a state that it is held in: its six accelerations, with damage and faults of engines.

The vehicle is frozen, and engines and servos run until nothing changes (`settle`), as where a trim is solved. Damage
and faults of engines are told to it as in a flight (`damage.told`, `engine_faults.told`), all at its start. Surfaces
are commanded as the bridge does: trim command + deflection / rad_per_command, within the ends of the command.

Of the forces, gravity included, forward is what changes the airspeed, V'; side, to the right, what changes the
sideslip, V beta'; lift, upwards, what changes the incidence, -V cos(beta) alpha'; all m/s^2. The vehicle may turn about
the vertical at a constant bank and pitch: p = -t sin(pitch), q = t sin(bank) cos(pitch), r = t cos(bank) cos(pitch).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, sin

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.interface import State
from uavftc.plants.jsbsim.damage import told as told_of_damage
from uavftc.plants.jsbsim.engine_faults import EngineChange
from uavftc.plants.jsbsim.engine_faults import told as told_of_engines
from uavftc.plants.jsbsim.events import Schedule, Told
from uavftc.plants.jsbsim.load import inertia, initialised
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.plants.jsbsim.search import BURNING, STARTED_S
from uavftc.plants.jsbsim.settle import accelerations, run_for, set_from_below, settle
from uavftc.plants.jsbsim.trim import Trim, command, hold, place, set_throttle
from uavftc.plants.schedule import Struck

ENGINES_S = 20.0
"""In which engines come to rest: a piston engine with its propeller has a time constant of 0.7 s or so."""
SERVOS_S = 1.0
LONG = 4
"""Longer frames than in flight, by this: at rest it does not matter how long they are, where that is checked."""
SAME = 1e-7
"""m/s^2 and rad/s^2: what longer frames may change at the trim."""
FRAMES = 4
"""In which surfaces are where they are commanded, where there are no servos."""


class Held:
    """An aircraft that is held in one state after another.

    Parameters
    ----------
    aircraft, model
        What it is, and its trimmed model.
    damage
        Entries of `damage` that act, whole.
    engines
        Faults of engines that act.
    throttles
        Of each fault of an engine, where it finds the throttle, 0..1: what is stuck stays there. Left out, at trim.
    uncertain
        What is done to the nominal aircraft to make it the vehicle that flies.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        model: TrimmedModel,
        damage: Sequence[object] = (),
        engines: Sequence[EngineChange] = (),
        throttles: Sequence[float] = (),
        uncertain: Told | None = None,
    ) -> None:
        self.trim = Trim(**model.trim)
        self._made_of = aircraft, model, tuple(damage), tuple(engines), tuple(throttles)
        self._uncertain = Told() if uncertain is None else uncertain
        self._effectors = model.effectors
        self._slack = (
            dict(zip(self.trim.properties, self.trim.backlash, strict=True)) if any(self.trim.backlash) else {}
        )
        self._burns = self.trim.way != "running"
        self._ideal = all(e.ideal for e in model.effectors)
        self._frame_s = model.frame_s
        self.fdm = self._fresh()
        self._try_longer_frames()
        self.turned = np.linalg.solve(inertia(self.fdm), self._undamaged)
        """What an angular acceleration d2, the moment of the undamaged inertia, is of this vehicle, shape (3, 3)."""

    def _try_longer_frames(self) -> None:
        """Take frames `LONG` times as long, where the vehicle is the same with them, at trim and full throttle."""
        trim, zero = self.trim, np.zeros(len(self._effectors))
        at_trim = np.array([trim.airspeed, trim.alpha, trim.beta, trim.phi, trim.theta, 0.0, trim.throttle])
        opened = at_trim.copy()
        opened[State.THROTTLE] = 1.0 if trim.throttles else trim.throttle
        answers = [self.accelerations(state, zero) for state in (opened, at_trim)]
        fine, self._frame_s, short = self.fdm, LONG * self._frame_s, self._frame_s
        self.fdm = self._fresh()
        again = [self.accelerations(state, zero) for state in (opened, at_trim)]
        if not np.max(np.abs(np.subtract(answers, again))) <= SAME:
            self.fdm, self._frame_s = fine, short

    def _fresh(self) -> jsbsim.FGFDMExec:
        """Return the aircraft, held at the trim, with everything that acts on it."""
        aircraft, model, damage, engines, throttles = self._made_of
        struck = [Struck(entry, 0, None) for entry in damage]
        told = [told_of_damage(aircraft, struck, np.array(model.inertia_kgm2))]
        told += [told_of_engines([e._replace(start_s=0.0, end_s=None)], 1.0) for e in engines]
        every = (self._uncertain, *told)
        additions = list(dict.fromkeys(addition for each in every for addition in each.additions))
        fdm = initialised(aircraft, self._frame_s, additions)
        hold(fdm, self.trim)
        command(fdm, self.trim)
        self._uncertain.settled(fdm)
        self._undamaged = inertia(fdm)
        found_at = (None, *(throttles or [self.trim.throttle] * len(engines)))
        for each, throttle in zip(told, found_at, strict=True):
            if throttle is not None:
                set_throttle(fdm, self.trim.throttles, throttle)
                settle(fdm, patience_s=ENGINES_S)
            Schedule(fdm, [*each.events, *each.at_start(fdm)]).write(0)
        run_for(fdm, 2.0 * self._frame_s)  # mass, and the inertia of tanks, are new
        return fdm

    def accelerations(self, state: np.ndarray, deflections: np.ndarray) -> np.ndarray:
        """Return forward, side and lift, m/s^2, and p_dot, q_dot, r_dot, rad/s^2, at rest in a state, shape (6,).

        Parameters
        ----------
        state
            As `State` has it.
        deflections
            Of each effector about trim, shape (n,), rad.
        """
        if self._burns:
            return self._answer(
                state, deflections, lambda: settle(self.fdm, least_s=0.5, patience_s=STARTED_S, at_rest=BURNING)
            )
        return self._answer(state, deflections, lambda: settle(self.fdm, patience_s=ENGINES_S))

    def nearby(self, state: np.ndarray, deflections: np.ndarray) -> np.ndarray:
        """Return the same before engines have changed speed: for differences from a state at which they were at rest.

        The throttle must be the same, and the airspeed.
        """

        def soon() -> np.ndarray:
            if self._ideal:
                run_for(self.fdm, FRAMES * self.fdm.get_delta_t())
            else:
                settle(self.fdm, patience_s=SERVOS_S)
            return np.array(accelerations(self.fdm))

        return self._answer(state, deflections, soon)

    def _answer(self, state: np.ndarray, deflections: np.ndarray, wait: Callable[[], np.ndarray]) -> np.ndarray:
        """Return the accelerations after a wait, or nan; an FDM that has met one is never right again."""
        if not (np.all(np.isfinite(state)) and np.all(np.isfinite(deflections))):
            return np.full(6, np.nan)
        self._put(state, deflections)
        body = wait()
        if not np.all(np.isfinite(body)):
            self.fdm = self._fresh()
            return np.full(6, np.nan)
        axes = path_axes(float(state[State.ALPHA]), float(state[State.BETA]))
        return np.array([*(axes @ body[:3]), *body[3:]])

    def _put(self, state: np.ndarray, deflections: np.ndarray) -> None:
        """Put it into a state, with everything commanded."""
        fdm = self.fdm
        airspeed, alpha, beta, bank, pitch, turn, throttle = map(float, state)
        rates = (-turn * sin(pitch), turn * sin(bank) * cos(pitch), turn * cos(bank) * cos(pitch))
        place(
            fdm, airspeed=airspeed, altitude=self.trim.altitude, alpha=alpha, beta=beta, theta=pitch, phi=bank,
            rates=rates,
        )  # fmt: skip
        set_throttle(fdm, self.trim.throttles, throttle)
        commands = {
            e.command: min(max(e.trim_command + float(u) / e.rad_per_command, e.commands[0]), e.commands[1])
            for e, u in zip(self._effectors, deflections, strict=True)
        }
        set_from_below(fdm, commands, self._slack)


def path_axes(alpha: float, beta: float) -> np.ndarray:
    """Return the directions forward along the path, to its side and up from it, in body axes, one a row, (3, 3)."""
    c, s, C, S = cos(alpha), sin(alpha), cos(beta), sin(beta)
    return np.array([[c * C, S, s * C], [-c * S, C, -s * S], [s, 0.0, -c]])
