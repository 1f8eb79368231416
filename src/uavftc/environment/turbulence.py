"""Continuous turbulence, Dryden or von Karman: three velocities and three rates of the air, by seed.

With Omega = omega/V the wave number along the flight, b the span, in body axes and for Omega > 0,

    Dryden       Phi_u = sigma_u^2 (2 L_u/pi) / (1 + (L_u Omega)^2)
                 Phi_v = sigma_v^2 (L_v/pi) (1 + 3 (L_v Omega)^2) / (1 + (L_v Omega)^2)^2
    von Karman   Phi_u = sigma_u^2 (2 L_u/pi) / (1 + (1.339 L_u Omega)^2)^(5/6)
                 Phi_v = sigma_v^2 (L_v/pi) (1 + 8/3 (1.339 L_v Omega)^2) / (1 + (1.339 L_v Omega)^2)^(11/6)
    both         Phi_w as Phi_v, of sigma_w and L_w
                 Phi_p = (sigma_w^2/L_w) 0.8 (pi L_w/4b)^(1/3) / (1 + (4b Omega/pi)^2), independent of the others
                 q_g = -(dw_g/dx) / (1 + 4b s/(pi V)),    r_g = +(dv_g/dx) / (1 + 3b s/(pi V)),    d/dx = s/V

The signs are those of air that turns as a body does, v_g = omega_g x r: an updraught ahead of the nose (w_g < 0) is a
q_g > 0. sigma and L are given, or by severity (`mil_f_8785c.py`) of the height above ground at each sample; V is the
airspeed at each sample, at least `AIRSPEED_MIN`.

Each velocity is white noise through first-order sections over the length flown in units of L (`core/shaping.py`), one
more of them the lag of q_g or r_g: covariances are exact at the samples, whatever the rate, and the spread of the
states does not depend on V and L, so it stays while they change. For von Karman the power 5/6 is four sections of an
own fit, within 0.17 dB of it up to omega L/V = 2900 (the usual two of MIL-HDBK-1797 are 2.9 dB below at 127).

The velocity is turned to north-east-down by the attitude and added to `wind_n`, the rates are added to `gust_rates`.
They turn the vehicle by d2 = -A [p_g q_g r_g], A the change of [p_dot q_dot r_dot] with [p q r] measured at the trim:
the aerodynamic rates are those of the vehicle less those of the air. That is approximate: A is that of the trim's
airspeed, and holds what turns with the vehicle and not with the air, such as a gyroscopic moment of the engines.

The states are drawn from their stationary distribution, and what they give fades in and out by (1 - cos)/2 over
`fade_s` at either end of the window, so that no step of wind strikes the vehicle. Nothing goes on after the window.

Sources: MIL-F-8785C 3.7; MIL-HDBK-1797 (1997), appendix A, 4.9.2.
"""

from __future__ import annotations

from math import cos, pi, sqrt
from typing import Annotated, Literal

import numpy as np
from pydantic import model_validator

from uavftc.config.labels import each
from uavftc.config.values import Flag, NonNegative, Positive, Problem, Window, list_of, refusal
from uavftc.core.given import Given
from uavftc.core.kinematics import to_north_east_down
from uavftc.core.linear3 import multiply
from uavftc.core.random import key
from uavftc.core.shaping import SECTIONS, WORK, move, output
from uavftc.core.stage import Block, Stage, law, params_of
from uavftc.environment import air
from uavftc.environment.mil_f_8785c import LENGTH_M, SIGMA_MPS, WIND_20_FT_MPS, scales

ENTRY_OF = "disturbances"
FIELDS, REFUSED_ON = ("wind_n", "gust_rates", "d2"), air.REFUSED_ON

AIRSPEED_MIN = 1.0  # m/s
LONG = 1e4  # scale lengths: a step after which nothing of the state before is left

DRYDEN = {"u": ((1.0, 0.0),), "v": ((1.0, 0.0), (1.0, sqrt(3.0)))}
"""Time constants of lag and lead of each section, in L/V."""

VON_KARMAN_L = 1.339  # of MIL-F-8785C, in front of L
_FRACTION = ((0.859398, 0.0), (0.0971301, 0.146086), (0.00824238, 0.0124401), (0.000677172, 0.0010394))
"""Lag and lead of (1 + s)^(-5/6): the least largest deviation in dB, over 0 <= s/i <= 4000."""
_SCALED = tuple((VON_KARMAN_L * lag, VON_KARMAN_L * lead) for lag, lead in _FRACTION)
VON_KARMAN = {"u": _SCALED, "v": (*_SCALED, (VON_KARMAN_L, VON_KARMAN_L * sqrt(8.0 / 3.0)))}

PARAMS = np.dtype(
    [
        ("h", "f8"),  # sample time, s
        ("start", "f8"),  # s
        ("end", "f8"),  # s
        ("fade", "f8"),  # s
        ("by_height", "f8"),  # 1 by severity, 0 as given
        ("sigma", "f8", (3,)),  # as given, m/s
        ("length", "f8", (3,)),  # as given, m
        ("wind_20_ft", "f8"),  # of the severity, m/s
        ("curve", "f8", SIGMA_MPS["light"].shape),  # sigma of the severity over altitude, m/s
        ("length_high", "f8"),  # L of medium and high altitude, m
        ("n", "i8", (3,)),  # sections of u, v and w, those of q and r included
        ("rates", "f8", (3, SECTIONS)),  # 1/L
        ("leads", "f8", (3, SECTIONS)),
        ("span", "f8"),  # b, m; 0 without rates
        ("A", "f8", (3, 3)),  # change of [p_dot q_dot r_dot] with [p q r], 1/s
        ("keys", "u8", (4,)),  # of the noise of u, v, w, p
    ]
)
STATE = np.dtype(
    [
        ("counter", "i8"),  # of the next normal numbers
        ("x", "f8", (4, SECTIONS)),  # of u, v, w, p
        ("rates", "f8", (SECTIONS,)),  # of the component at hand
        ("one", "f8", (SECTIONS,)),  # 1, the rate of p
        ("work", *WORK),
    ]
)


Velocities = Annotated[
    tuple[NonNegative, NonNegative, NonNegative], list_of(3, "a list of three numbers >= 0: [u, v, w]")
]
Lengths = Annotated[tuple[Positive, Positive, Positive], list_of(3, "a list of three numbers > 0: [u, v, w]")]


class Config(Window):
    """Continuous turbulence, velocities and rates of the air: by severity (MIL-F-8785C), or by intensity and length."""

    kind: Literal["turbulence"] = "turbulence"
    model: Literal["dryden", "von-karman"] = "dryden"
    """`dryden` or `von-karman`: the form of the spectra"""
    severity: Literal["light", "moderate", "severe"] | None = None
    """`light`, `moderate` or `severe` of MIL-F-8785C: intensity and scale length are those of the height at a sample"""
    sigma_mps: Velocities | None = None
    """[u, v, w] in body axes, in place of a severity: root mean square of each velocity"""
    length_m: Lengths | None = None
    """[u, v, w], with `sigma_mps`: scale length of each velocity"""
    rotational: Flag = True
    """whether the air turns too; the moments are those of the aircraft's damping at trim, and need its span"""
    fade_s: NonNegative = 2.0
    """time over which it fades in at `start_s`, and out before `end_s`"""

    @property
    def label(self) -> str:
        """What a figure writes into its window."""
        model = {"dryden": "Dryden", "von-karman": "von Karman"}[self.model]
        if self.sigma_mps is None:
            return f"{self.severity} {model} turbulence"
        return f"{model} turbulence, {each(self.sigma_mps, 'm/s')} rms"

    @model_validator(mode="after")
    def _one_of_two(self) -> Config:
        given = [name for name in ("severity", "sigma_mps", "length_m") if getattr(self, name) is not None]
        if given in (["severity"], ["sigma_mps", "length_m"]):
            return self
        found = " and ".join(given) or "neither severity nor sigma_mps and length_m"
        remedy = "give severity: light, moderate or severe; or sigma_mps: [u, v, w] with length_m: [u, v, w]"
        raise refusal([Problem((given[0] if given else "severity",), found, "one way to say how strong it is", remedy)])


@law
def component(p, s, c, sigma, length, step, lag):
    """Move a velocity, c = 0, 1, 2 of u, v, w, by a step, m; return it over sigma, and the same behind a lag, m.

    sigma does not come in; a lag of 0 is none.
    """
    n = p.n[c]
    for i in range(n):
        s.rates[i] = p.rates[c, i]
    if lag > 0.0:
        s.rates[n - 1] = length / lag
    move(s.x[c], s.rates, p.leads[c], n, step / length, p.keys[c], s.counter, s.work)
    if lag > 0.0:
        return output(s.x[c], p.leads[c], n - 1), s.x[c, n - 1]
    return output(s.x[c], p.leads[c], n), 0.0


@law
def step(p, s, row):
    """Add the velocity of the air to wind_n, its rates to gust_rates and what they do to d2."""
    if row.t < p.start or row.t >= p.end:
        return
    sigma_u, sigma_v, sigma_w = p.sigma[0], p.sigma[1], p.sigma[2]
    L_u, L_v, L_w = p.length[0], p.length[1], p.length[2]
    if p.by_height != 0.0:
        sigma_v, sigma_w, L_v, L_w = scales(row.height, p.wind_20_ft, p.curve, p.length_high)
        sigma_u, L_u = sigma_v, L_v
    speed = row.airspeed if row.airspeed > AIRSPEED_MIN else AIRSPEED_MIN
    flown = LONG * max(L_u, L_v, L_w, p.span) if s.counter == 0 else speed * p.h  # m
    u, _ = component(p, s, 0, sigma_u, L_u, flown, 0.0)
    v, v_behind = component(p, s, 1, sigma_v, L_v, flown, 3.0 * p.span / pi)
    w, w_behind = component(p, s, 2, sigma_w, L_w, flown, 4.0 * p.span / pi)
    fade = 1.0
    if min(row.t - p.start, p.end - row.t) < p.fade:
        fade = 0.5 * (1.0 - cos(pi * min(row.t - p.start, p.end - row.t) / p.fade))
    wind = to_north_east_down(row.x1, (fade * sqrt(2.0) * sigma_u * u, fade * sigma_v * v, fade * sigma_w * w))
    for i in range(3):
        row.wind_n[i] += wind[i]
    if p.span > 0.0:
        b = p.span
        s.one[0] = 1.0
        move(s.x[3], s.one, s.one, 1, flown * pi / (4.0 * b), p.keys[3], s.counter, s.work)
        sigma_p = sigma_w * sqrt(0.8 * (pi * L_w / (4.0 * b)) ** (1.0 / 3.0) * pi**2 / (8.0 * b * L_w))
        rates = (
            fade * sigma_p * sqrt(2.0) * s.x[3, 0],
            -fade * sigma_w * pi / (4.0 * b) * (w - w_behind),
            fade * sigma_v * pi / (3.0 * b) * (v - v_behind),
        )
        turned = multiply(p.A, rates)
        for i in range(3):
            row.gust_rates[i] += rates[i]
            row.d2[i] -= turned[i]
    s.counter += SECTIONS


stage = Stage(
    step,
    PARAMS,
    STATE,
    reads=["t", "height", "airspeed", "x1", "wind_n", "gust_rates", "d2"],
    writes=["wind_n", "gust_rates", "d2"],
)


def problems(entry: Config, given: Given) -> list[Problem]:
    """Return what the turning of the air needs and the aircraft does not say."""
    if not entry.rotational or given.span_m is not None:
        return []
    expected = f"the wing span of {given.design.name}, by which the turning of the air is filtered"
    remedy = "give mass_properties.span_m in aircraft.yaml or metrics/wingspan in the XML, or set rotational: false"
    return [Problem(("rotational",), "true, for an aircraft without a span", expected, remedy)]


def blocks(config: tuple[Config, ...], given: Given) -> list[Block]:
    """Return the air of each entry, each of its own noise."""
    return [stage.block(params(entry, given, i), name=air.name("turbulence", i)) for i, entry in enumerate(config)]


def params(entry: Config, given: Given, place: int) -> np.ndarray:
    """Return the parameters of an entry, the `place`-th of its kind."""
    severity = entry.severity or "light"
    sections = DRYDEN if entry.model == "dryden" else VON_KARMAN
    rates, leads, n = np.ones((3, SECTIONS)), np.zeros((3, SECTIONS)), np.zeros(3, dtype=int)
    for c, own in enumerate((sections["u"], sections["v"], sections["v"])):
        n[c] = len(own) + (entry.rotational and c > 0)
        for i, (lag, lead) in enumerate(own):
            rates[c, i], leads[c, i] = 1.0 / lag, lead / lag
    return params_of(
        PARAMS,
        h=given.h,
        start=entry.start_s,
        end=np.inf if entry.end_s is None else entry.end_s,
        fade=entry.fade_s,
        by_height=float(entry.severity is not None),
        sigma=np.array(entry.sigma_mps or np.zeros(3)),
        length=np.array(entry.length_m or np.ones(3)),
        wind_20_ft=WIND_20_FT_MPS[severity],
        curve=SIGMA_MPS[severity],
        length_high=LENGTH_M[entry.model],
        n=n,
        rates=rates,
        leads=leads,
        span=(given.span_m or 0.0) if entry.rotational else 0.0,
        A=given.design.A,
        keys=np.array([key(given.seed, "turbulence", 4 * place + c) for c in range(4)], dtype=np.uint64),
    )
