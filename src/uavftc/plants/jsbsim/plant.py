"""JSBSim as a plant: six degrees of freedom, from a trim of its own.

Order within a sample, at t_k: the state is read into the row, the program runs (controller, actuators), the commands
are written, and JSBSim runs its frames. JSBSim moves first and computes forces after, so a command written at t_k
moves the surface in the frame that ends at t_k + dt and the body rates in the next: one frame of delay that the
analytic plant does not have.
"""

from __future__ import annotations

import functools
import struct
from typing import Any

import jsbsim
import numpy as np

from uavftc.aircraft import Aircraft
from uavftc.errors import InputError
from uavftc.plants.interface import Timing
from uavftc.plants.jsbsim import bridge
from uavftc.plants.jsbsim.load import check_initialised, load
from uavftc.plants.jsbsim.trim import WIND, Trim, start, trim_level
from uavftc.signals import ROW, SURFACES
from uavftc.stage import Block, Program, params_of

STATE_PROPERTIES = (
    "attitude/phi-rad", "attitude/theta-rad", "attitude/psi-rad",
    "velocities/p-rad_sec", "velocities/q-rad_sec", "velocities/r-rad_sec",
    "velocities/vt-fps", "position/h-sl-ft", "position/h-agl-ft",
    "aero/alpha-rad", "aero/beta-rad",
)  # fmt: skip
"""In the order of the row from `x1` on; the throttle follows, as the aircraft names it, and the ground's force."""
CONTACT = "forces/fbz-gear-lbs"

TRIM_FRAME_S = 0.005  # the trim does not depend on the rate at which it is flown

_OFFSET = ROW.fields["x1"][1]  # type: ignore[index]
_READ = struct.Struct(f"{len(STATE_PROPERTIES) + 2}d")
_WRITE = struct.Struct("12d")

INTEGRATORS = {
    "simulation/integrator/rate/rotational": 4,
    "simulation/integrator/rate/translational": 3,
    "simulation/integrator/position/rotational": 5,
    "simulation/integrator/position/translational": 4,
}
"""JSBSim's codes: 1 Euler, 2 trapezoidal, 3 and 4 Adams-Bashforth of order 2 and 3, 5 Buss' quaternion rule.
JSBSim's defaults are Euler for the rotation; see docs/decisions/0003-jsbsim-integrators.md."""


class JSBSimPlant:
    """A JSBSim aircraft in flight; one instance, one flight.

    Parameters
    ----------
    aircraft
        What to fly.
    timing
        Sample time, frames a sample, and the switch inside a sample.
    airspeed, altitude
        Initial condition, m/s true and m above mean sea level.
    wind_n
        Wind at time zero, north-east-down, shape (3,), m/s.
    has_wind, has_moment
        Whether the scenario moves the air, or disturbs the vehicle by d2: what is absent is never written.

    Raises
    ------
    InputError
        If the aircraft does not load strictly or has no level trim there.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        timing: Timing,
        *,
        airspeed: float,
        altitude: float,
        wind_n: np.ndarray,
        has_wind: bool,
        has_moment: bool,
        integrators: dict[str, int] | None = None,
    ) -> None:
        integrators = INTEGRATORS if integrators is None else integrators
        self.trim = level_trim(aircraft, aircraft.sha256(), airspeed, altitude)
        self.fdm = fdm = initialised(aircraft, timing.h / timing.substeps)
        start(fdm, aircraft, self.trim, wind_n, integrators)
        self.x1_trim = np.array([0.0, self.trim.alpha, 0.0])
        self.settings: dict[str, Any] = {
            "step_s": timing.h / timing.substeps,
            "integrators": {name.removeprefix("simulation/integrator/"): code for name, code in integrators.items()},
            "trim": {
                "airspeed_mps": airspeed,
                "altitude_m": altitude,
                "alpha_rad": self.trim.alpha,
                "elevator_rad": self.trim.elevator,
                "throttle": self.trim.throttle,
            },
        }
        self._bind(aircraft, has_wind=has_wind, has_moment=has_moment)
        # part of each frame of a sample in which the earlier command still applies
        edges = np.clip(timing.switch * timing.substeps - np.arange(timing.substeps), 0.0, 1.0)
        self._early_parts = [float(x) for x in edges]
        self.surface_trim = np.array([0.0, self.trim.elevator, 0.0])
        inertia = np.array(aircraft.mass_properties.inertia_kgm2)
        self._command = bridge.command_stage.block(params_of(bridge.COMMAND_PARAMS, trim=self.surface_trim, J=inertia))
        self._observe = bridge.observe_stage.block()

    def _bind(self, aircraft: Aircraft, *, has_wind: bool, has_moment: bool) -> None:
        """Look every property up once; a bound accessor costs a tenth of a look-up."""
        node = functools.partial(_node, self.fdm)
        self._get = [
            node(name).get_double_value for name in (*STATE_PROPERTIES, aircraft.throttle.position[0], CONTACT)
        ]
        self._set_surface = [node(getattr(aircraft.surfaces, s).command).set_double_value for s in SURFACES]
        self._set_wind = [node(name).set_double_value for name in WIND] if has_wind else None
        self._set_moment = None
        if has_moment:
            if aircraft.disturbance_moment is None:
                raise InputError(
                    f"aircraft {aircraft.name}, {aircraft.companion}, key disturbance_moment",
                    found="no moment input",
                    expected="the name of an <external_reactions> moment in body axes, to carry angular-acceleration",
                    remedy='add <moment name="dist" frame="BODY"> to the XML and disturbance_moment: dist here',
                )
            base = f"external_reactions/{aircraft.disturbance_moment}"
            self.fdm[f"{base}/magnitude-lbsft"] = 1.0
            self._set_moment = [node(f"{base}/{axis}").set_double_value for axis in "lmn"]

    def before(self) -> list[Block]:
        """Return the block that converts what was read."""
        return [self._observe]

    def after(self) -> list[Block]:
        """Return the block that prepares what is written."""
        return [self._command]

    def run(self, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        """Fly rows `first` to `last - 1`; return the row at which the vehicle was lost, or `last`."""
        step, run = program.run, self.fdm.run
        pack, unpack = _READ.pack_into, _WRITE.unpack_from
        buffer, out = rows.data.cast("B"), self._command.state.data.cast("B")
        phi, theta, psi, p, q, r, v, h, agl, alpha, beta, throttle, contact = self._get
        set_a, set_e, set_r = self._set_surface
        parts = self._early_parts
        whole = parts[0] == 0.0
        moment, wind = self._set_moment, self._set_wind
        for k in range(first, last):
            pack(
                buffer, k * ROW.itemsize + _OFFSET,
                phi(), theta(), psi(), p(), q(), r(), v(), h(), agl(), alpha(), beta(), throttle(), contact(),
            )  # fmt: skip
            if step(rows, k, k + 1) == k:
                return k
            a0, e0, r0, a1, e1, r1, m_l, m_m, m_n, w_n, w_e, w_d = unpack(out)
            if moment is not None:
                moment[0](m_l), moment[1](m_m), moment[2](m_n)
            if wind is not None:
                wind[0](w_n), wind[1](w_e), wind[2](w_d)
            if whole:
                set_a(a1), set_e(e1), set_r(r1)
                for _ in parts:
                    run()
            else:
                for early in parts:
                    late = 1.0 - early
                    set_a(early * a0 + late * a1), set_e(early * e0 + late * e1), set_r(early * r0 + late * r1)
                    run()
        return last


def _node(fdm: jsbsim.FGFDMExec, name: str) -> jsbsim.FGPropertyNode:
    node = fdm.get_property_manager().get_node(name)
    if node is None:  # JSBSim would create it silently at the first write
        raise KeyError(name)
    return node


def initialised(aircraft: Aircraft, dt: float) -> jsbsim.FGFDMExec:
    """Return a fresh FDM at frame time dt, s, loaded, initialised and checked against the companion file.

    Raises
    ------
    InputError
        If the aircraft does not load strictly or does not hold what the companion file says.
    """
    fdm = load(aircraft, dt)
    try:
        fdm.run_ic()
        check_initialised(aircraft, fdm)
    except (jsbsim.BaseError, KeyError) as error:
        raise InputError(
            f"aircraft {aircraft.name}, {aircraft.xml}",
            found=f"JSBSim cannot initialise it: {' '.join(str(error).split())}",
            expected="an aircraft whose properties all exist",
            remedy="correct the property name in the XML",
        ) from None
    return fdm


@functools.lru_cache(maxsize=64)
def level_trim(aircraft: Aircraft, checksum: str, airspeed: float, altitude: float) -> Trim:
    """Return the level trim, m/s and m, solved once for each state of the aircraft's files (`checksum`).

    Raises
    ------
    InputError
        If there is none.
    """
    del checksum  # part of the key alone
    return trim_level(initialised(aircraft, TRIM_FRAME_S), aircraft, airspeed, altitude)
