"""The analytic plant: the paper's rotational model, eqs. (1) to (7).

    x1' = g1(x1) x2 + d1
    x2' = gyroscopic(x2) + A_l x2 + B_m u2 + d2

with u2 the deflections after saturation and faults. A_l and B_m are the linear pair of the aircraft's companion file
(for hale A_l = A_m: the only linear pair that the paper prints). Integrated by the classical Runge-Kutta rule of
fourth order, the inputs held over a plant step.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from uavftc.core.kinematics import attitude_rates
from uavftc.core.linear3 import multiply
from uavftc.core.program import Program
from uavftc.core.stage import NOTHING, Block, Stage, law, params_of
from uavftc.plants.interface import Timing
from uavftc.plants.mass import damaged, piece_of
from uavftc.plants.rigid_body import coefficients, gyroscopic
from uavftc.plants.schedule import Schedule, Struck

PARAMS = np.dtype(
    [
        ("dt", "f8"),  # plant step, s
        ("c", "f8", (9,)),  # coefficients of eq. (2)
        ("A_l", "f8", (3, 3)),  # 1/s
        ("B_m", "f8", (3, 3)),  # 1/s^2
    ]
)
STATE = np.dtype([("x1", "f8", (3,)), ("x2", "f8", (3,))])  # rad, rad/s


@law
def derivative(p, x1, x2, u2, d1, d2):
    """Return (x1_dot, x2_dot), three values each, rad/s and rad/s^2 (eq. 7)."""
    kinematic = attitude_rates(x1, x2)
    coupling = gyroscopic(p.c, x2)
    damping = multiply(p.A_l, x2)
    control = multiply(p.B_m, u2)
    return (
        (kinematic[0] + d1[0], kinematic[1] + d1[1], kinematic[2] + d1[2]),
        (
            coupling[0] + damping[0] + control[0] + d2[0],
            coupling[1] + damping[1] + control[1] + d2[1],
            coupling[2] + damping[2] + control[2] + d2[2],
        ),
    )


@law
def moved(x, x_dot, h):
    """Return x + h x_dot, three values."""
    return x[0] + h * x_dot[0], x[1] + h * x_dot[1], x[2] + h * x_dot[2]


@law
def observe(p, s, row):
    """Write the state into the row; a rotational model has no air data."""
    for i in range(3):
        row.x1[i] = s.x1[i]
        row.x2[i] = s.x2[i]
        row.wind_n[i] = np.nan
        row.gust_rates[i] = np.nan
    row.airspeed = np.nan
    row.altitude = np.nan
    row.height = np.nan
    row.alpha = np.nan
    row.beta = np.nan
    row.throttle = np.nan
    row.contact = 0.0
    row.north = np.nan
    row.east = np.nan
    row.qbar = np.nan
    for i in range(3):
        row.load_factor[i] = np.nan


@law
def step(p, s, row):
    """Advance the state by one Runge-Kutta step under the deflections of the row."""
    dt, u2, d1, d2 = p.dt, row.u2, row.d1, row.d2
    x1 = (s.x1[0], s.x1[1], s.x1[2])
    x2 = (s.x2[0], s.x2[1], s.x2[2])
    a1, a2 = derivative(p, x1, x2, u2, d1, d2)
    b1, b2 = derivative(p, moved(x1, a1, 0.5 * dt), moved(x2, a2, 0.5 * dt), u2, d1, d2)
    c1, c2 = derivative(p, moved(x1, b1, 0.5 * dt), moved(x2, b2, 0.5 * dt), u2, d1, d2)
    e1, e2 = derivative(p, moved(x1, c1, dt), moved(x2, c2, dt), u2, d1, d2)
    for i in range(3):
        s.x1[i] = x1[i] + dt / 6.0 * (a1[i] + 2.0 * b1[i] + 2.0 * c1[i] + e1[i])
        s.x2[i] = x2[i] + dt / 6.0 * (a2[i] + 2.0 * b2[i] + 2.0 * c2[i] + e2[i])


VEHICLE = [
    "x1", "x2", "wind_n", "gust_rates", "airspeed", "altitude", "height", "alpha", "beta", "throttle", "contact",
    "north", "east", "qbar", "load_factor",
]  # fmt: skip
"""What a plant writes of the vehicle as it is."""
UNKNOWN = tuple(name for name in VEHICLE if name not in ("x1", "x2", "contact"))
"""Of these, what a rotational model does not know; it is nan."""

observe_stage = Stage(observe, NOTHING, STATE, reads=[], writes=VEHICLE)
stage = Stage(step, PARAMS, STATE, reads=["u2", "d1", "d2"], writes=[])


def struck_model(
    J: np.ndarray, A_l: np.ndarray, B_m: np.ndarray, damage: Sequence[Any]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return J, A_l and B_m with entries of damage: the moments stay as they are, and J is another."""
    if not damage:
        return J, A_l, B_m
    now = damaged(1.0, J, [piece_of(entry, 1.0) for entry in damage]).inertia  # of no other mass
    return of_another_inertia(J, A_l, B_m, now)


def of_another_inertia(
    J: np.ndarray, A_l: np.ndarray, B_m: np.ndarray, now: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the model of a vehicle with the same moments and another inertia, `now`: all shape (3, 3)."""
    ratio = np.linalg.solve(now, J)
    return now, ratio @ A_l, ratio @ B_m


class AnalyticPlant:
    """The model as a plant; it starts at the attitude of the trim and at zero rates, which is a trim of this model.

    Parameters
    ----------
    inertia
        J, shape (3, 3), kg m^2, matrix signs.
    A_l, B_m
        Linear pair, shape (3, 3), 1/s and 1/s^2.
    timing
        Sample time and substeps.
    x1_trim, u_limits
        Attitude at trim, shape (3,), rad, and the mechanical stops about trim, shape (3, 2), rad.
    damage
        What strikes the vehicle itself, and at which rows: changes of J.
    """

    takes_end = False

    def __init__(
        self,
        inertia: np.ndarray,
        A_l: np.ndarray,
        B_m: np.ndarray,
        timing: Timing,
        *,
        x1_trim: np.ndarray | None = None,
        u_limits: np.ndarray | None = None,
        damage: Sequence[Struck] = (),
    ) -> None:
        self.x1_trim = np.zeros(3) if x1_trim is None else x1_trim
        self.u_limits = np.array([[-np.inf, np.inf]] * 3) if u_limits is None else u_limits
        self.settings: dict[str, Any] = {
            "integrator": "Runge-Kutta 4",
            "step_s": timing.plant_step,
        }
        self.program_substeps = timing.substeps
        self._state = np.zeros(1, STATE)
        self._state["x1"] = self.x1_trim
        self._params = params_of(
            PARAMS,
            dt=timing.plant_step,
            c=coefficients(inertia),
            A_l=A_l,
            B_m=B_m,
        )
        self._undamaged = np.array(inertia), np.array(A_l), np.array(B_m)
        self._struck: list[Any] = []
        changes = [(d.end, functools.partial(self._strike, d.entry, begins=False)) for d in damage]
        changes += [(d.first, functools.partial(self._strike, d.entry, begins=True)) for d in damage]
        self._schedule = Schedule(changes) if damage else None

    def _strike(self, entry: Any, *, begins: bool) -> None:
        """Begin or end a damage: moments stay as they are, J is another."""
        if begins:
            self._struck.append(entry)
        else:
            self._struck = [other for other in self._struck if other is not entry]
        J, A_l, B_m = struck_model(*self._undamaged, self._struck)
        self._params["c"], self._params["A_l"], self._params["B_m"] = coefficients(J), A_l, B_m

    def before(self) -> list[Block]:
        """Return the block that writes the state into the row."""
        return [observe_stage.block(state=self._state, name="observe")]

    def given(self) -> list[Block]:
        """Return nothing: the model reads what it is given from the row."""
        return []

    def after(self) -> list[Block]:
        """Return the block that integrates over a plant step."""
        return [stage.block(self._params, self._state, name="plant")]

    def look(self) -> None:
        """Do nothing: the state is there."""

    def run(self, program: Program, rows: np.ndarray, first: int, last: int) -> int:
        """Fly rows `first` to `last - 1` in one compiled call, or in one more for each change of J."""
        if self._schedule is not None:
            return self._schedule.fly(Program.run, program, rows, first, last)
        return program.run(rows, first, last)
