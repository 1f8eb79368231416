"""JSBSim as a plant: six degrees of freedom, from a trim.

Order within a sample, at t_k: the program runs on the state that was read (controller, actuators), the commands are
written, JSBSim runs its frames, and the state is read. JSBSim moves first and computes forces after, so a command
written at t_k moves the surface in the frame that ends at t_k + dt and the body rates in the next: one frame of delay
that the analytic plant does not have.

Where a surface does not follow its command as a gain does (a servo, a yaw damper, a scheduled gain), its position is
read with the state. At t_k it is what the command of the row before has brought about, and belongs to that row.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.core.program import Program
from uavftc.core.stage import Block, params_of, records_of
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim import bridge
from uavftc.plants.jsbsim.copy import moment_name
from uavftc.plants.jsbsim.events import Schedule, Told, existing
from uavftc.plants.jsbsim.load import initialised
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.plants.jsbsim.reading import Reading
from uavftc.plants.jsbsim.trim import WIND, Trim, start
from uavftc.plants.jsbsim.writer import Fly, Setter, looper, writer

INTEGRATORS = {
    "simulation/integrator/rate/rotational": 4,
    "simulation/integrator/rate/translational": 3,
    "simulation/integrator/position/rotational": 5,
    "simulation/integrator/position/translational": 4,
}
"""JSBSim's codes: 1 Euler, 2 trapezoidal, 3 and 4 Adams-Bashforth of order 2 and 3, 5 Buss' quaternion rule.
JSBSim's defaults are Euler for the rotation; see docs/decisions/0003-jsbsim-integrators.md."""

HOLD_BANDWIDTH = 0.5  # 1/s, of the airspeed hold; slow against the attitude loops, fast against the phugoid
HOLD_INTEGRAL = 0.1  # 1/s, its integral against its proportional part
HOLD_MIN = 0.05  # m/s^2 per unit of throttle: with less, an engine holds no airspeed


class JSBSimPlant:
    """A JSBSim aircraft in flight; one instance, one flight.

    Parameters
    ----------
    aircraft, model
        What to fly, and its trimmed model at the initial condition.
    timing
        Sample time, and frames a sample.
    wind_n
        Wind at time zero, north-east-down, shape (3,), m/s.
    has_wind, has_moment
        Whether the scenario moves the air, or disturbs the vehicle by d2: what is absent is never written.
    told
        What JSBSim is told once, at given rows, and what is put into the copy of the aircraft for it.
    engines
        Engines for which a row has room; their throttle and thrust are read.
    inertia
        J of the vehicle that flies, shape (3, 3), kg m^2, by which d2 becomes a moment; None is that of the model.

    Raises
    ------
    InputError
        If the aircraft does not load.
    """

    takes_end = True  # JSBSim moves the vehicle first, then reads the surfaces for the acceleration there

    def __init__(
        self,
        aircraft: Aircraft,
        model: TrimmedModel,
        timing: Timing,
        *,
        wind_n: np.ndarray,
        has_wind: bool,
        has_moment: bool,
        integrators: dict[str, int] | None = None,
        told: Sequence[Told] = (),
        engines: int = 0,
        inertia: np.ndarray | None = None,
    ) -> None:
        integrators = INTEGRATORS if integrators is None else integrators
        self.trim = trim = Trim(**model.trim)
        self.fdm = fdm = initialised(aircraft, timing.plant_step, [a for each in told for a in each.additions])
        start(fdm, aircraft, trim, wind_n, integrators, [each.settled for each in told])
        self._events = Schedule(fdm, [event for each in told for event in (*each.events, *each.at_start(fdm))])
        self._row = 0
        self.x1_trim = np.array([trim.phi, trim.theta, 0.0])
        self.u_limits = np.array([e.limits_rad for e in model.effectors])
        self.program_substeps = 1
        self.settings: dict[str, Any] = {
            "step_s": timing.plant_step,
            "integrators": {name.removeprefix("simulation/integrator/"): code for name, code in integrators.items()},
            "trim": {
                "method": trim.method,
                "airspeed_mps": trim.airspeed,
                "altitude_m": trim.altitude,
                "alpha_rad": trim.alpha,
                "theta_rad": trim.theta,
                "phi_rad": trim.phi,
                "surface_commands": list(trim.surfaces),
                "throttle": trim.throttle,
            },
        }
        if model.step:
            self.settings["step_check"] = dict(model.step)
        holds = aircraft.autothrottle is None and model.engines > 0 and model.throttle_mps2 > HOLD_MIN
        kp = HOLD_BANDWIDTH / model.throttle_mps2 if holds else 0.0
        self.settings["airspeed_hold"] = "aircraft" if aircraft.autothrottle else "bridge" if holds else "none"
        n = len(trim.surfaces)
        # everything written to JSBSim is in one piece of memory, so that one call unpacks it
        self._out = np.zeros(n + (bridge.HOLD_STATE.itemsize + bridge.PUSH_STATE.itemsize) // 8)
        commands, rest = self._out[:n].view(bridge.COMMAND_STATE), self._out[n:]
        hold, push = rest[:2].view(bridge.HOLD_STATE), rest[2:].view(bridge.PUSH_STATE)
        self._command = bridge.command_stage.block(
            records_of(
                bridge.COMMAND_PARAMS,
                n,
                trim=trim.surfaces,
                rad_per_command=[e.rad_per_command for e in model.effectors],
                least=[e.commands[0] for e in model.effectors],
                greatest=[e.commands[1] for e in model.effectors],
            ),
            commands,
            name="command",
        )
        self._hold = bridge.hold_stage.block(
            params_of(
                bridge.HOLD_PARAMS,
                h=timing.h,
                throttle=trim.throttle,
                airspeed=trim.airspeed,
                kp=kp,
                ki=HOLD_INTEGRAL * kp,
            ),
            hold,
            name="airspeed hold",
        )
        J = model.inertia_kgm2 if inertia is None else inertia
        self._push = bridge.push_stage.block(params_of(bridge.PUSH_PARAMS, J=J), push, name="push")
        self._reading = Reading(fdm, aircraft, model, throttles=bool(trim.throttles), engines=engines)
        self._frames = timing.substeps
        self._pushes = has_wind or has_moment
        self._bind(aircraft, model, has_wind=has_wind, has_moment=has_moment, holds=holds)

    def _bind(self, aircraft: Aircraft, model: TrimmedModel, *, has_wind: bool, has_moment: bool, holds: bool) -> None:
        """Look what is written up once; a bound accessor costs a tenth of a look-up."""
        node, throttles = functools.partial(existing, self.fdm), self.trim.throttles
        surfaces: list[list[Setter]] = [[node(e.command).set_double_value] for e in model.effectors]
        held: list[list[Setter]] = [
            [node(name).set_double_value for name in throttles] if holds else [],
            [],
        ]  # throttle, its integral
        moment: list[list[Setter]] = []
        wind: list[list[Setter]] = []
        if has_moment:
            base = f"external_reactions/{moment_name(aircraft)}"
            self.fdm[f"{base}/magnitude-lbsft"] = 1.0
            moment = [[node(f"{base}/{axis}").set_double_value] for axis in "lmn"]
        if has_wind:
            moment = moment or [[]] * 3
            wind = [[node(name).set_double_value] for name in WIND]
        self._setters: list[list[Setter]] = [*surfaces, *held, *moment, *wind]
        self._write = writer(self._out, self._setters)
        self._write_surfaces = writer(self._out, surfaces)

    def before(self) -> list[Block]:
        """Return the blocks that convert what was read, and hold the airspeed."""
        return [*self._reading.blocks(), self._hold]

    def given(self) -> list[Block]:
        """Return the block that prepares what is written once a sample: the moment and the wind."""
        return [self._push] if self._pushes else []

    def after(self) -> list[Block]:
        """Return the block that prepares what is written at each frame."""
        return [self._command]

    def look(self) -> None:
        """Read the vehicle as it is."""
        self._reading.read()
        self._reading.weigh()

    def run(self, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        """Fly rows `first` to `last - 1`; return the row at which the vehicle was lost, or `last`."""
        self.look()
        done = first
        while done < last:  # once, where there is no event
            struck = self._events.write(self._row)  # from the next frame on the mass may be another
            until = done + 1 if struck else int(min(last, done + self._events.row - self._row))
            flown = self._fly(program, rows, done, until)
            if struck:
                self._reading.weigh()
            self._row += flown - done
            done = flown
            if flown < until:  # lost
                break
        self._reading.follow(rows, first, done, last)
        return done

    @functools.cached_property
    def _loop(self) -> Fly:
        return looper(self._out, self._setters, self.fdm.run, self._reading.memory, self._reading.sources)

    def _fly(self, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        step = program.on(rows)
        if self._frames == 1:
            return self._loop(step, first, last)
        frame, read, write, write_surfaces = self.fdm.run, self._reading.read, self._write, self._write_surfaces
        again, more = program.again(rows), range(1, self._frames)
        for k in range(first, last):
            if step(k, k + 1) == k:
                return k
            write()
            frame()
            for _ in more:
                if not again(k):
                    return k
                write_surfaces()
                frame()
            read()
        return last
