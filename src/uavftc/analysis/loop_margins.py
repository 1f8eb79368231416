"""Gain and delay margins of a sampled linear loop, broken at the commands of the three axes together.

With L(w) the return ratio, shape (n, n), from the deflections of the axes to what the controller answers to them,
negative feedback, and mu(w) its eigenvalues at z = exp(j w h): a factor k and a delay T, the same on every axis,
make them k exp(-j w T) mu(w), and the loop is at the edge of stability where one of these is -1 (generalised Nyquist
criterion: A. G. J. MacFarlane and I. Postlethwaite, Int. J. Control 25, 1977):

    gain margins      k = 1/|mu| where mu is real and negative
    delay margin      T = (pi + arg mu)/w where |mu| = 1, arg mu in (-pi, pi]

The plant is sampled with its input held over a sample, so the delay of that hold is in L.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm

from uavftc.core.statespace import StateSpace

POINTS = 5_000  # frequencies looked at, from `LOWEST` of the highest to the highest
LOWEST = 1e-5


class LoopMargins(NamedTuple):
    """How far a loop is from the edge of stability."""

    delay_s: float
    """The least delay that brings it there; inf where none does."""
    gain: float
    """The least factor above 1; inf where none does."""
    gain_reduction: float
    """The greatest factor below 1; 0 where none does."""
    stable: bool
    """Whether the closed loop is stable as it is; else the others say nothing."""


def held(system: StateSpace, h: float) -> StateSpace:
    """Return x' = A x + B u sampled every h, s, its input held over a sample."""
    n, m = system.B.shape
    both = expm(h * np.block([[system.A, system.B], [np.zeros((m, n + m))]]))
    return StateSpace(both[:n, :n], both[:n, n:], system.C, system.D)


def loop_margins(plant: StateSpace, controller: StateSpace, h: float) -> LoopMargins:
    """Return the margins of a sampled loop.

    Parameters
    ----------
    plant
        Sampled, from the deflections of the axes, rad, to what is measured; without feed-through.
    controller
        Sampled, from what is measured to the deflections.
    h
        Sample time, s.
    """
    frequencies = np.geomspace(LOWEST, 1.0, POINTS) * math.pi / h
    mu = _followed(_eigenvalues(plant, controller, np.exp(1j * frequencies * h)))
    ends = [
        *_steady(plant, controller),
        *mu[-1].real,
    ]  # everything is real at rest, and at half the rate of the samples
    delays, gains = [math.inf], [-1.0 / end for end in ends if end < 0.0]
    for line in mu.T:
        phase, size = np.unwrap(np.angle(line)), np.log(np.abs(line))
        for k in np.flatnonzero(np.diff(np.sign(size))):
            part = size[k] / (size[k] - size[k + 1])
            w = frequencies[k] + part * (frequencies[k + 1] - frequencies[k])
            lag = (math.pi + phase[k] + part * (phase[k + 1] - phase[k])) % (2.0 * math.pi)
            delays.append(lag / w)
        turns = (phase - math.pi) / (2.0 * math.pi)  # whole where the locus crosses the negative real axis
        for k in np.flatnonzero(np.floor(turns[1:]) != np.floor(turns[:-1])):
            part = (np.ceil(max(turns[k], turns[k + 1]) - 1.0) - turns[k]) / (turns[k + 1] - turns[k])
            gains.append(math.exp(-(size[k] + part * (size[k + 1] - size[k]))))
    return LoopMargins(
        min(delays),
        min((k for k in gains if k > 1.0), default=math.inf),
        max((k for k in gains if k < 1.0), default=0.0),
        bool(np.all(np.abs(np.linalg.eigvals(closed(plant, controller))) < 1.0)),
    )


def closed(plant: StateSpace, controller: StateSpace) -> np.ndarray:
    """Return the state matrix of the closed loop, sampled."""
    return np.block(
        [
            [plant.A + plant.B @ controller.D @ plant.C, plant.B @ controller.C],
            [controller.B @ plant.C, controller.A],
        ]
    )


def _eigenvalues(plant: StateSpace, controller: StateSpace, z: np.ndarray) -> np.ndarray:
    """Return those of the return ratio at each z, shape (points, n)."""
    return np.linalg.eigvals(-_response(controller, z) @ _response(plant, z))


def _steady(plant: StateSpace, controller: StateSpace) -> list[float]:
    """Return the real eigenvalues of the return ratio at z = 1; none where something integrates."""
    systems = [system for system in (plant, controller) if len(system.A)]
    if any(np.linalg.cond(np.eye(len(system.A)) - system.A) > 1e12 for system in systems):
        return []
    mu = _eigenvalues(plant, controller, np.ones(1))[0]
    return [float(value.real) for value in mu if value.imag == 0.0]


def _response(system: StateSpace, z: np.ndarray) -> np.ndarray:
    A, B, C, D = system
    return C @ np.linalg.solve(z[:, None, None] * np.eye(len(A)) - A, np.broadcast_to(B, (len(z), *B.shape))) + D


def _followed(mu: np.ndarray) -> np.ndarray:
    """Return the eigenvalues, shape (points, n), each column one that changes steadily from point to point."""
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415

    for k in range(1, len(mu)):
        apart = np.abs(mu[k][None, :] - mu[k - 1][:, None]) / np.abs(mu[k - 1])[:, None]
        mu[k] = mu[k][linear_sum_assignment(apart)[1]]
    return mu
