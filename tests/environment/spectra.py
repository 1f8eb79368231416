"""Turbulence for tests: its air alone, without a vehicle, the spectra of MIL-F-8785C, and estimates of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from flying import given_of
from uavftc.core.program import Program
from uavftc.core.signals import as_records, empty_rows
from uavftc.environment import turbulence
from uavftc.plants.interface import Timing

NAMES = ("u", "v", "w", "p", "q", "r")
BANDS = np.geomspace(0.05, 5.0, 19)
"""Edges of the bands over which a spectrum is averaged, rad/s; nine to a decade."""


def air(
    seconds: float, h: float, airspeed: Any, height: Any, *, seed: int = 0, span: float = 50.0, **entry: Any
) -> np.ndarray:
    """Return velocities, m/s, and rates, rad/s, of the air at the samples, shape (n, 6), of a vehicle held level."""
    n = round(seconds / h)
    given = given_of(Timing(h, 1), n)._replace(seed=seed, span_m=span)
    (block,) = turbulence.blocks((turbulence.Config(**{"fade_s": 0, **entry}),), given)
    rows = empty_rows(n)
    records = as_records(rows)
    records["t"], records["airspeed"], records["height"] = np.arange(n) * h, airspeed, height
    assert Program([block]).run(rows, 0, n) == n
    return np.concatenate([records["wind_n"], records["gust_rates"]], axis=1)


def model(form: str, omega: np.ndarray, V: float, sigma: Any, L: Any, b: float) -> np.ndarray:
    """Return the spectra of u, v, w, p, q, r over omega > 0, rad/s, shape (6, n), per rad/s: as MIL-F-8785C prints."""
    Omega = omega / V

    def lateral(sigma: float, L: float) -> np.ndarray:
        if form == "dryden":
            return sigma**2 * L / np.pi * (1 + 3 * (L * Omega) ** 2) / (1 + (L * Omega) ** 2) ** 2
        a = 1.339 * L * Omega
        return sigma**2 * L / np.pi * (1 + 8 / 3 * a**2) / (1 + a**2) ** (11 / 6)

    if form == "dryden":
        u = sigma[0] ** 2 * 2 * L[0] / np.pi / (1 + (L[0] * Omega) ** 2)
    else:
        u = sigma[0] ** 2 * 2 * L[0] / np.pi / (1 + (1.339 * L[0] * Omega) ** 2) ** (5 / 6)
    v, w = lateral(sigma[1], L[1]), lateral(sigma[2], L[2])
    p = sigma[2] ** 2 / L[2] * 0.8 * (np.pi * L[2] / (4 * b)) ** (1 / 3) / (1 + (4 * b * Omega / np.pi) ** 2)
    q = Omega**2 / (1 + (4 * b * Omega / np.pi) ** 2) * w
    r = Omega**2 / (1 + (3 * b * Omega / np.pi) ** 2) * v
    return np.array([u, v, w, p, q, r]) / V


def folded(form: str, omega: np.ndarray, h: float, *scale: Any) -> np.ndarray:
    """Return the spectra of the samples every h, s: those of the model, folded at every multiple of 2 pi/h."""
    rate, last = 2 * np.pi / h, 300
    total = model(form, omega, *scale)
    for k in range(1, last + 1):
        total += model(form, k * rate + omega, *scale) + model(form, k * rate - omega, *scale)
    beyond = (last + 0.5) * rate * np.geomspace(1.0, 1e6, 2001)
    return total + 2 / rate * np.trapezoid(model(form, beyond, *scale), beyond)[:, None]


def variance(form: str, V: float, sigma: Any, L: Any, b: float) -> np.ndarray:
    """Return the integrals of the spectra over all omega > 0, shape (6,)."""
    omega = np.concatenate([[0.0], np.geomspace(1e-6, 1e6, 400_001)])
    return np.trapezoid(model(form, omega, V, sigma, L, b), omega)


def periodogram(x: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return omega, rad/s, and the one-sided spectrum of each column of x, shape (n, columns), by one Hann window."""
    window = np.hanning(len(x))[:, None]
    power = np.abs(np.fft.rfft(window * x, axis=0)) ** 2 * h / (np.pi * np.sum(window**2))
    return 2 * np.pi * np.fft.rfftfreq(len(x), h), power


def in_bands(omega: np.ndarray, ratio: np.ndarray, bands: np.ndarray = BANDS) -> np.ndarray:
    """Return the mean of `ratio`, shape (columns, n), between the edges `bands`, shape (columns, bands)."""
    place = np.digitize(omega, bands) - 1
    return np.array([ratio[:, place == i].mean(axis=1) for i in range(len(bands) - 1)]).T
