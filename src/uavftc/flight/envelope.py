"""The watch: when a vehicle counts as lost (exit code 3)."""

from __future__ import annotations

from math import isfinite

import numpy as np

from uavftc.core.stage import NOTHING, Stage, law

PARAMS = np.dtype(
    [
        ("bank_max", "f8"),  # rad
        ("pitch_max", "f8"),  # rad
        ("airspeed_min", "f8"),  # m/s
        ("airspeed_max", "f8"),  # m/s
    ]
)
STATE = NOTHING

NOT_A_NUMBER, BANK, PITCH, SLOW, FAST, GROUND = 1, 2, 3, 4, 5, 6
OUTSIDE = (BANK, PITCH, SLOW, FAST, GROUND)


@law
def step(p, s, row):
    """Set the row's status where the vehicle is lost. Air data that a plant lacks is nan and never trips a limit."""
    finite = True
    for i in range(3):
        finite = finite and isfinite(row.x1[i]) and isfinite(row.x2[i]) and isfinite(row.v2[i])
    if not finite:
        row.status = NOT_A_NUMBER
    elif abs(row.x1[0]) > p.bank_max:
        row.status = BANK
    elif abs(row.x1[1]) > p.pitch_max:
        row.status = PITCH
    elif row.airspeed < p.airspeed_min:
        row.status = SLOW
    elif row.airspeed > p.airspeed_max:
        row.status = FAST
    elif row.height <= 0.0 or abs(row.contact) > 0.0:
        row.status = GROUND


stage = Stage(step, PARAMS, STATE, reads=["x1", "x2", "v2", "airspeed", "height", "contact"], writes=["status"])


def reason(params: np.void, row: np.void) -> str:
    """Return in words why and when the vehicle was lost.

    Parameters
    ----------
    params, row
        Records of `PARAMS` and `signals.ROW`, the row being the one with a status.
    """
    code = row["status"]
    bank, pitch = np.degrees(row["x1"][:2])
    what = {
        NOT_A_NUMBER: "a state or command is not a number",
        BANK: f"attitude outside the envelope: bank {bank:.1f} deg, limit {np.degrees(params['bank_max']):g} deg",
        PITCH: f"attitude outside the envelope: pitch {pitch:.1f} deg, limit {np.degrees(params['pitch_max']):g} deg",
        SLOW: f"airspeed outside the envelope: {row['airspeed']:.2f} m/s, lower limit {params['airspeed_min']:g} m/s",
        FAST: f"airspeed outside the envelope: {row['airspeed']:.2f} m/s, upper limit {params['airspeed_max']:g} m/s",
        GROUND: "ground contact",
    }.get(code, f"a status of {code:g}, which is none of the envelope's")
    return f"{what}, at t = {row['t']:.3f} s"
