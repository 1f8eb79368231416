"""The L1-norm condition (33), the bounds of Theorem 3 and the one of Theorem 2, as numbers.

Condition (33), in the form (54), for the reference system (46) that starts within sigma_0 and is to stay below sigma_r:

    ||G|| (L sigma_r + delta_5)  <  sigma_r - ||H C K|| r_max - sigma_in,     sigma_in = ||s (sI - A)^-1|| sigma_0

All norms are L1 norms, |.| is the largest component. s (sI - A)^-1 = I + A (sI - A)^-1 has the feed-through I: its norm
is the largest row sum of int |A e^(A t)| dt, plus 1 for the impulse.

Units: sigma_0, sigma_r and r_max in rad/s, L in rad per rad/s. G acts on eta = W_f^T Phi + eps_f, in rad of deflection;
so delta_5 is taken as the bound of eta at x = 0, in rad. (The paper names it as the bound of f_mix = B_m eta.)

Theorem 3 for a prediction error |x2_tilde| <= gamma_0:

    gamma_1 = ||H C H_s^-1|| gamma_0 / (1 - ||G|| L)                        eq. (60)
    gamma_2 = ||omega^-1 C H_s^-1|| gamma_0 + ||omega^-1 C|| L gamma_1      eq. (61)

with H_s = (sI - A_s)^-1 B_m, by which eq. (68) ties x2_tilde to eta_tilde. Two choices. Eq. (60) has ||C|| where
||H C H_s^-1|| stands here: equal if C is one scalar filter for all channels and A = A_s, as eq. (69) supposes; right in
general. H_1 = C (1/(c_0^T H)) c_0^T of eq. (61) has a meaning for one channel only; here H^-1 takes its place, which a
square B_m permits (C H^-1 is proper because C has relative degree 1).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavftc.analysis.l1_norm import l1_norm
from uavftc.analysis.linear import C_over_H, G_of, H_of, HCK_of, StateSpace, filter_C, initial_response, product

ACCURACY = 1e-9
"""Of every norm: it is never too small, and too large by no more than this."""


class Norms(NamedTuple):
    """L1 norms of one design, for one A."""

    H: float
    """Rate per deflection, 1/s."""
    G: float
    """Rate per lumped disturbance, 1/s."""
    HCK: float
    """Reference system's rate per commanded rate."""
    C: float
    """The filter."""
    initial: float
    """s (sI - A)^-1, feed-through included."""
    HCH_s: float
    """H C H_s^-1: from the prediction error to x_ref - x2."""
    CH_s: float
    """omega^-1 C H_s^-1: from the prediction error to v_ref - v_ad, s."""
    C_omega: float
    """omega^-1 C."""


def norms_of(
    A: np.ndarray,
    *,
    A_s: np.ndarray,
    B_m: np.ndarray,
    K: np.ndarray,
    filter_bandwidth: float,
    omega: np.ndarray,
    accuracy: float = ACCURACY,
) -> Norms:
    """Return the norms of the design for A = A_s (printed) or A = A_m.

    Parameters
    ----------
    A, A_s
        Shape (3, 3), 1/s.
    B_m
        Shape (3, 3), 1/s^2, invertible.
    K
        Gain of the commanded rate, shape (3, 3), rad per rad/s.
    filter_bandwidth
        k of C(s), rad/s.
    omega
        Effectiveness, constant, shape (3,), above 0.

    Raises
    ------
    ValueError
        If A is not Hurwitz.
    """
    H, C = H_of(A, B_m), filter_C(filter_bandwidth, omega)
    CH = C_over_H(C, A_s, B_m)
    inverse = np.diag(1.0 / np.asarray(omega, float))

    def norm(system: StateSpace) -> float:
        return l1_norm(system, accuracy)

    return Norms(
        H=norm(H),
        G=norm(G_of(H, C)),
        HCK=norm(HCK_of(H, C, K)),
        C=norm(C),
        initial=norm(initial_response(A)),
        HCH_s=norm(product(H, CH)),
        CH_s=norm(scaled(inverse, CH)),
        C_omega=norm(scaled(inverse, C)),
    )


def scaled(left: np.ndarray, system: StateSpace) -> StateSpace:
    """Return left system(s), without states of its own."""
    return StateSpace(system.A, system.B, left @ system.C, left @ system.D)


class Given(NamedTuple):
    """What condition and bounds are stated for; None is "not stated"."""

    sigma_0: float | None = None
    """Bound of |x2(0)|, rad/s."""
    sigma_r: float | None = None
    """Bound of |x_ref| to be shown, rad/s."""
    r_max: float | None = None
    """Bound of the commanded rates, rad/s."""
    delta_5: float | None = None
    """Bound of |eta| at x = 0, rad."""
    lipschitz: float | None = None
    """L, rad per rad/s."""
    gamma_0: float | None = None
    """Bound of |x2_tilde|, rad/s."""


class Condition(NamedTuple):
    """Condition (33)."""

    holds: bool | None
    """None where it was not stated in full, or holds the reason."""
    sigma_in: float | None
    lipschitz_max: float | None
    """It holds for every L below this one; None if for none."""
    lipschitz_max_is: str
    """What `lipschitz_max` is, or why it is None."""
    reason: str | None
    """Why it does not hold, or was not decided."""


def condition_33(norms: Norms, given: Given) -> Condition:
    """Decide condition (33) and return the largest Lipschitz constant for which it holds."""
    parts = {name: getattr(given, name) for name in ("sigma_0", "sigma_r", "r_max", "delta_5")}
    sigma_in = None if given.sigma_0 is None else norms.initial * given.sigma_0
    missing = [name for name, value in parts.items() if value is None]
    if missing:
        return Condition(
            None,
            sigma_in,
            1.0 / norms.G,
            "the supremum 1/||G||: approached for a large sigma_r, reached by none",
            "not stated: " + ", ".join(missing + ["lipschitz"] * (given.lipschitz is None)),
        )
    sigma_0, sigma_r, r_max, delta_5 = (float(value) for value in parts.values() if value is not None)
    room = sigma_r - norms.HCK * r_max - norms.initial * sigma_0
    lipschitz_max = (room / norms.G - delta_5) / sigma_r
    if lipschitz_max <= 0.0:
        left = norms.G * delta_5
        why = f"condition (33) fails for every L: {left:.4g} rad/s is not below {room:.4g} rad/s for L = 0"
        return Condition(False, sigma_in, None, why, why)
    meaning = "condition (33) holds for every L below it, with the sigma_0, sigma_r, r_max and delta_5 stated"
    if given.lipschitz is None:
        return Condition(None, sigma_in, lipschitz_max, meaning, "not stated: lipschitz")
    left = norms.G * (given.lipschitz * sigma_r + delta_5)
    holds = bool(left < room)
    reason = None if holds else f"condition (33) fails: {left:.4g} rad/s is not below {room:.4g} rad/s"
    return Condition(holds, sigma_in, lipschitz_max, meaning, reason)


class Theorem3(NamedTuple):
    """Bounds of |x_ref - x2|, rad/s, and |v_ref - v_ad|, rad."""

    gamma_1: float | None
    gamma_2: float | None
    reason: str | None
    """Why there are none."""


def theorem_3(norms: Norms, given: Given, condition: Condition | None = None) -> Theorem3:
    """Return gamma_1 and gamma_2, eqs. (60) and (61) in the form of this module.

    Where condition (33) is not stated in full, L ||G|| < 1 is asked for alone: (33) then holds for some sigma_r.
    """
    if given.gamma_0 is None or given.lipschitz is None:
        missing = [name for name in ("lipschitz", "gamma_0") if getattr(given, name) is None]
        return Theorem3(None, None, "not stated: " + ", ".join(missing))
    if norms.G * given.lipschitz >= 1.0 - 1e-12:  # at 1 to rounding
        return Theorem3(None, None, f"L ||G|| = {norms.G * given.lipschitz:.4g}, not below 1")
    if condition is not None and condition.holds is False:
        return Theorem3(None, None, condition.reason)
    gamma_1 = norms.HCH_s * given.gamma_0 / (1.0 - norms.G * given.lipschitz)
    gamma_2 = norms.CH_s * given.gamma_0 + norms.C_omega * given.lipschitz * gamma_1
    return Theorem3(gamma_1, gamma_2, None)


class Theorem2(NamedTuple):
    """Eq. (44), as printed: int |x2_tilde|^2 dt <= per_V (V(0) + V(t)) + per_e int |e_min|^2 dt, Euclidean lengths."""

    per_V: float
    """2 / (lambda_min(Q) - 1)."""
    per_e: float
    """|P B_m|^2 / (lambda_min(Q) - 1)."""

    def bound(self, V_0: float, V_t: float, e_squared: float) -> float:
        """Return the bound of int |x2_tilde|^2 dt, rad^2/s, for V of eq. (41) and int |e_min|^2 dt, rad^2 s."""
        return self.per_V * (V_0 + V_t) + self.per_e * e_squared


def theorem_2(P: np.ndarray, B_m: np.ndarray, Q: np.ndarray) -> Theorem2 | None:
    """Return Theorem 2's bound as printed, eq. (44), for a Q and the P that belongs to it, or None.

    It divides by lambda_min(Q) - 1 and so needs lambda_min(Q) > 1. The printed P is that of Q = I, for which the
    printed proof gives nothing and `theorem_2_weighted` does. P grows with Q: Q = 2 I with
    Gamma is the law of Q = I with 2 Gamma.
    """
    margin = float(np.linalg.eigvalsh(Q)[0]) - 1.0
    if margin <= 1e-12:
        return None
    return Theorem2(2.0 / margin, float(np.linalg.norm(P @ B_m, 2)) ** 2 / margin)


class Theorem2Weighted(NamedTuple):
    """int |x2_tilde|^2 dt <= per_V V(0) + per_e int |e_min|^2 dt, Euclidean lengths, for any Q > 0."""

    per_V: float
    """4 / lambda_min(Q)."""
    per_e: float
    """4 |P B_m|^2 / lambda_min(Q)^2, s^2."""

    def bound(self, V_0: float, e_squared: float) -> float:
        """Return the bound of int |x2_tilde|^2 dt, rad^2/s, for V(0) of eq. (41) and int |e_min|^2 dt, rad^2 s."""
        return self.per_V * V_0 + self.per_e * e_squared


def theorem_2_weighted(P: np.ndarray, B_m: np.ndarray, Q: np.ndarray) -> Theorem2Weighted:
    """Return Theorem 2's bound with Young's inequality weighted by lambda = lambda_min(Q), which may be any above 0.

    The step before (43) is dV/dt <= -lambda/2 |x2_tilde|^2 + x2_tilde^T P B_m e_min. For any w > 0 the product is at
    most w/2 |x2_tilde|^2 + 1/(2 w) |P B_m|^2 |e_min|^2. The paper takes w = 1, whence lambda - 1 in (44). With w below
    lambda, integrated and V(t) >= 0 left out, the factors are 2/(lambda - w) and |P B_m|^2/(w (lambda - w));
    w = lambda/2 makes the second the least.

    Raises
    ------
    ValueError
        If Q is not positive definite.
    """
    least = float(np.linalg.eigvalsh(Q)[0])
    if least <= 0.0:
        raise ValueError("Q is not positive definite")
    return Theorem2Weighted(4.0 / least, 4.0 * float(np.linalg.norm(P @ B_m, 2)) ** 2 / least**2)
