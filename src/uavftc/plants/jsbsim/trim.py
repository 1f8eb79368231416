"""Trim: steady straight flight, wings level or nearly so, and the exact start of a flight from it.

Three ways, tried in this order:

- `jsbsim`: JSBSim's own full trim. It fails where a light propeller needs time to spin up.
- `own`, the project's: the vehicle is frozen in its state (its four integrators switched off) while engines and
  actuators run, and alpha, elevator, throttle, bank, aileron and rudder are solved for zero accelerations at zero
  sideslip.
- `glide`: the same for an aircraft without engines, with the flight path angle in place of the throttle.
- `solved`: the project's again, for surfaces with backlash, servos and ends, an axis without a surface, and throttles
  that are not linear: bounded Newton steps with wide differences (`search.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.plants.jsbsim import engines
from uavftc.plants.jsbsim.engines import has
from uavftc.plants.jsbsim.rig import Rig
from uavftc.plants.jsbsim.settle import accelerations, run_for, set_from_below
from uavftc.plants.jsbsim.units import FT_M

INTEGRATORS = tuple(
    f"simulation/integrator/{kind}/{motion}"
    for kind in ("rate", "position")
    for motion in ("rotational", "translational")
)
TRIM_COMMANDS = ("fcs/roll-trim-cmd-norm", "fcs/pitch-trim-cmd-norm", "fcs/yaw-trim-cmd-norm")
SPIN_UP_S = 2.0  # a step of the project's trim; long against a propeller's time constant (0.1 s for hale)
SETTLE_S = 5.0  # before a flight; what is left of the spin-up is below rounding
STARTS = (0.5, 0.1, 0.9)  # throttle to start the solution from, in turn: a stopped propeller has no slope
TOLERANCE = 1e-6  # m/s^2 and rad/s^2, on each equation of the project's trim
JSBSIM_TOLERANCE = 2e-3  # m/s^2 and rad/s^2; JSBSim's own trim stops below 1e-3 ft/s^2 and 1e-4 rad/s^2 or so


class Trim(NamedTuple):
    """A steady straight flight: SI and radians; surface commands in the units of the aircraft's properties."""

    method: str
    """`jsbsim`, `own` or `glide`."""
    airspeed: float
    altitude: float
    alpha: float
    theta: float
    phi: float
    surfaces: tuple[float, ...]
    """Command of each effector."""
    trim_commands: tuple[float, float, float]
    """JSBSim's roll, pitch and yaw trim commands; zero where the aircraft has none."""
    throttle: float
    residual: tuple[float, ...]
    """u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2, at the solution."""
    beta: float = 0.0
    """Sideslip, rad; other than zero only where an axis has no surface."""
    properties: tuple[str, ...] = ()
    """Command property of each effector."""
    throttles: tuple[str, ...] = ()
    """Throttle commands."""
    backlash: tuple[float, ...] = ()
    """Of each effector, in units of its command: it is set from below."""
    way: str = "running"
    """How the engines are started; see `engines.WAYS`."""

    @property
    def gamma(self) -> float:
        """Flight path angle, rad, positive up (for wings level)."""
        return self.theta - self.alpha


def freeze(fdm: jsbsim.FGFDMExec) -> dict[str, int]:
    """Switch the motion off: the state stays, propulsion and flight controls run on. Return the integrators' codes."""
    codes = {name: int(fdm[name]) for name in INTEGRATORS}
    for name in INTEGRATORS:
        fdm[name] = 0
    return codes


def place(
    fdm: jsbsim.FGFDMExec,
    *,
    airspeed: float,
    altitude: float,
    alpha: float,
    theta: float | None = None,
    phi: float = 0.0,
    beta: float = 0.0,
    rates: Sequence[float] = (0.0, 0.0, 0.0),
) -> None:
    """Put the vehicle into a state heading north in still air; SI and radians. Without theta, the flight is level."""
    values = {
        "ic/lat-geod-deg": 0.0,
        "ic/long-gc-deg": 0.0,
        "ic/terrain-elevation-ft": 0.0,
        "ic/h-sl-ft": altitude / FT_M,
        "ic/vt-fps": airspeed / FT_M,
        "ic/alpha-rad": alpha,
        "ic/beta-rad": beta,
        "ic/theta-rad": alpha if theta is None else theta,
        "ic/phi-rad": phi,
        "ic/psi-true-rad": 0.0,
        "ic/p-rad_sec": rates[0],
        "ic/q-rad_sec": rates[1],
        "ic/r-rad_sec": rates[2],
    }
    for name, value in values.items():
        fdm[name] = value
    fdm.run_ic()


def configure(fdm: jsbsim.FGFDMExec, way: str = "running") -> None:
    """Clean configuration, engines running, fuel frozen where they run on it (assumption 1: constant mass)."""
    for name in ("gear/gear-cmd-norm", "gear/gear-pos-norm"):
        if has(fdm, name):
            fdm[name] = 0.0
    engines.start(fdm, way)


def hold(fdm: jsbsim.FGFDMExec, trim: Trim) -> None:
    """Freeze the vehicle in the state of a trim, engines running."""
    freeze(fdm)
    place(
        fdm, airspeed=trim.airspeed, altitude=trim.altitude, alpha=trim.alpha, theta=trim.theta, phi=trim.phi,
        beta=trim.beta,
    )  # fmt: skip
    configure(fdm, trim.way)


def command(fdm: jsbsim.FGFDMExec, trim: Trim) -> None:
    """Set all commands of a trim, a surface with backlash from below."""
    for name, value in zip(TRIM_COMMANDS, trim.trim_commands, strict=True):
        if has(fdm, name):
            fdm[name] = value
    set_throttle(fdm, trim.throttles, trim.throttle)
    slack = dict(zip(trim.properties, trim.backlash, strict=True))
    set_from_below(fdm, dict(zip(trim.properties, trim.surfaces, strict=True)), slack)


def set_throttle(fdm: jsbsim.FGFDMExec, throttles: Sequence[str], value: float) -> None:
    """Set the throttle command of all engines, 0..1."""
    for name in throttles:
        fdm[name] = value


def trim_jsbsim(fdm: jsbsim.FGFDMExec, rig: Rig, airspeed: float, altitude: float) -> Trim | None:
    """Return JSBSim's own full trim in level flight, or None where it fails."""
    place(fdm, airspeed=airspeed, altitude=altitude, alpha=0.0)
    configure(fdm)
    try:
        fdm["simulation/do_simple_trim"] = 1
    except jsbsim.TrimFailureError:
        return None
    error = accelerations(fdm)
    throttles = rig.throttles
    trim = Trim(
        "jsbsim",
        airspeed,
        altitude,
        fdm["aero/alpha-rad"],
        fdm["attitude/theta-rad"],
        fdm["attitude/phi-rad"],
        tuple(fdm[s.command] for s in rig.surfaces.values()),
        tuple(fdm[n] if has(fdm, n) else 0.0 for n in TRIM_COMMANDS),  # type: ignore[arg-type]
        fdm[throttles[0]] if throttles else 0.0,
        error,
        **of_rig(rig),
    )
    return trim if all(abs(e) < JSBSIM_TOLERANCE for e in error) else None


def of_rig(rig: Rig) -> dict[str, Any]:
    """Return the fields of a trim that say what is commanded."""
    return {
        "properties": tuple(s.command for s in rig.surfaces.values()),
        "throttles": rig.throttles,
        "backlash": tuple(map(float, rig.backlash)),
        "way": rig.way,
    }


def trim_own(fdm: jsbsim.FGFDMExec, rig: Rig, airspeed: float, altitude: float) -> Trim | None:
    """Return the project's trim for surfaces without backlash, three axes, or None. The FDM is left frozen.

    Commands of aileron, elevator and rudder are solved for; the members of a gang follow theirs.
    """
    from scipy.optimize import root  # noqa: PLC0415 - 0.1 s that a flight from a known trim need not pay

    freeze(fdm)
    glides = engines.count(fdm) == 0
    place(fdm, airspeed=airspeed, altitude=altitude, alpha=0.0)
    configure(fdm, rig.way)
    first = [float(rig.scale[np.flatnonzero(rig.mixing[:, i])[0]]) for i in range(3)]
    share = rig.mixing * np.array(first) / rig.scale[:, None]  # 1 or -1, to the bit, for members alike

    def as_trim(x: np.ndarray, error: tuple[float, ...] = ()) -> Trim:
        alpha, elevator, third, phi, aileron, rudder = map(float, x)
        theta, throttle = (alpha + third, 0.0) if glides else (alpha, third)
        commands = (aileron, elevator, rudder)
        surfaces = tuple(float(sum(m * c for m, c in zip(row, commands, strict=True) if m)) for row in share)
        method = "glide" if glides else "own"
        return Trim(method, airspeed, altitude, alpha, theta, phi, surfaces, (0, 0, 0), throttle, error, **of_rig(rig))

    def equations(x: np.ndarray) -> tuple[float, ...]:
        trim = as_trim(x)
        place(fdm, airspeed=airspeed, altitude=altitude, alpha=trim.alpha, theta=trim.theta, phi=trim.phi)
        command(fdm, trim)
        run_for(fdm, SPIN_UP_S)
        u, v, w, p, q, r = accelerations(fdm)
        return u, w, q, v, p, r

    for third in (-0.05,) if glides else STARTS:
        solution = root(equations, [0.0, 0.0, third, 0.0, 0.0, 0.0], options={"eps": 1e-6, "xtol": 1e-12})
        u, w, q, v, p, r = equations(solution.x)
        trim = as_trim(solution.x, (u, v, w, p, q, r))
        usable = all(low <= c <= high for c, (low, high) in zip(trim.surfaces, rig.ranges, strict=True))
        if all(abs(e) < TOLERANCE for e in trim.residual) and usable and 0.0 <= trim.throttle <= 1.0:
            return trim
    return None


WIND = ("atmosphere/wind-north-fps", "atmosphere/wind-east-fps", "atmosphere/wind-down-fps")


def start(
    fdm: jsbsim.FGFDMExec,
    aircraft: Aircraft,
    trim: Trim,
    wind_n: np.ndarray,
    integrators: dict[str, int],
    settled: Iterable[Callable[[jsbsim.FGFDMExec], None]] = (),
) -> None:
    """Start the flight from the trim, in air that moves with `wind_n` (north, east, down), m/s, at time zero.

    The vehicle moves with the air, so that steady wind leaves it in trim. The first seconds are flown frozen: the
    engines come to speed, and all models have seen the wind before anything moves. Every flight starts so, from a
    fresh FDM, whether its trim was solved just now or before: flights are identical to the bit. What `settled` changes
    about the vehicle is changed then, before anything moves.
    """
    hold(fdm, trim)
    command(fdm, trim)
    if np.any(wind_n):
        names = ("ic/vn-fps", "ic/ve-fps", "ic/vd-fps")
        still = [fdm[f"velocities/v-{axis}-fps"] for axis in ("north", "east", "down")]
        for name, air, speed in zip(names, wind_n, still, strict=True):
            fdm[name] = speed + air / FT_M
        fdm.run_ic()
        configure(fdm, trim.way)
        for name, speed in zip(WIND, wind_n, strict=True):
            fdm[name] = speed / FT_M
    if aircraft.autothrottle is not None:
        fdm[aircraft.autothrottle.setpoint_fps] = trim.airspeed / FT_M
    run_for(fdm, SETTLE_S)
    for change in settled:
        change(fdm)
    if aircraft.autothrottle is not None:
        fdm[aircraft.autothrottle.switch] = 1
    for name, code in integrators.items():
        fdm[name] = code
    fdm.set_sim_time(0.0)
