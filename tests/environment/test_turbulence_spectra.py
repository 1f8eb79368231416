"""Spectra and variances of the turbulence against those that MIL-F-8785C prints, by many seeds of 600 s.

| what | u, v, w, p, q, r, 0.05 to 5 rad/s |
|---|---|
| the air alone | 400 seeds, Dryden and von Karman, two airspeeds, heights, severities and spans |
| flown | 60 seeds, Dryden on hale at 30 and 40 m/s, by its own airspeed and attitude |

The air alone is sampled every 0.05 s, for the sake of time, and compared with the model folded at that rate: q and r of
von Karman, which fall slowly at high frequencies and rise from nothing at low ones, gain 3 dB at 0.05 rad/s by that.
At 200 Hz, the rate of a flight, it is below 0.2 dB, which test_turbulence.py checks of the filters in closed form.

With K independent periodograms in a band the estimate's own error is 4.34/sqrt(K) dB: 400 seeds make it 0.2 dB in the
narrowest band, 0.05 to 0.065 rad/s, and 60 seeds 0.35 dB in bands twice as wide. Run with

    python -m pytest -n 0 -m slow -s tests/environment/test_turbulence_spectra.py
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spectra import BANDS, NAMES, air, folded, in_bands, model, periodogram, variance

from uavftc.environment.mil_f_8785c import LENGTH_M, SIGMA_MPS, WIND_20_FT_MPS, scales
from uavftc.flight.build import build_flight
from uavftc.flight.fly import fly_to_memory
from uavftc.scenario.schema import Scenario

pytestmark = pytest.mark.slow

SECONDS = 600.0
H = 0.05  # s


def compared(samples, h, expected, bands=BANDS):
    """Return the largest deviation of the mean spectrum of each component from the expected one, dB, and its error."""
    total, n = 0.0, 0
    for x in samples:
        omega, power = periodogram(x, h)
        inside = (omega >= bands[0]) & (omega < bands[-1])
        total, n = total + power[inside].T / expected(omega[inside]), n + 1
    level = 10 * np.log10(in_bands(omega[inside], total / n, bands))
    narrowest = np.histogram(omega, bands)[0].min()
    return np.abs(level).max(axis=1), 4.34 / np.sqrt(n * narrowest)


def said(title, decibels, ratio, error):
    parts = (f"{name} {d:.2f} dB, {100 * (r - 1):+.1f} %" for name, d, r in zip(NAMES, decibels, ratio, strict=True))
    print(f"\n{title}: {'; '.join(parts)}; own error {error:.2f} dB")


@pytest.mark.parametrize("form", ["dryden", "von-karman"])
@pytest.mark.parametrize(
    ("V", "height", "severity", "span"), [(30.0, 1000.0, "light", 50.0), (55.0, 200.0, "moderate", 11.0)]
)
def test_the_air_alone(form, V, height, severity, span):
    sigma_v, sigma_w, L_v, L_w = scales(height, WIND_20_FT_MPS[severity], SIGMA_MPS[severity], LENGTH_M[form])
    scale = V, (sigma_v, sigma_v, sigma_w), (L_v, L_v, L_w), span
    powers = []

    def samples():
        for seed in range(400):
            x = air(SECONDS, H, V, height, seed=seed, span=span, model=form, severity=severity)
            powers.append((x**2).mean(axis=0))
            yield x

    decibels, error = compared(samples(), H, lambda omega: folded(form, omega, H, *scale))
    ratio = np.mean(powers, axis=0) / variance(form, *scale)
    said(f"{form}, {V:g} m/s, {height:g} m, {severity}", decibels, ratio, error)
    assert error < 0.3
    assert decibels.max() < 1.0
    np.testing.assert_allclose(ratio, 1.0, atol=0.05)


@pytest.mark.parametrize("V", [30.0, 40.0])
def test_flown(V):
    # lengths of a few seconds, so that 60 flights are thousands of independent samples; gentle turns, so that body axes
    # are not those of the start
    sigma, length = [0.5, 0.4, 0.3], [80.0, 60.0, 50.0]
    entry = {"kind": "turbulence", "sigma_mps": sigma, "length_m": length}
    scenario = {
        "name": "spectra", "duration_s": SECONDS + 5, "initial": {"airspeed_mps": V, "altitude_m": 1000},
        "reference": {"phi_deg": "4*sin(0.02*t)", "psi_deg": "10*sin(0.01*t)"}, "disturbances": [entry],
        "controller": {"rate_hz": 200},
    }  # fmt: skip
    powers, speeds = [], []

    def samples():
        for seed in range(60):
            flight = build_flight(Scenario.model_validate({**scenario, "seed": seed}))
            records, outcome = fly_to_memory(flight)
            assert outcome.completed
            records = records[1000::2]  # it has faded in by 2 s
            turn = Rotation.from_euler("ZYX", records["x1"][:, ::-1])
            x = np.concatenate([turn.inv().apply(records["wind_n"]), records["gust_rates"]], axis=1)
            powers.append((x**2).mean(axis=0))
            speeds.append(records["airspeed"].mean())
            yield x

    scale = V, sigma, length, 50.0
    decibels, error = compared(samples(), 0.01, lambda omega: model("dryden", omega, *scale), BANDS[::2])
    ratio = np.mean(powers, axis=0) / variance("dryden", *scale)
    said(f"flown, hale, {V:g} m/s (mean {np.mean(speeds):.2f})", decibels, ratio, error)
    assert abs(np.mean(speeds) - V) < 0.02 * V
    assert decibels.max() < 1.0
    np.testing.assert_allclose(ratio, 1.0, atol=0.05)
