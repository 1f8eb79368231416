"""The signal row: everything that is true at one sample t_k, and the names it is published under.

A flight is an array of such rows. A law reads and writes the row of the present sample in place, so the row is the
bus between the blocks and, once the sample has passed, the history. Units are SI and radians; the frame is body axes
(x forward, y right, z down) unless a field says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

AXES = ("roll", "pitch", "yaw")
SURFACES = ("aileron", "elevator", "rudder")
ANGLES, RATES = ("phi", "theta", "psi"), ("p", "q", "r")

_VEC = (3,)

ROW = np.dtype(
    [
        ("t", "f8"),  # s
        ("status", "f8"),  # 0 while flying, a code of envelope.LOST once the vehicle is lost
        # given by the scenario, sampled before the flight
        ("x1_c", "f8", _VEC),  # commanded attitude [phi, theta, psi], absolute, rad
        ("effectiveness", "f8", _VEC),  # omega of eq. (6), per surface
        ("bias", "f8", _VEC),  # v_2a of eq. (6), rad, per surface
        ("d1", "f8", _VEC),  # disturbance of eq. (7) on the attitude rates, rad/s
        ("d2", "f8", _VEC),  # disturbance of eq. (7) on the angular accelerations, rad/s^2
        ("wind_n", "f8", _VEC),  # velocity of the air, north-east-down, m/s
        ("gust_rates", "f8", _VEC),  # rotation of the air [p_g, q_g, r_g], body axes, rad/s
        # the vehicle as it is
        ("x1", "f8", _VEC),  # attitude [phi, theta, psi], rad; psi continuous, not wrapped
        ("x2", "f8", _VEC),  # body rates [p, q, r], rad/s
        ("airspeed", "f8"),  # m/s, true
        ("altitude", "f8"),  # m above mean sea level
        ("alpha", "f8"),  # rad
        ("beta", "f8"),  # rad
        ("throttle", "f8"),  # 0..1
        ("contact", "f8"),  # force of the ground on the vehicle, body z, N
        ("height", "f8"),  # m above the ground
        ("north", "f8"),  # m from the start, in the plane that touches the Earth there
        ("east", "f8"),  # m, likewise
        ("qbar", "f8"),  # dynamic pressure, Pa
        ("load_factor", "f8", _VEC),  # specific force at the CG over 9.80665 m/s^2; z is -1 in level flight
        # the vehicle as the controller sees it
        ("x1_meas", "f8", _VEC),  # rad
        ("x2_meas", "f8", _VEC),  # rad/s
        # the controller
        ("d1_hat", "f8", _VEC),  # NNDO estimate of d1, eq. (9), rad/s
        ("v1", "f8", _VEC),  # commanded body rates, eq. (9), rad/s
        ("f_hat", "f8", _VEC),  # estimate of the lumped disturbance, B_m (W_f' Phi_f + eps_f), rad/s^2
        ("v2", "f8", _VEC),  # controller output: commanded deflection about trim, rad
        ("u2", "f8", _VEC),  # deflection about trim that each axis gets from its effectors, from t_k on, rad
    ]
)
"""The head of a signal row, the same in every flight; all fields are float64, so a row is also a flat buffer."""

ROW_WIDTH = ROW.itemsize // 8

EFFECTOR = np.dtype(
    [
        ("command", "f8"),  # commanded deflection about trim, rad
        ("deflection", "f8"),  # deflection about trim, from t_k on, rad; each actuator effect works on it in its turn
        ("effectiveness", "f8"),  # omega of eq. (6), given by the scenario
        ("bias", "f8"),  # v_2a of eq. (6), given by the scenario, rad
        ("position", "f8"),  # deflection with that of the trim, rad: what its command at t_k brings about
        ("servo", "f8"),  # where its servo is at t_k, about trim, rad; 0 where it has none
    ]
)
"""One effector at one sample. Behind its head a row has as many of these as the aircraft has effectors."""

ENGINE = np.dtype(
    [
        ("throttle", "f8"),  # 0..1, as it stands
        ("thrust", "f8"),  # N, along its axis
    ]
)
"""One engine at one sample; behind the effectors a row has as many of these as the aircraft has engines."""


class Shape(NamedTuple):
    """What a row has behind its head."""

    effectors: int = len(SURFACES)
    engines: int = 0
    signals: int = 0
    """Numbers of a custom controller's own."""

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return (self.engines_at + self.engines * ENGINE.itemsize) // 8 + self.signals

    @property
    def engines_at(self) -> int:
        """Byte of a row at which the engines begin."""
        return ROW.itemsize + self.effectors * EFFECTOR.itemsize


def row_type(shape: Shape = Shape()) -> np.dtype:  # noqa: B008 - immutable
    """Return the layout of a whole row: the fields of `ROW`, then `effectors`, `engines` and `signals`."""
    behind = [
        ("effectors", EFFECTOR, (shape.effectors,)),
        ("engines", ENGINE, (shape.engines,)),
        ("signals", np.dtype("f8"), (shape.signals,)),
    ]
    return np.dtype([*((name, *_described(ROW, name)) for name in ROW.names or ()), *behind])


def _described(dtype: np.dtype, name: str) -> tuple[np.dtype, tuple[int, ...]]:
    fields: Mapping[str, Any] = dtype.fields or {}
    return fields[name][0].base, fields[name][0].shape


class Column(NamedTuple):
    """One published column of the history: its name with unit, and the row field and component it is taken from.

    With an effector, the field is that of its record, and the column is sign * (offset + field). With an engine, it is
    that of the engine's. With weights, the column is the weighted sum of the components of a vector.
    """

    name: str
    field: str
    component: int | None
    effector: int | None = None
    sign: float = 1.0
    offset: float = 0.0
    engine: int | None = None
    weights: tuple[float, float, float] | None = None


def _vector(field: str, names: tuple[str, ...]) -> list[Column]:
    return [Column(name, field, i) for i, name in enumerate(names)]


COLUMNS: tuple[Column, ...] = (
    Column("time_s", "t", None),
    *_vector("x1", ("phi_rad", "theta_rad", "psi_rad")),
    *_vector("x2", ("p_radps", "q_radps", "r_radps")),
    *_vector("x1_c", ("phi_ref_rad", "theta_ref_rad", "psi_ref_rad")),
    *_vector("v1", ("p_ref_radps", "q_ref_radps", "r_ref_radps")),
    *_vector("v2", ("aileron_cmd_rad", "elevator_cmd_rad", "rudder_cmd_rad")),
    *_vector("u2", ("aileron_rad", "elevator_rad", "rudder_rad")),
    *_vector("d1_hat", ("d1_hat_phi_radps", "d1_hat_theta_radps", "d1_hat_psi_radps")),
    *_vector("f_hat", ("f_hat_p_radps2", "f_hat_q_radps2", "f_hat_r_radps2")),
    *_vector("effectiveness", ("effectiveness_aileron", "effectiveness_elevator", "effectiveness_rudder")),
    *_vector("bias", ("bias_aileron_rad", "bias_elevator_rad", "bias_rudder_rad")),
    *_vector("d1", ("d1_phi_radps", "d1_theta_radps", "d1_psi_radps")),
    *_vector("d2", ("d2_p_radps2", "d2_q_radps2", "d2_r_radps2")),
    *_vector("x1_meas", ("phi_meas_rad", "theta_meas_rad", "psi_meas_rad")),
    *_vector("x2_meas", ("p_meas_radps", "q_meas_radps", "r_meas_radps")),
    *_vector("wind_n", ("wind_north_mps", "wind_east_mps", "wind_down_mps")),
    *_vector("gust_rates", ("p_gust_radps", "q_gust_radps", "r_gust_radps")),
    Column("airspeed_mps", "airspeed", None),
    Column("altitude_m", "altitude", None),
    Column("alpha_rad", "alpha", None),
    Column("beta_rad", "beta", None),
    Column("throttle", "throttle", None),
)
"""Columns of every `history.parquet`, in order; those of the effectors of an aircraft follow (`layout.py`)."""

MORE_COLUMNS: tuple[Column, ...] = (
    Column("north_m", "north", None),
    Column("east_m", "east", None),
    Column("load_factor", "load_factor", 2, sign=-1.0),  # as pilots count it: 1 in level flight
    *_vector("load_factor", ("load_factor_x", "load_factor_y", "load_factor_z")),
    Column("dynamic_pressure_pa", "qbar", None),
)
"""Columns of every flight behind those of its effectors."""


def empty_rows(n: int, shape: Shape | int = Shape()) -> np.ndarray:  # noqa: B008 - immutable
    """Return `n` zeroed rows of a shape, or of so many effectors, shape (n, width), C-contiguous float64."""
    return np.zeros((n, (shape if isinstance(shape, Shape) else Shape(shape)).width))


def as_records(rows: np.ndarray, shape: Shape | None = None) -> np.ndarray:
    """Return the same memory as a structured array, shape (n,), its fields those of `row_type`.

    Without a shape, the rows have nothing behind their effectors.
    """
    if shape is None:
        shape = Shape((rows.shape[1] - ROW_WIDTH) * 8 // EFFECTOR.itemsize)
    return rows.view(row_type(shape))[:, 0]


def heading_near_reference(records: np.ndarray, field: str = "x1") -> np.ndarray:
    """Return psi of an attitude, shape (n,), rad, moved by whole turns to within pi of its reference."""
    psi, psi_c = records[field][:, 2], records["x1_c"][:, 2]
    turn = 2.0 * np.pi
    return psi - turn * np.round((psi - psi_c) / turn)


def attitude_error(records: np.ndarray) -> np.ndarray:
    """Return x1_c - x1, shape (n, 3), rad, with the heading error within [-pi, pi]."""
    error = records["x1_c"] - records["x1"]
    error[:, 2] = axis_error(records, 2)
    return error


def axis_error(records: np.ndarray, axis: int) -> np.ndarray:
    """Return one axis of `attitude_error`, shape (n,), rad."""
    angle = heading_near_reference(records) if axis == 2 else records["x1"][:, axis]
    return np.asarray(records["x1_c"][:, axis] - angle)


def column(records: np.ndarray, wanted: str | Column) -> np.ndarray:
    """Return one published column, shape (n,), headings wrapped to within pi of its reference.

    Raises
    ------
    KeyError
        If no column has this name.
    """
    spec = _BY_NAME[wanted] if isinstance(wanted, str) else wanted
    if spec.name in ("psi_rad", "psi_meas_rad"):
        return heading_near_reference(records, spec.field)
    if spec.effector is not None:
        return np.asarray(spec.sign * (spec.offset + records["effectors"][spec.field][:, spec.effector]))
    if spec.engine is not None:
        return np.asarray(records["engines"][spec.field][:, spec.engine])
    values = records[spec.field]
    if spec.weights is not None:
        return np.asarray(sum(weight * values[:, i] for i, weight in enumerate(spec.weights)))
    values = values if spec.component is None else values[:, spec.component]
    return values if spec.sign == 1.0 else spec.sign * values


_BY_NAME = {c.name: c for c in (*COLUMNS, *MORE_COLUMNS)}
