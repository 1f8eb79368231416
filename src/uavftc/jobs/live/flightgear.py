"""FlightGear's packet of a flight dynamics model, `net_fdm` version 24, big-endian, 408 bytes: JSBSim's own output.

The place is where the flight began, LATITUDE and LONGITUDE, plus what it flew north and east, on the WGS 84 ellipsoid
about there. What the plant does not know stays as at the start: the analytic plant turns on the spot, at ALTITUDE.
Surfaces are shares of their stops as FlightGear counts them: elevator down, right aileron and left aileron down, rudder
to the right positive. Angles are rad, the body's velocity that against the air, ft/s.

Source: FlightGear, src/Network/net_fdm.hxx.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from uavftc.actuators.saturation import axis_limits
from uavftc.core.signals import SURFACES
from uavftc.flight.build import Flight

VERSION = 24
LATITUDE, LONGITUDE = math.radians(37.6136), math.radians(-122.3569)  # San Francisco, where FlightGear has scenery
ALTITUDE = 1000.0  # m, of a plant that has none
FALLBACK_STOP = math.radians(25.0)  # of a surface that has none
FT, KNOT, G = 0.3048, 1852.0 / 3600.0, 9.80665
RHO_0 = 1.225  # kg/m^3, at sea level
RADIUS, ECCENTRICITY_2 = 6378137.0, 6.69437999014e-3  # WGS 84, m
RUNNING = 2

PACKET = np.dtype(
    [
        ("version", ">u4"), ("padding", ">u4"), ("longitude", ">f8"), ("latitude", ">f8"), ("altitude", ">f8"),
        ("agl", ">f4"), ("phi", ">f4"), ("theta", ">f4"), ("psi", ">f4"), ("alpha", ">f4"), ("beta", ">f4"),
        ("attitude_rates", ">f4", 3), ("vcas", ">f4"), ("climb_rate", ">f4"), ("v_ned", ">f4", 3), ("v_body", ">f4", 3),
        ("pilot_acceleration", ">f4", 3), ("stall_warning", ">f4"), ("slip_deg", ">f4"),
        ("num_engines", ">u4"), ("engine_state", ">u4", 4), ("engines", ">f4", (9, 4)),
        ("num_tanks", ">u4"), ("fuel_quantity", ">f4", 4),
        ("num_wheels", ">u4"), ("on_ground", ">u4", 3), ("gear", ">f4", (3, 3)),
        ("time", ">u4"), ("warp", ">i4"), ("visibility", ">f4"),
        ("elevator", ">f4"), ("elevator_trim_tab", ">f4"), ("left_flap", ">f4"), ("right_flap", ">f4"),
        ("left_aileron", ">f4"), ("right_aileron", ">f4"), ("rudder", ">f4"), ("nose_wheel", ">f4"),
        ("speedbrake", ">f4"), ("spoilers", ">f4"),
    ]
)  # fmt: skip
"""As it is on the wire."""


def encoder(flight: Flight) -> Callable[[np.void], bytes]:
    """Return what turns a row of a flight, a record of `signals.row_type`, into a packet."""
    stops = stops_of(flight)
    engines = min(4, len(flight.layout.engines))
    empty = np.zeros(1, PACKET)
    empty["version"], empty["num_engines"], empty["visibility"] = VERSION, engines, 20_000.0
    empty["engine_state"][0, :engines] = RUNNING

    def encode(row: np.void) -> bytes:
        packet = empty.copy()
        one = packet[0]
        phi, theta, psi = (float(x) for x in row["x1"])
        p, q, r = (float(x) for x in row["x2"])
        known = math.isfinite(row["altitude"])
        altitude = float(row["altitude"]) if known else ALTITUDE
        north, east = (float(row["north"]), float(row["east"])) if known else (0.0, 0.0)
        one["latitude"], one["longitude"] = place(north, east, altitude)
        one["altitude"] = altitude
        one["agl"] = float(row["height"]) if known else ALTITUDE
        one["phi"], one["theta"], one["psi"] = phi, theta, psi % (2.0 * math.pi)
        turning = (q * math.sin(phi) + r * math.cos(phi)) / math.cos(theta)
        one["attitude_rates"] = (p + turning * math.sin(theta), q * math.cos(phi) - r * math.sin(phi), turning)
        if known:
            body = air_velocity(row)
            over_ground = to_north(phi, theta, psi) @ body + row["wind_n"]
            one["alpha"], one["beta"] = row["alpha"], row["beta"]
            one["vcas"] = math.sqrt(2.0 * max(0.0, float(row["qbar"])) / RHO_0) / KNOT  # equivalent, as near as needed
            one["climb_rate"] = -over_ground[2] / FT
            one["v_ned"], one["v_body"] = over_ground / FT, body / FT
            one["pilot_acceleration"] = row["load_factor"] * G / FT
        aileron, elevator, rudder = row["u2"] / stops
        one["left_aileron"], one["right_aileron"], one["elevator"], one["rudder"] = aileron, -aileron, -elevator, rudder
        return packet.tobytes()

    return encode


def stops_of(flight: Flight) -> np.ndarray:
    """Return the deflection about trim of which a packet says 1, shape (3,), rad: the larger stop of each axis."""
    reach = np.abs(axis_limits(flight.plant.u_limits, flight.layout.mixing)).max(axis=1)
    return np.array([stop if math.isfinite(stop) and stop > 0.0 else FALLBACK_STOP for stop in reach[: len(SURFACES)]])


def place(north: float, east: float, altitude: float) -> tuple[float, float]:
    """Return latitude and longitude, rad, of a place so far from the start, m, by the radii of curvature there."""
    w = math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(LATITUDE) ** 2)
    meridian, normal = RADIUS * (1.0 - ECCENTRICITY_2) / w**3, RADIUS / w
    latitude = LATITUDE + north / (meridian + altitude)
    return latitude, LONGITUDE + east / ((normal + altitude) * math.cos(LATITUDE))


def air_velocity(row: np.void) -> np.ndarray:
    """Return the velocity against the air in body axes, shape (3,), m/s."""
    speed, alpha, beta = float(row["airspeed"]), float(row["alpha"]), float(row["beta"])
    along = speed * math.cos(beta)
    return np.array([along * math.cos(alpha), speed * math.sin(beta), along * math.sin(alpha)])


def to_north(phi: float, theta: float, psi: float) -> np.ndarray:
    """Return the rotation from body axes to north, east, down, shape (3, 3)."""
    cf, sf, ct, st, cp, sp = (f(x) for x in (phi, theta, psi) for f in (math.cos, math.sin))
    return np.array(
        [
            [ct * cp, sf * st * cp - cf * sp, cf * st * cp + sf * sp],
            [ct * sp, sf * st * sp + cf * cp, cf * st * sp - sf * cp],
            [-st, sf * ct, cf * ct],
        ]
    )
