"""The L1 reference system, eq. (45), compared with a flight: how far the adaptive loop is from what it approximates.

    x_ref' = A x_ref + B_m (omega v_ref + eta_1)                x_ref(0) = x2(0)
    v_ref' = -k (omega v_ref + eta_1 + K r)                     v_ref(0) = v_ad(0)

The second line is v_ref(s) = -C(s) omega^-1 (eta_1 + K r) in time, valid for an effectiveness that changes too; the
sign of K r is that of the L1 law (`control/inner/l1.py`). A = A_s as printed, or A = A_m, the matrix of the plant (27).

eta_1 is taken from the flight as a function of time (eta_1 = eta_2, so L = 0 in Assumption 8): what the plant did
beyond A_m x2 + B_m omega v_ad,

    eta = B_m^-1 ( gyroscopic(x2) + d2 + (A_l - A_m) x2 + (B_l - B_m) u2 ) + u2 - omega v_ad

which is known on the analytic plant alone. Between samples r and the terms in x2 run linearly; d2, u2 and omega are
held, as the plant holds them. Where an axis is not controlled, the system is that of the others.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from uavftc.core.axes import ALL, Controlled, embedded, indices
from uavftc.core.program import Program
from uavftc.core.stage import Block

JUMP = 6.0  # a change from sample to sample this many times larger than around it is a discontinuity
_AROUND = 5  # samples on either side that count as around


class Replay(NamedTuple):
    """State of the inner law after each row."""

    x2_tilde: np.ndarray
    """Prediction error x2_hat - x2, shape (n, 3), rad/s."""
    v_ad: np.ndarray
    """Adaptive command, shape (n, 3), rad."""


def replay(block: Block, records: np.ndarray) -> Replay:
    """Run an inner law, fresh, over the recorded measurements and commands of its flight.

    Parameters
    ----------
    block
        The inner law, with the parameters of the flight and an unused state.
    records
        Rows of the flight from the start, shape (n,), dtype `signals.ROW`; they are not changed.

    Raises
    ------
    ValueError
        If the law does not give the recorded command v2 to the bit: the flight was another controller's.
    """
    copy = records.copy()
    copy["status"] = 0.0
    copy["v2"] = 0.0
    rows = copy.view("f8").reshape(len(copy), -1)
    program, state = Program([block]), block.state[0]
    x2_tilde, v_ad = np.empty((len(copy), 3)), np.empty((len(copy), 3))
    for k in range(len(copy)):
        program.run(rows, k, k + 1)
        x2_tilde[k], v_ad[k] = state["x2_tilde"], state["v_ad"]
    if not np.array_equal(copy["v2"], records["v2"]):
        raise ValueError("the law does not reproduce the recorded commands: the flight was another controller's")
    return Replay(x2_tilde, v_ad)


class Disturbance(NamedTuple):
    """eta = smooth + held, rad, each shape (n, 3): linear between the samples, and constant over each."""

    smooth: np.ndarray
    held: np.ndarray


def lumped_disturbance(
    records: np.ndarray,
    v_ad: np.ndarray,
    *,
    inertia: np.ndarray,
    A_l: np.ndarray,
    B_l: np.ndarray,
    A_m: np.ndarray,
    B_m: np.ndarray,
    axes: Controlled = ALL,
) -> Disturbance:
    """Return eta of a flight on the analytic plant.

    Parameters
    ----------
    records, v_ad
        The flight, shape (n,), without delay inside a sample, and the adaptive command, shape (n, 3), rad.
    inertia
        J, shape (3, 3), kg m^2, matrix signs.
    A_l, B_l
        The plant's linear pair, 1/s and 1/s^2.
    A_m, B_m
        The design's, shape (n, n) for n controlled axes.
    axes
        Which are controlled; the disturbance has their columns.
    """
    own = indices(axes)
    x2, u2 = records["x2"], records["u2"]
    gyroscopic = -np.linalg.solve(inertia, np.cross(x2, x2 @ inertia.T).T).T
    inverse = embedded(np.linalg.inv(B_m).T, axes)
    smooth = (gyroscopic + x2 @ (A_l - embedded(A_m, axes)).T) @ inverse
    held = (records["d2"] + u2 @ (B_l - embedded(B_m, axes)).T) @ inverse + u2 - records["effectiveness"] * v_ad
    return Disturbance(smooth[:, own], held[:, own])


class Reference(NamedTuple):
    """Trajectory of the reference system at the samples: rates, rad/s, and adaptive command, rad, each (n, 3)."""

    x_ref: np.ndarray
    v_ref: np.ndarray


def simulate(
    records: np.ndarray,
    eta: Disturbance,
    *,
    A: np.ndarray,
    B_m: np.ndarray,
    K: np.ndarray,
    filter_bandwidth: float,
    v_start: np.ndarray,
    axes: Controlled = ALL,
) -> Reference:
    """Return the reference system for a flight, exact for inputs linear or constant between the samples.

    Parameters
    ----------
    records
        Rows of the flight, shape (n,): t, v1 (r), x2 and effectiveness are read.
    A, B_m, K, filter_bandwidth
        As `l1_condition.norms_of`.
    v_start
        v_ref(0), shape (3,), rad.
    axes
        Which are controlled: n of them, and A, B_m, K and the columns of eta are theirs.
    """
    own = indices(axes)
    n = len(own)
    h = float(records["t"][1] - records["t"][0])
    r, omega = records["v1"][:, own], records["effectiveness"][:, own]
    u = np.hstack([r, eta.smooth + eta.held])
    # over the sample from k, eta.held keeps its value of k, also at the end
    u_end = np.hstack([r[1:], eta.smooth[1:] + eta.held[:-1]])
    x = np.empty((len(records), 2 * n))
    x[0] = np.concatenate([records["x2"][0][own], v_start[own]])
    factors, which = np.unique(omega, axis=0, return_inverse=True)
    Phi, begin, end = _first_order_hold(A, B_m, K, k=filter_bandwidth, omega=factors, h=h)
    for k, i in enumerate(which.ravel()[:-1]):
        x[k + 1] = Phi[i] @ x[k] + begin[i] @ u[k] + end[i] @ u_end[k]
    return Reference(x[:, :n], x[:, n:])


def _first_order_hold(
    A: np.ndarray, B_m: np.ndarray, K: np.ndarray, *, k: float, omega: np.ndarray, h: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return Phi, begin, end of x(t+h) = Phi x(t) + begin u(t) + end u(t+h), x = [x_ref; v_ref], u = [r; eta].

    One each for every row of omega, shape (m, n): shapes (m, 2n, 2n).
    """
    n = len(A)
    x, v, r, eta = (slice(i * n, (i + 1) * n) for i in range(4))
    state, input_, slope = slice(0, 2 * n), slice(2 * n, 4 * n), slice(4 * n, 6 * n)
    M = np.zeros((len(omega), 6 * n, 6 * n))
    M[:, x, x] = A
    M[:, x, v] = B_m * omega[:, None, :]
    M[:, v, v] = -k * omega[:, None, :] * np.eye(n)
    M[:, x, eta] = B_m
    M[:, v, r] = -k * K
    M[:, v, eta] = -k * np.eye(n)
    M *= h
    M[:, input_, slope] = np.eye(2 * n)
    E = expm(M)
    return E[:, state, state], E[:, state, input_] - E[:, state, slope], E[:, state, slope]


def assumptions_not_met(records: np.ndarray, limits: np.ndarray) -> list[str]:
    """Return what Theorem 3 and eq. (45) assume and a flight does not meet, a sentence each; empty if all is met.

    Parameters
    ----------
    records
        The flight, shape (n,), dtype `signals.ROW`.
    limits
        Limits of the command, shape (3, 2), rad; infinite where there are none.
    """
    found = []
    if over := int(np.any((records["v2"] < limits[:, 0]) | (records["v2"] > limits[:, 1]), axis=1).sum()):
        found.append(f"the saturation is active ({over} of {len(records)} samples)")
    omega = records["effectiveness"]
    if np.any(omega <= 0.0) or np.any(omega > 1.0):
        found.append(f"the effectiveness leaves (0, 1]: from {omega.min():.4g} to {omega.max():.4g}")
    if np.any(omega != omega[0]):
        found.append("the effectiveness changes during the flight: C(s) and the norms are those of a constant one")
    for field, name in (("bias", "bias v2a"), ("d2", "disturbance d2")):
        if len(where := jumps(records[field])):
            found.append(f"the {name} is discontinuous (first at t = {records['t'][where[0]]:g} s)")
    if not np.array_equal(records["x2_meas"], records["x2"]):
        found.append("the measured rates are not the true ones")
    expected = np.clip(records["v2"], limits[:, 0], limits[:, 1]) * omega + records["bias"]
    if np.max(np.abs(records["u2"] - expected)) > 1e-9:
        found.append("the surfaces do not follow the command at once (delay, or a mechanical stop)")
    return found


def jumps(signal: np.ndarray) -> np.ndarray:
    """Return the samples, sorted, at which a sampled signal, shape (n, m), is discontinuous.

    A change from one sample to the next counts when it exceeds `JUMP` times the median change of the samples around.
    """
    change = np.abs(np.diff(signal, axis=0))
    floor = 1e-9 * max(float(np.max(np.abs(signal), initial=0.0)), 1e-300)
    padded = np.pad(change, ((_AROUND, _AROUND), (0, 0)), constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _AROUND + 1, axis=0)
    around = np.nanmedian(np.delete(windows, _AROUND, axis=-1), axis=-1)
    return np.unique(np.nonzero(change > JUMP * around + floor)[0] + 1)


class Differences(NamedTuple):
    """Largest distances over a flight, of each controlled axis: rad/s and rad, shape (n,)."""

    x2: np.ndarray
    """max |x_ref - x2|."""
    v_ad: np.ndarray
    """max |v_ref - v_ad|."""


def differences(records: np.ndarray, v_ad: np.ndarray, reference: Reference, axes: Controlled = ALL) -> Differences:
    """Return the largest distances between a flight and its reference system."""
    own = indices(axes)
    return Differences(
        np.max(np.abs(reference.x_ref - records["x2"][:, own]), axis=0),
        np.max(np.abs(reference.v_ref - v_ad[:, own]), axis=0),
    )
