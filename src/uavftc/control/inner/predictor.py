"""Inner loop, state predictor and projected adaptive laws: eqs. (30) and (31).

    x2_hat'    = A_m x2_hat + B_m (omega_hat v_ad + W_hat^T Phi + eps_hat) + K_1 x2_tilde,  x2_tilde = x2_hat - x2
    omega_hat' = Gamma proj(omega_hat, -(x2_tilde^T P B_m) v_ad)        one factor a channel
    W_hat'     = Gamma proj(W_hat,     -Phi (x2_tilde^T P B_m))
    eps_hat'   = Gamma proj(eps_hat,   -(x2_tilde^T P B_m))
    A_s^T P + P A_s = -Q,   A_s = A_m + K_1

Sampled form. Gamma = 1e5 makes these equations stiff (1.6 to 4.4 krad/s), and a flight computer runs them at a fixed
rate, so the step is taken implicitly (backward Euler in x2_tilde and the estimates, the regressors v_ad and Phi being
those applied over the step). Inserting the adaptive laws into the predictor leaves one 3x3 system:

    [ I - h A_s + h^2 Gamma B_m diag(1 + Phi^T Phi + v_i^2) B_m^T P ] x2_tilde
        = x2_hat_old - x2 + h ( A_m x2 + B_m (omega_hat v_ad + W_hat^T Phi + eps_hat) )

It is stable at every sample rate. Forward Euler (`explicit`), in which x2_tilde of the old sample drives everything,
is available to show its effect: with Gamma = 1e5 it needs steps far below 1 ms. The projection keeps each estimate
inside its bounds after the step; for a box that is the nearest admissible point, which is what the continuous operator
of the paper's [35] tends to.

Limits (`anti_windup: limited`). As printed, predictor and adaptive laws are given the command v_ad that the law asks
for. A surface at its limit does less, the estimates make up for the difference by asking for more, and the command
runs away from the surface for as long as the limit holds (windup). With `limited` they are given what the surface can
do: the command is cut off inside the law, and v_ad is what is then left of it,

    v2_i = min(max(v_ad_i - (K_0^T x2)_i, v_min_i), v_max_i),   v_ad_i = v2_i + (K_0^T x2)_i

with the limits from `Given.design.limits_rad`: saturation, servos and stops, whichever is closest. The paper has no
such term (it leaves saturation to the adaptation), so `none`, as printed, is the default. Faults are not known to the
law: it counts with the limits of the healthy surface.

Fewer axes. Where an axis is not controlled (`Given.axes`), the law is that of the others: A_m, B_m, K_1, Q and K_0 are
cut down to their rows and columns, P and K follow from what is left, and all of it is put back into 3x3 with zeros for
the missing axis. So x2_tilde of that axis drives nothing, its estimates stay where they start, and its command is zero.
What the third rate does to the two is for the adaptation (docs/theory.md, "Fewer axes").

The functions here are shared by the laws that use a predictor (`l1.py`, `mrac.py`): their records hold the fields of
`PREDICTOR_PARAMS` and `PREDICTOR_STATE`.
"""

from __future__ import annotations

import functools
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, field_serializer, model_validator
from pydantic_core import PydanticCustomError

from uavftc.config.values import Matrix3, Model, Number, Positive, list_of, refusal
from uavftc.control.gains import lyapunov_P, reference_gain
from uavftc.control.inner.matrices import hurwitz, invertible, is_hurwitz, positive_definite, refuse_reduced
from uavftc.control.rbf import NODES, Rbf
from uavftc.core.axes import Controlled, embedded, masked, reduced
from uavftc.core.given import Given
from uavftc.core.linear3 import multiply, multiply_transposed, solve
from uavftc.core.stage import law

PREDICTOR_PARAMS = [
    ("h", "f8"),  # sample time, s
    ("A_m", "f8", (3, 3)),  # reference model, 1/s
    ("B_m", "f8", (3, 3)),  # input matrix, 1/s^2
    ("A_s", "f8", (3, 3)),  # A_m + K_1
    ("P_B_m", "f8", (3, 3)),  # P B_m
    ("Gamma", "f8"),  # adaptation gain
    ("explicit", "f8"),  # 0: the implicit step; 1: forward Euler, to show what it does
    ("omega_min", "f8"),  # projection bounds of omega_hat
    ("omega_max", "f8"),
    ("W_max", "f8"),  # bound of |W_hat|, each element, rad
    ("eps_max", "f8"),  # bound of |eps_hat|, each element, rad
    ("centres", "f8", (NODES,)),
    ("width", "f8"),
    ("psi_0", "f8"),  # heading at the start, rad
    ("axes", "f8", (3,)),  # 1 where the axis is controlled
    ("v_min", "f8", (3,)),  # limits of v2 inside the law, rad; infinite where it is left as printed
    ("v_max", "f8", (3,)),
]
PREDICTOR_STATE = [
    ("started", "f8"),
    ("x2_hat", "f8", (3,)),  # rad/s
    ("x2", "f8", (3,)),  # previous measurement, rad/s
    ("x2_tilde", "f8", (3,)),  # rad/s
    ("omega_hat", "f8", (3,)),
    ("W_hat", "f8", (NODES, 3)),  # rad
    ("eps_hat", "f8", (3,)),  # rad
    ("v_ad", "f8", (3,)),  # adaptive command applied over the step, rad
    ("Phi", "f8", (NODES,)),  # regressor of the previous sample
    ("M", "f8", (3, 3)),  # matrix of the implicit step
]


A_M = ((-8.5, 1.2, -3.5), (-1.5, -1.5, -1.0), (-0.02, 0.0, -2.0))  # 1/s, paper section 4
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZEROS = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
UNLIMITED = np.array([[-np.inf, np.inf]] * 3)  # rad
BOUNDS = "[lower, upper] with 0 < lower <= 1 <= upper and lower < upper"


def _bounds(value: tuple[float, float]) -> tuple[float, float]:
    """The estimate of the effectiveness starts at 1, so 1 must lie within its bounds."""
    if not 0 < value[0] <= 1 <= value[1] or value[0] == value[1]:
        raise PydanticCustomError("shape", "{expected}", {"expected": BOUNDS})
    return value


class PredictorConfig(Model):
    """What the laws over a predictor share: state predictor and adaptive laws of eqs. (28)-(31)."""

    adaptation_gain: Positive = 1e5
    """Gamma, > 0"""
    A_m: Matrix3 = A_M
    """3x3, 1/s, desired dynamics of the body rates; A_m + K_1 must be Hurwitz"""
    K_1: Matrix3 = IDENTITY
    """3x3, 1/s, feedback of the prediction error"""
    Q: Matrix3 = IDENTITY
    """3x3, symmetric positive definite, right side of the Lyapunov equation for P"""
    B_m: Matrix3 | None = None
    """3x3, 1/s^2, invertible (condition number below 1e8); `null` is the aircraft's"""
    K_0: Matrix3 = ZEROS
    """3x3, s, v2 = -K_0^T x2 + v_ad"""
    effectiveness_bounds: Annotated[tuple[Number, Number], list_of(2, BOUNDS), AfterValidator(_bounds)] = (0.1, 2.0)
    """bounds of the estimated effectiveness, 0 < lower <= 1 <= upper"""
    weight_bound: Positive = 50.0
    """bound of the network weights, rad, > 0"""
    offset_bound: Positive = 50.0
    """bound of the estimated offset eps_hat, rad, > 0"""
    reference_gain: Literal["plant", "printed"] = "plant"
    """`plant`: K = B_m^-1 A_m, which gives unit gain from commanded to flown rate; `printed`: K_2 = B_m^-1 A_s"""
    integration: Literal["implicit", "explicit"] = "implicit"
    """how predictor and adaptive laws are sampled: `implicit`, stable at every rate; `explicit`, forward Euler, to show
    what it does (give it `rate_hz: 1000`)"""
    anti_windup: Literal["none", "limited"] = "none"
    """`none`: predictor and filter are given the command as asked for, as printed; `limited`: as cut off by saturation,
    servos and stops, so that it does not run away while a surface is at its limit"""
    rbf: Rbf = Rbf()
    """network of the inner loop"""

    @model_validator(mode="after")
    def _matrices(self) -> PredictorConfig:
        problems = [*hurwitz(self.A_m, self.K_1), *positive_definite(self.Q), *invertible(self.B_m)]
        if problems:
            raise refusal(problems)
        return self

    @field_serializer("B_m")
    def _of_the_aircraft(self, B_m: Matrix3 | None) -> Matrix3 | None:
        """Leave the matrix of an aircraft that lacks an axis to the aircraft: it has no inverse."""
        return None if B_m is None or not np.all(np.any(np.array(B_m), axis=0)) else B_m

    def warnings(self, rate_hz: float) -> list[tuple[str, str]]:
        """Return (key, line) of what is allowed and worth knowing, at a sample rate, Hz."""
        found = []
        if not is_hurwitz(np.array(self.A_m)):
            found.append(("A_m", "not Hurwitz, the body rates are asked to follow an unstable model"))
        if self.integration == "explicit" and rate_hz < 1000:
            found.append(("integration", "explicit below 1000 Hz diverges; it exists to show that"))
        return found


def _rows(matrix: Any) -> Any:
    """Return a matrix as tuples, which can be looked up, whatever it was given as; None stays."""
    return None if matrix is None else tuple(tuple(map(float, row)) for row in matrix)


@functools.lru_cache(maxsize=64)
def _designed(
    A_m: Matrix3, B_m: Matrix3 | None, K_1: Matrix3, Q: Matrix3, gain: str, axes: Controlled
) -> tuple[np.ndarray, ...]:
    """Return A_m, B_m, A_s, P B_m and K of the controlled axes, shape (3, 3) each; kept, since flights share them."""
    own_A_m, own_B_m = reduced(np.array(A_m), axes), reduced(np.array(B_m), axes)
    A_s = reduced(np.array(A_m) + np.array(K_1), axes)
    refuse_reduced(A_s, own_B_m, axes)
    P_B_m = lyapunov_P(A_s, reduced(np.array(Q), axes)) @ own_B_m
    K = reference_gain(own_A_m if gain == "plant" else A_s, own_B_m)
    found = tuple(embedded(matrix, axes) for matrix in (own_A_m, own_B_m, A_s, P_B_m, K))
    for matrix in found:
        matrix.flags.writeable = False
    return found


def predictor_params(config: PredictorConfig, given: Given) -> dict[str, Any]:
    """Return the values of `PREDICTOR_PARAMS`, K and K_0; the gains are computed from the design matrices here.

    Raises
    ------
    InputError
        If the part of B_m or of A_m + K_1 that belongs to the controlled axes cannot be used.
    """
    axes = given.axes
    matrices = map(_rows, (config.A_m, config.B_m, config.K_1, config.Q))
    A_m, B_m, A_s, P_B_m, K = _designed(*matrices, config.reference_gain, axes)
    limits = given.design.limits_rad if config.anti_windup == "limited" else UNLIMITED
    return {
        "h": given.h,
        "A_m": A_m,
        "B_m": B_m,
        "A_s": A_s,
        "P_B_m": P_B_m,
        "Gamma": config.adaptation_gain,
        "explicit": float(config.integration == "explicit"),
        "omega_min": config.effectiveness_bounds[0],
        "omega_max": config.effectiveness_bounds[1],
        "W_max": config.weight_bound,
        "eps_max": config.offset_bound,
        "centres": config.rbf.centres,
        "width": config.rbf.width,
        "psi_0": given.psi_0,
        "axes": np.array(axes, float),
        "v_min": limits[:, 0],
        "v_max": limits[:, 1],
        "K": K,
        "K_0": masked(np.array(config.K_0), axes),
    }


@law
def clipped(value, low, high):
    """Return the value limited to [low, high]; nan stays nan."""
    return low if value < low else (high if value > high else value)


@law
def start(s, x2):
    """Begin: the predictor at the measurement, no uncertainty assumed, no command."""
    for i in range(3):
        s.x2_hat[i] = x2[i]
        s.x2[i] = x2[i]
        s.omega_hat[i] = 1.0
    s.started = 1.0


@law
def limited(p, s, i, feedback):
    """Return channel i of v2 = v_ad - feedback within its limits, rad, and keep in v_ad what is applied of it."""
    asked = s.v_ad[i] - feedback
    v2 = clipped(asked, p.v_min[i], p.v_max[i])
    if v2 != asked:  # or v_ad would be rounded where nothing is cut off
        s.v_ad[i] = v2 + feedback
    return v2


@law
def lumped(s, i):
    """Return channel i of W_hat^T Phi + eps_hat, rad."""
    total = s.eps_hat[i]
    for n in range(NODES):
        total += s.W_hat[n, i] * s.Phi[n]
    return total


@law
def implicit_error(p, s, x2, input_, square):
    """Return x2_tilde at the new sample, rad/s, by the implicit step; `input_` = B_m eta_hat of the old estimates."""
    h, v = p.h, s.v_ad
    model = multiply(p.A_m, x2)
    right = (
        s.x2_hat[0] - x2[0] + h * (model[0] + input_[0]),
        s.x2_hat[1] - x2[1] + h * (model[1] + input_[1]),
        s.x2_hat[2] - x2[2] + h * (model[2] + input_[2]),
    )
    for i in range(3):
        for j in range(3):
            adapted = 0.0
            for m in range(3):
                adapted += p.B_m[i, m] * (square + v[m] * v[m]) * p.P_B_m[j, m]
            s.M[i, j] = (1.0 if i == j else 0.0) - h * p.A_s[i, j] + h * h * p.Gamma * adapted
    return solve(s.M, right)


@law
def explicit_prediction(p, s, input_):
    """Return x2_hat at the new sample, rad/s, by forward Euler: A_m x2_hat + K_1 x2_tilde = A_s x2_tilde + A_m x2."""
    h = p.h
    error = multiply(p.A_s, s.x2_tilde)
    model = multiply(p.A_m, s.x2)
    return (
        s.x2_hat[0] + h * (error[0] + model[0] + input_[0]),
        s.x2_hat[1] + h * (error[1] + model[1] + input_[1]),
        s.x2_hat[2] + h * (error[2] + model[2] + input_[2]),
    )


@law
def advance(p, s, x2):
    """Advance predictor and estimates over one step to the sample at which x2, rad/s, was measured.

    `s.v_ad` and `s.Phi` are those of the step; the caller updates both afterwards.
    """
    h, v = p.h, s.v_ad
    square = 1.0
    for n in range(NODES):
        square += s.Phi[n] * s.Phi[n]
    eta_hat = (
        s.omega_hat[0] * v[0] + lumped(s, 0),
        s.omega_hat[1] * v[1] + lumped(s, 1),
        s.omega_hat[2] * v[2] + lumped(s, 2),
    )
    input_ = multiply(p.B_m, eta_hat)
    if p.explicit != 0.0:
        driving = (s.x2_tilde[0], s.x2_tilde[1], s.x2_tilde[2])
        new = explicit_prediction(p, s, input_)
        x2_tilde = (new[0] - x2[0], new[1] - x2[1], new[2] - x2[2])
    else:
        x2_tilde = implicit_error(p, s, x2, input_, square)
        driving = x2_tilde
    rate = multiply_transposed(p.P_B_m, driving)
    for i in range(3):
        s.x2[i] = x2[i]
        s.x2_tilde[i] = x2_tilde[i]
        s.x2_hat[i] = x2[i] + x2_tilde[i]
        change = h * p.Gamma * rate[i]
        s.omega_hat[i] = clipped(s.omega_hat[i] - change * v[i], p.omega_min, p.omega_max)
        s.eps_hat[i] = clipped(s.eps_hat[i] - change, -p.eps_max, p.eps_max)
        for n in range(NODES):
            s.W_hat[n, i] = clipped(s.W_hat[n, i] - change * s.Phi[n], -p.W_max, p.W_max)
