"""The bridge between the signal row and JSBSim, in two compiled laws; what crosses are plain doubles.

`observe` turns what JSBSim reports (feet, heading in [0, 2 pi)) into the row's SI and continuous heading.
`command` turns the row's deflections, disturbance and wind into what JSBSim is given, and holds the airspeed of an
aircraft that has no autothrottle of its own.

A disturbance d2 is exact: it enters as the body moment J d2.
"""

from __future__ import annotations

from math import pi

import numpy as np

from uavftc.core.linear3 import multiply
from uavftc.core.stage import NOTHING, Stage, carray, law
from uavftc.plants.jsbsim.units import FT_M, LBF_N, SLUGFT2_KGM2

OBSERVE_STATE = np.dtype([("started", "f8"), ("psi", "f8")])  # heading of the previous sample, rad

COMMAND_PARAMS = np.dtype(
    [
        ("trim", "f8", (3,)),  # surface commands at trim, in their own units
        ("rad_per_command", "f8", (3,)),  # deflection, rad, per unit of command
        ("J", "f8", (3, 3)),  # kg m^2
        ("h", "f8"),  # sample time, s
        ("throttle", "f8"),  # at trim
        ("airspeed", "f8"),  # to hold, m/s
        ("kp", "f8"),  # throttle per m/s
        ("ki", "f8"),  # throttle per m
    ]
)
COMMAND_STATE = np.dtype(
    [
        ("surface_late", "f8", (3,)),  # command, in its own unit
        ("throttle", "f8"),  # command, 0..1
        ("moment_lbsft", "f8", (3,)),
        ("wind_fps", "f8", (3,)),
        ("surface", "f8", (3,)),  # command until the switch inside a sample
        ("integral", "f8"),  # of the airspeed hold, in throttle
    ]
)


@law
def observe(s, row):
    """Convert the raw values in the row to SI, in place, and make the heading continuous."""
    psi = row.x1[2]
    if s.started != 0.0:
        psi += 2.0 * pi * round((s.psi - psi) / (2.0 * pi))
    s.started = 1.0
    s.psi = psi
    row.x1[2] = psi
    row.airspeed *= FT_M
    row.altitude *= FT_M
    row.height = row.altitude  # the ground is at sea level (trim.place), and a look-up of it costs 0.1 us
    row.contact *= LBF_N


@law
def command(p, s, row):
    """Write what JSBSim is given into the state."""
    moment = multiply(p.J, row.d2)
    for i in range(3):
        s.surface[i] = p.trim[i] + row.u2[i] / p.rad_per_command[i]
        s.surface_late[i] = p.trim[i] + row.u2_late[i] / p.rad_per_command[i]
        s.moment_lbsft[i] = moment[i] / SLUGFT2_KGM2
        s.wind_fps[i] = row.wind_n[i] / FT_M
    hold_airspeed(p, s, row.airspeed)


@law
def hold_airspeed(p, s, airspeed):
    """PI on the airspeed error about the trim throttle; the integral rests where the throttle is at its end."""
    error = p.airspeed - airspeed
    wanted = p.throttle + p.kp * error + s.integral
    if (wanted < 1.0 or error < 0.0) and (wanted > 0.0 or error > 0.0):
        s.integral += p.ki * p.h * error
    s.throttle = min(1.0, max(0.0, wanted))


@Stage(NOTHING, OBSERVE_STATE)
def observe_stage(p, s, row):
    """Entry."""
    observe(carray(s, 1)[0], carray(row, 1)[0])


@Stage(COMMAND_PARAMS, COMMAND_STATE)
def command_stage(p, s, row):
    """Entry."""
    command(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])
