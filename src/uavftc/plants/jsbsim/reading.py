"""What is read from JSBSim at each sample: the vehicle, its engines, and the surfaces that it moves by itself.

A crossing from Python costs about as much as a law, so nothing is read twice, and nothing that is known: the force of
the ground far above it, a mass that does not change.
"""

from __future__ import annotations

import math

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.core.signals import Shape
from uavftc.core.stage import Block, params_of, records_of
from uavftc.plants.jsbsim import bridge
from uavftc.plants.jsbsim.engines import count, throttle_position
from uavftc.plants.jsbsim.events import existing
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.plants.jsbsim.positions import Followed
from uavftc.plants.jsbsim.writer import Below, Getter, Source, reader

STATE_PROPERTIES = (
    "attitude/phi-rad", "attitude/theta-rad", "attitude/psi-rad",
    "velocities/p-rad_sec", "velocities/q-rad_sec", "velocities/r-rad_sec",
    "velocities/vt-fps", "position/h-sl-ft",
    "aero/alpha-rad", "aero/beta-rad",
)  # fmt: skip
"""The first of `bridge.RAW_STATE`; the throttle follows, as the aircraft names it, and the ground's force."""
CONTACT = "forces/fbz-gear-lbs"
HEIGHT = STATE_PROPERTIES.index("position/h-sl-ft")
NEAR_FT = 1000.0  # height up to which the ground's force is read; no vehicle reaches so far below its centre of gravity
FORCES = ("forces/fbx-total-lbs", "forces/fby-total-lbs", "forces/fbz-total-lbs")
"""Of the state that is read; JSBSim's load factors, accelerations/Nz and others, are those of the frame before."""
PLACE = ("position/ecef-y-ft", "position/ecef-z-ft")
"""Every flight starts where the equator crosses the first meridian, so these are east and north there."""
MORE_PROPERTIES = (*FORCES, "aero/qbar-psf", *PLACE)
"""The last of `bridge.RAW_STATE`."""
MASS = "inertia/mass-slugs"


class Reading:
    """Memory that JSBSim's properties are read into, and the blocks that turn it into the row.

    Parameters
    ----------
    fdm
        The aircraft at its start.
    aircraft, model
        What is flown, and its trimmed model.
    throttles
        Whether a throttle command was trimmed; else the row's throttle is nan.
    engines
        Engines for which a row has room.
    """

    def __init__(
        self, fdm: jsbsim.FGFDMExec, aircraft: Aircraft, model: TrimmedModel, *, throttles: bool, engines: int
    ) -> None:
        self._fdm = fdm
        self._followed = Followed(model)
        n = len(model.effectors)
        head, power = bridge.OBSERVE_STATE.itemsize // 8, engines * bridge.POWER_STATE.itemsize // 8
        self._all = np.zeros(head + power + n)
        state, engine, positions = np.split(self._all, [head, head + power])
        self._positions = positions
        own = [throttles and throttle_position(j) == throttle_of(aircraft) for j in range(engines)]
        self._observe = bridge.observe_stage.block(
            params_of(bridge.OBSERVE_PARAMS, place=[fdm[name] for name in PLACE]),
            state.view(bridge.OBSERVE_STATE),
            name="observe",
        )
        self._power = bridge.power_stage.block(
            records_of(bridge.POWER_PARAMS, engines, row=np.array(own, dtype=float)),
            engine.view(bridge.POWER_STATE),
            name="power",
            first=Shape(n).engines_at,
        )
        self._locate = bridge.locate_stage.block(
            records_of(
                bridge.POSITION_PARAMS,
                n,
                read=self._followed.read.astype(float),
                rad=[e.position_rad for e in model.effectors],
            ),
            positions.view(bridge.POSITION_STATE),
        )
        throttle = self._getter(throttle_of(aircraft)) if throttles else lambda: math.nan
        contact = Below(self._getter(CONTACT), HEIGHT, NEAR_FT)
        self.sources: list[Source] = [*map(self._getter, STATE_PROPERTIES), throttle, contact]
        self.sources += map(self._getter, MORE_PROPERTIES)
        for j in range(engines):
            each = None if own[j] else self._getter(throttle_position(j))
            self.sources += [each, self._getter(thrust_of(j))]
        follows = zip(self._followed.read, model.effectors, strict=True)
        self.sources += [self._getter(e.position or "") if read else None for read, e in follows]
        self._mass = self._getter(MASS)
        self.memory = self._all[2:]  # heading and mass before it stay
        if count(fdm) and fdm["propulsion/fuel_freeze"] == 0.0:  # the mass changes
            self.sources, self.memory = [self._mass, *self.sources], self._all[1:]
        self._read = reader(self.memory, self.sources)

    def _getter(self, name: str) -> Getter:
        """Look a property up once; a bound accessor costs a tenth of a look-up."""
        getter: Getter = existing(self._fdm, name).get_double_value
        return getter

    def blocks(self) -> list[Block]:
        """Return the blocks that convert what was read."""
        power = [self._power] if self._power.records else []
        located = [self._locate] if self._followed.any else []
        return [self._observe, *power, *located]

    def read(self) -> None:
        """Read all."""
        self._read()

    def weigh(self) -> None:
        """Read the mass. It changes with events, and while fuel burns; then it is read at each sample."""
        self._all[1] = self._mass()

    def follow(self, rows: np.ndarray, first: int, done: int, last: int) -> None:
        """Put the positions that were read where they belong; see `Followed.take`."""
        if self._followed.any:
            self._followed.take(rows, first, done, last, self._positions)


def thrust_of(engine: int) -> str:
    """Return the property of an engine's thrust, from 0."""
    return f"propulsion/engine[{engine}]/thrust-lbs"


def throttle_of(aircraft: Aircraft) -> str:
    """Return the property of the throttle in the row: that of the companion file, or the first engine's."""
    if aircraft.throttle is None:
        return throttle_position(0)
    return (aircraft.throttle.position or aircraft.throttle.command)[0]
