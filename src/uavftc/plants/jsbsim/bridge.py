"""The bridge between the signal row and JSBSim, in compiled laws; only plain doubles cross it.

`observe` turns what JSBSim reports (feet, heading in [0, 2 pi)) into the row's SI and continuous heading; `power`
does so for each engine.
`locate` turns the position that JSBSim reports of an effector into rad.
`push` turns the row's disturbance and wind into what JSBSim is given.
`hold_airspeed` holds the airspeed of an aircraft without an autothrottle.
`command` turns the deflection of one effector into its command, at each frame.

A disturbance d2 is exact: it enters as the body moment J d2.
"""

from __future__ import annotations

from math import pi

import numpy as np

from uavftc.core.linear3 import multiply
from uavftc.core.signals import ENGINE
from uavftc.core.stage import Stage, law
from uavftc.plants.analytic import VEHICLE
from uavftc.plants.jsbsim.units import FT_M, LBF_N, SLUGFT2_KGM2

STANDARD_GRAVITY = 9.80665 / FT_M  # ft/s^2
PSF_PA = LBF_N / FT_M**2

RAW_STATE = (
    ("x1", 3),  # rad, heading in [0, 2 pi)
    ("x2", 3),  # rad/s
    ("airspeed", 1),  # ft/s
    ("altitude", 1),  # ft
    ("alpha", 1),  # rad
    ("beta", 1),  # rad
    ("throttle", 1),
    ("contact", 1),  # lb
    ("forces", 3),  # all but gravity, body axes, lb
    ("qbar", 1),  # lb/ft^2
    ("place", 2),  # Earth-fixed: east and north of the place at which the equator crosses the first meridian, ft
)
OBSERVE_PARAMS = np.dtype([("place", "f8", (2,))])  # at the start, ft
OBSERVE_STATE = np.dtype(  # heading of the previous sample, rad; mass, slug; and what was read
    [("psi", "f8"), ("mass", "f8"), *((name, "f8", (n,)) if n > 1 else (name, "f8") for name, n in RAW_STATE)]
)

POWER_PARAMS = np.dtype([("row", "f8")])  # 1 where its throttle is that of the row
POWER_STATE = np.dtype([("throttle", "f8"), ("thrust", "f8")])  # as read: 0..1, lb

POSITION_PARAMS = np.dtype([("read", "f8"), ("rad", "f8")])  # 1 where it is read; rad per unit of the property
POSITION_STATE = np.dtype([("position", "f8")])  # as it was read

PUSH_PARAMS = np.dtype([("J", "f8", (3, 3))])  # kg m^2
PUSH_STATE = np.dtype([("moment_lbsft", "f8", (3,)), ("wind_fps", "f8", (3,))])

HOLD_PARAMS = np.dtype(
    [
        ("h", "f8"),  # sample time, s
        ("throttle", "f8"),  # at trim
        ("airspeed", "f8"),  # to hold, m/s
        ("kp", "f8"),  # throttle per m/s
        ("ki", "f8"),  # throttle per m
    ]
)
HOLD_STATE = np.dtype([("throttle", "f8"), ("integral", "f8")])  # command, 0..1, and the part of it that is an integral

COMMAND_PARAMS = np.dtype(
    [
        ("trim", "f8"),  # command at trim, in the unit of the command
        ("rad_per_command", "f8"),  # deflection, rad, per unit of command
        ("least", "f8"),  # command
        ("greatest", "f8"),  # command
    ]
)
COMMAND_STATE = np.dtype([("command", "f8")])  # in its own unit


@law
def observe(p, s, row):
    """Write what was read into the row, in SI and with a continuous heading."""
    psi = s.x1[2]
    psi += 2.0 * pi * round((s.psi - psi) / (2.0 * pi))  # from north, where a flight starts: never from 2 pi
    s.psi = psi
    row.x1[0] = s.x1[0]
    row.x1[1] = s.x1[1]
    row.x1[2] = psi
    for i in range(3):
        row.x2[i] = s.x2[i]
    row.airspeed = s.airspeed * FT_M
    altitude = s.altitude * FT_M
    row.altitude = altitude
    row.height = altitude  # the ground is at sea level (trim.place), and a look-up of it costs 0.1 us
    row.alpha = s.alpha
    row.beta = s.beta
    row.throttle = s.throttle
    row.contact = s.contact * LBF_N
    row.east = (s.place[0] - p.place[0]) * FT_M
    row.north = (s.place[1] - p.place[1]) * FT_M
    row.qbar = s.qbar * PSF_PA
    for i in range(3):
        row.load_factor[i] = s.forces[i] / (s.mass * STANDARD_GRAVITY)


@law
def power(p, s, e, row):
    """Write throttle and thrust of an engine."""
    e.throttle = row.throttle if p.row != 0.0 else s.throttle
    e.thrust = s.thrust * LBF_N


@law
def locate(p, s, e, row):
    """Write the position that was read: at t_k, so what the command of the row before has brought about."""
    if p.read != 0.0:
        e.position = p.rad * s.position


@law
def push(p, s, row):
    """Write the disturbing moment and the wind into the state."""
    moment = multiply(p.J, row.d2)
    for i in range(3):
        s.moment_lbsft[i] = moment[i] / SLUGFT2_KGM2
        s.wind_fps[i] = row.wind_n[i] / FT_M


@law
def hold_airspeed(p, s, row):
    """PI on the airspeed error about the trim throttle; the integral rests where the throttle is at its end."""
    error = p.airspeed - row.airspeed
    throttle = p.throttle + p.kp * error + s.integral
    if (throttle < 1.0 or error < 0.0) and (throttle > 0.0 or error > 0.0):
        s.integral += p.ki * p.h * error
    s.throttle = min(1.0, max(0.0, throttle))


@law
def command(p, s, e, row):
    """Write the command of the effector into the state, within its range."""
    value = p.trim + e.deflection / p.rad_per_command
    s.command = p.least if value < p.least else (p.greatest if value > p.greatest else value)


AIR = ("wind_n", "gust_rates")
"""What the scenario gives in place of the plant."""
observe_stage = Stage(
    observe, OBSERVE_PARAMS, OBSERVE_STATE, reads=[], writes=[name for name in VEHICLE if name not in AIR]
)
power_stage = Stage(power, POWER_PARAMS, POWER_STATE, reads=["throttle"], writes=["throttle", "thrust"], on=ENGINE)
locate_stage = Stage(locate, POSITION_PARAMS, POSITION_STATE, reads=[], writes=["position"])
push_stage = Stage(push, PUSH_PARAMS, PUSH_STATE, reads=["d2", "wind_n"], writes=[])
hold_stage = Stage(hold_airspeed, HOLD_PARAMS, HOLD_STATE, reads=["airspeed"], writes=[])
command_stage = Stage(command, COMMAND_PARAMS, COMMAND_STATE, reads=["deflection"], writes=[])
