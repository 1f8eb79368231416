"""Level trim of a propeller aircraft, and the exact start of a flight.

JSBSim's own trim fails where a light propeller needs time to spin up. Here the vehicle is frozen in its state (its
four integrators switched off) while the propellers and actuators run, and angle of attack, elevator and throttle are
solved for u_dot = w_dot = q_dot = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import jsbsim
import numpy as np
from scipy.optimize import root

from uavftc.aircraft import Aircraft
from uavftc.errors import InputError
from uavftc.plants.jsbsim.units import FT_M

INTEGRATORS = tuple(
    f"simulation/integrator/{kind}/{motion}"
    for kind in ("rate", "position")
    for motion in ("rotational", "translational")
)

SPIN_UP_S = 2.0  # a step of the solution; long against the propeller's time constant (0.1 s for hale)
SETTLE_S = 5.0  # before a flight; what is left of the spin-up is below rounding
STARTS = (0.5, 0.1, 0.9)  # throttle to start the solution from, in turn: a stopped propeller has no slope
TOLERANCE = 1e-6  # m/s^2 and rad/s^2, on each of the three equations


class Trim(NamedTuple):
    """A level trim: SI and radians."""

    airspeed: float
    altitude: float
    alpha: float
    elevator: float
    throttle: float
    residual: tuple[float, float, float]
    """u_dot, w_dot (m/s^2) and q_dot (rad/s^2) at the solution."""


def freeze(fdm: jsbsim.FGFDMExec) -> None:
    """Switch the motion off: the state stays, propulsion and flight controls run on."""
    for name in INTEGRATORS:
        fdm[name] = 0


def place(fdm: jsbsim.FGFDMExec, *, airspeed: float, altitude: float, alpha: float) -> None:
    """Put the vehicle in straight level flight, wings level, heading north, no wind; SI and radians."""
    values = {
        "ic/lat-geod-deg": 0.0,
        "ic/long-gc-deg": 0.0,
        "ic/terrain-elevation-ft": 0.0,
        "ic/h-sl-ft": altitude / FT_M,
        "ic/vt-fps": airspeed / FT_M,
        "ic/alpha-rad": alpha,
        "ic/beta-rad": 0.0,
        "ic/theta-rad": alpha,
        "ic/phi-rad": 0.0,
        "ic/psi-true-rad": 0.0,
        "ic/p-rad_sec": 0.0,
        "ic/q-rad_sec": 0.0,
        "ic/r-rad_sec": 0.0,
    }
    for name, value in values.items():
        fdm[name] = value
    fdm.run_ic()


def command(fdm: jsbsim.FGFDMExec, aircraft: Aircraft, elevator: float, throttle: float) -> None:
    """Set the trim commands; elevator in rad, throttle 0..1."""
    fdm[aircraft.surfaces.elevator.command] = elevator
    for name in aircraft.throttle.command:
        fdm[name] = throttle


def residual(fdm: jsbsim.FGFDMExec) -> tuple[float, float, float]:
    """Return u_dot, w_dot, m/s^2, and q_dot, rad/s^2."""
    return (
        fdm["accelerations/udot-ft_sec2"] * FT_M,
        fdm["accelerations/wdot-ft_sec2"] * FT_M,
        fdm["accelerations/qdot-rad_sec2"],
    )


def trim_level(fdm: jsbsim.FGFDMExec, aircraft: Aircraft, airspeed: float, altitude: float) -> Trim:
    """Trim for straight level flight in still air and leave the FDM frozen there, propellers at speed.

    Parameters
    ----------
    airspeed, altitude
        True airspeed, m/s, and altitude above mean sea level, m.

    Raises
    ------
    InputError
        If no level trim exists with the throttle in [0, 1].
    """
    freeze(fdm)
    frames = round(SPIN_UP_S / fdm.get_delta_t())

    def equations(x: np.ndarray) -> tuple[float, float, float]:
        alpha, elevator, throttle = x
        place(fdm, airspeed=airspeed, altitude=altitude, alpha=alpha)
        command(fdm, aircraft, elevator, throttle)
        for _ in range(frames):
            fdm.run()
        return residual(fdm)

    for throttle in STARTS:
        solution = root(equations, [0.0, 0.0, throttle], method="hybr", options={"eps": 1e-6, "xtol": 1e-12})
        error = equations(solution.x)
        if max(map(abs, error)) < TOLERANCE:
            break
    alpha, elevator, throttle = map(float, solution.x)
    trim = Trim(airspeed, altitude, alpha, elevator, throttle, error)
    if not max(map(abs, error)) < TOLERANCE or not 0.0 <= trim.throttle <= 1.0:
        raise InputError(
            f"aircraft {aircraft.name}, trim at {airspeed:g} m/s and {altitude:g} m",
            found=f"alpha {np.degrees(trim.alpha):.2f} deg, elevator {np.degrees(trim.elevator):.2f} deg, "
            f"throttle {trim.throttle:.3f}, left over u_dot {error[0]:.2g}, w_dot {error[1]:.2g} m/s^2, "
            f"q_dot {error[2]:.2g} rad/s^2",
            expected=f"level flight with throttle 0 to 1 and each of these below {TOLERANCE:g}",
            remedy=f"choose another initial.airspeed_mps or initial.altitude_m (the aircraft's own: "
            f"{aircraft.initial.airspeed_mps:g} m/s, {aircraft.initial.altitude_m:g} m)",
        )
    return trim


def start(
    fdm: jsbsim.FGFDMExec, aircraft: Aircraft, trim: Trim, wind_n: np.ndarray, integrators: dict[str, int]
) -> None:
    """Start the flight from the trim, in air that moves with `wind_n` (north, east, down), m/s, at time zero.

    The vehicle moves with the air, so that steady wind leaves it in trim. The first seconds are flown frozen: the
    propellers come to speed, and all models have seen the wind before anything moves. Every flight starts so, from a
    fresh FDM, whether its trim was solved just now or before: flights are identical to the bit.
    """
    freeze(fdm)
    place(fdm, airspeed=trim.airspeed, altitude=trim.altitude, alpha=trim.alpha)
    if np.any(wind_n):
        air = np.array([trim.airspeed, 0.0, 0.0])  # level, heading north
        for name, speed in zip(("ic/vn-fps", "ic/ve-fps", "ic/vd-fps"), air + wind_n, strict=True):
            fdm[name] = speed / FT_M
        fdm.run_ic()
        for name, speed in zip(WIND, wind_n, strict=True):
            fdm[name] = speed / FT_M
    command(fdm, aircraft, trim.elevator, trim.throttle)
    if aircraft.autothrottle is not None:
        fdm[aircraft.autothrottle.setpoint_fps] = trim.airspeed / FT_M
    for _ in range(round(SETTLE_S / fdm.get_delta_t())):
        fdm.run()
    if aircraft.autothrottle is not None:  # after those frames, or it integrates the error of a stale airspeed
        fdm[aircraft.autothrottle.switch] = 1
    for name, code in integrators.items():
        fdm[name] = code
    fdm.set_sim_time(0.0)


WIND = ("atmosphere/wind-north-fps", "atmosphere/wind-east-fps", "atmosphere/wind-down-fps")
