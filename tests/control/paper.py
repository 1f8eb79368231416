"""The paper's design data and equations in plain numpy, independent of the package: what the tests compare with."""

from __future__ import annotations

import numpy as np

from uavftc.core.given import ControlDesign, Given
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.core.stage import Stage, params_of

A_M = np.array([[-8.5, 1.2, -3.5], [-1.5, -1.5, -1.0], [-0.02, 0.0, -2.0]])
B_M = np.array([[10.0, 0.0, 0.225], [0.0, 7.5, 0.0], [1.125, 0.0, 6.75]])
K_1 = np.eye(3)
A_S = A_M + K_1
INERTIA = np.array([[52723.0, 0.0, -8435.0], [0.0, 6314.0, 0.0], [-8435.0, 0.0, 58771.0]])
CENTRES = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
WIDTH = 0.4
GAMMA = 1e5
BANDWIDTH = 60.0
P_PRINTED = np.array([[0.0906, -0.1196, 0.0086], [-0.1196, 0.7129, -0.1893], [0.0086, -0.1893, 0.6591]])
K_2_PRINTED = np.array([[-0.7528, 0.1205, -0.348], [-0.2, -0.0667, -0.1333], [0.1225, -0.0201, -0.0902]])


def lyapunov(A: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """P of A'P + PA = -Q, by the Kronecker form of the equation."""
    eye = np.eye(3)
    return np.linalg.solve(np.kron(A.T, eye) + np.kron(eye, A.T), -Q.ravel()).reshape(3, 3)


P = lyapunov(A_S, np.eye(3))


def g1(x1: np.ndarray) -> np.ndarray:
    """Matrix of eq. (1)."""
    phi, theta = x1[0], x1[1]
    s, c, t = np.sin(phi), np.cos(phi), np.tan(theta)
    return np.array([[1.0, s * t, c * t], [0.0, c, -s], [0.0, s / np.cos(theta), c / np.cos(theta)]])


def phi(x1: np.ndarray, x2: np.ndarray, psi_0: float = 0.0) -> np.ndarray:
    """Basis of eq. (10), heading relative to psi_0."""
    z = np.concatenate([x1 - [0.0, 0.0, psi_0], x2])
    return np.exp(-((z - CENTRES[:, None]) ** 2).sum(axis=1) / (2.0 * WIDTH**2))


def inner_params(dtype: np.dtype, **changes: object) -> np.ndarray:
    """Parameters of an inner law, those of the paper at 200 Hz with bounds that never bind, but for the changes."""
    values = {
        "h": 0.005,
        "A_m": A_M,
        "B_m": B_M,
        "A_s": A_S,
        "P_B_m": P @ B_M,
        "Gamma": GAMMA,
        "explicit": 0.0,
        "omega_min": -np.inf,
        "omega_max": np.inf,
        "W_max": np.inf,
        "eps_max": np.inf,
        "centres": CENTRES,
        "width": WIDTH,
        "psi_0": 0.0,
        "axes": np.ones(3),
        "K": np.linalg.inv(B_M) @ A_M,
        "K_0": np.zeros((3, 3)),
        "filter_bandwidth": BANDWIDTH,
        "v_min": np.full(3, -np.inf),
        "v_max": np.full(3, np.inf),
    }
    return params_of(dtype, **{k: v for k, v in (values | changes).items() if k in dtype.names})


UNLIMITED = np.array([[-np.inf, np.inf]] * 3)


def flight_of(h: float = 0.005, psi_0: float = 0.0) -> Given:
    """What a flight of the paper's aircraft gives to its laws."""
    design = ControlDesign(A_M, B_M, UNLIMITED, np.array([0.0, 0.0, psi_0]), "paper")
    return Given(
        h=h,
        plant_step=h,
        steps=4000,
        seed=0,
        effectors=("aileron", "elevator", "rudder"),
        stops_rad=UNLIMITED,
        mixing=np.eye(3),
        design=design,
    )


class Law:
    """One law and one row: set fields of `row`, call, read `row` and `state`."""

    def __init__(self, stage: Stage, params: np.ndarray, state: np.ndarray | None = None) -> None:
        block = stage.block(params, state)
        self.state = block.state[0]
        self.rows = empty_rows(1)
        self.row = as_records(self.rows)[0]
        self._program = Program([block])

    def __call__(self, **fields: object) -> np.void:
        for name, value in fields.items():
            self.row[name] = value
        assert self._program.run(self.rows, 0, 1) == 1
        return self.row
