"""The bridge between the signal row and JSBSim, in two compiled laws; what crosses are plain doubles.

`observe` turns what JSBSim reports (feet, heading in [0, 2 pi)) into the row's SI and continuous heading.
`command` turns the row's deflections, disturbance and wind into what JSBSim is given.

A disturbance d2 is exact: it enters as the body moment J d2.
"""

from __future__ import annotations

from math import pi

import numpy as np

from uavftc.linear3 import multiply
from uavftc.plants.jsbsim.units import FT_M, LBF_N, SLUGFT2_KGM2
from uavftc.stage import NOTHING, Stage, carray, law

OBSERVE_STATE = np.dtype([("started", "f8"), ("psi", "f8")])  # heading of the previous sample, rad

COMMAND_PARAMS = np.dtype(
    [
        ("trim", "f8", (3,)),  # surface commands at trim, rad
        ("J", "f8", (3, 3)),  # kg m^2
    ]
)
COMMAND_STATE = np.dtype(
    [
        ("surface", "f8", (3,)),  # rad, total
        ("surface_late", "f8", (3,)),  # rad, total
        ("moment_lbsft", "f8", (3,)),
        ("wind_fps", "f8", (3,)),
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
    row.height *= FT_M
    row.contact *= LBF_N


@law
def command(p, s, row):
    """Write what JSBSim is given into the state."""
    moment = multiply(p.J, row.d2)
    for i in range(3):
        s.surface[i] = p.trim[i] + row.u2[i]
        s.surface_late[i] = p.trim[i] + row.u2_late[i]
        s.moment_lbsft[i] = moment[i] / SLUGFT2_KGM2
        s.wind_fps[i] = row.wind_n[i] / FT_M


@Stage(NOTHING, OBSERVE_STATE)
def observe_stage(p, s, row):
    """Entry."""
    observe(carray(s, 1)[0], carray(row, 1)[0])


@Stage(COMMAND_PARAMS, COMMAND_STATE)
def command_stage(p, s, row):
    """Entry."""
    command(carray(p, 1)[0], carray(s, 1)[0], carray(row, 1)[0])
