"""The trim of an aircraft as it is published: bounded Newton steps on the settled, frozen vehicle.

Unknowns are alpha, throttle (or flight path angle), bank and the commands of the three axes; of an axis without a
surface, sideslip takes the place. Differences are wide, because servos have dead bands and propellers have none to
spare; surfaces with backlash are set from below, so that the equations are functions of the commands.
"""

from __future__ import annotations

import time
from typing import NamedTuple

import jsbsim
import numpy as np

from uavftc.plants.jsbsim import engines
from uavftc.plants.jsbsim.rig import Rig, axis_limits
from uavftc.plants.jsbsim.settle import set_from_below, settle
from uavftc.plants.jsbsim.trim import JSBSIM_TOLERANCE, Trim, configure, freeze, of_rig, place, set_throttle

ALPHA, THIRD, PHI, BETA = range(4)
STEP = np.array([2e-3, 0.02, 5e-3, 5e-3, 0.01, 0.01, 0.01])  # of the differences
MOST = np.array([0.08, 0.3, 0.1, 0.1, 0.2, 0.2, 0.2])  # of a Newton step
GAMMA_STEP, GAMMA_MOST = 5e-3, 0.1
LEVEL = ((-0.25, 0.45), (0.0, 1.0), (-0.4, 0.4), (-0.2, 0.2))  # bounds: alpha, throttle, bank, sideslip
GLIDE = (-0.7, 0.2)
STARTS = (0.5, 0.25, 0.8)  # throttle
ITERATIONS = 14
ENGINES_S, STARTED_S = 4.0, 8.0  # in which engines come to rest
BURNING = 3e-5  # change in a window that counts as none where fuel burns and the mass falls
SOLVED = 1e-8  # m/s^2 and rad/s^2: nothing more is gained
ACCEPTED = JSBSIM_TOLERANCE  # what engines that never come to rest, or burn fuel, may leave
EQUATIONS = ("u_dot", "v_dot", "w_dot", "p_dot", "q_dot", "r_dot")
UNITS = ("m/s^2",) * 3 + ("rad/s^2",) * 3
NEAR = 1e-3  # of a bound's range: counts as at it


class Nearest(NamedTuple):
    """The nearest thing to a steady flight that was found."""

    trim: Trim
    at: tuple[str, ...]
    """Limits that it is at, in words."""

    @property
    def error(self) -> float:
        """Largest acceleration left, m/s^2 or rad/s^2."""
        return float(np.max(np.abs(self.trim.residual)))

    def words(self) -> str:
        """Return in words what was found and what stands in the way."""
        t, worst = self.trim, int(np.argmax(np.abs(self.trim.residual)))
        power = f"flight path {np.degrees(t.gamma):.1f} deg" if t.method == "glide" else f"throttle {t.throttle:.2f}"
        left = f"{EQUATIONS[worst]} = {t.residual[worst]:.2g} {UNITS[worst]} is left"
        at = f", with {' and '.join(self.at)} at the limit" if self.at else ""
        return (
            f"the nearest to a steady flight is {t.airspeed:.3g} m/s, alpha {np.degrees(t.alpha):.1f} deg, {power}: "
            f"{left}{at}"
        )


class Search:
    """The search for a trim of one aircraft at one condition; the FDM is left frozen."""

    def __init__(self, fdm: jsbsim.FGFDMExec, rig: Rig, airspeed: float, altitude: float, *, glides: bool) -> None:
        self.fdm, self.rig, self.airspeed, self.altitude, self.glides = fdm, rig, airspeed, altitude, glides
        limits = axis_limits(np.sort(rig.ranges * rig.scale[:, None], axis=1), rig.mixing)
        bounds = np.array([*LEVEL, *limits])
        self.step, self.most = STEP.copy(), MOST.copy()
        if glides:
            bounds[THIRD], self.step[THIRD], self.most[THIRD] = GLIDE, GAMMA_STEP, GAMMA_MOST
        self.bounds = bounds
        axes = [4 + i for i in range(3) if rig.axes[i]]
        self.free = [ALPHA, THIRD, PHI, *([] if all(rig.axes) else [BETA]), *axes]
        freeze(fdm)
        place(fdm, airspeed=airspeed, altitude=altitude, alpha=0.03)
        configure(fdm, rig.way)
        if rig.way == "starter":
            set_throttle(fdm, rig.throttles, STARTS[0])
            settle(fdm, least_s=engines.STARTER_S)

    def trim(self, x: np.ndarray, error: np.ndarray | None = None) -> Trim:
        """Return the trim that unknowns x, (7,), stand for."""
        alpha, third, phi, beta = map(float, x[:4])
        theta, throttle = (alpha + third, 0.0) if self.glides else (alpha, third)
        return Trim(
            "glide" if self.glides else "solved", self.airspeed, self.altitude, alpha, theta, phi,
            tuple(self.rig.commands(x[4:]).values()), (0.0, 0.0, 0.0), throttle,
            () if error is None else tuple(map(float, error)), beta=beta, **of_rig(self.rig),
        )  # fmt: skip

    def error(self, x: np.ndarray) -> np.ndarray:
        """Return the accelerations at x, (6,)."""
        t, fdm = self.trim(x), self.fdm
        place(fdm, airspeed=t.airspeed, altitude=t.altitude, alpha=t.alpha, theta=t.theta, phi=t.phi, beta=t.beta)
        set_throttle(fdm, t.throttles, t.throttle)
        set_from_below(fdm, self.rig.commands(x[4:]), self.rig.slack())
        if self.rig.way == "running":
            return settle(fdm, patience_s=ENGINES_S)
        return settle(fdm, least_s=0.5, patience_s=STARTED_S, at_rest=BURNING)

    def solve(self, deadline: float) -> Trim | Nearest | None:
        """Return the trim; or the nearest to one; or None where nothing finite was found or the time is up."""
        best: tuple[float, np.ndarray, np.ndarray] | None = None
        level = [np.array([0.05, t, 0.0, 0.0, 0.0, 0.0, 0.0]) for t in ((-0.08,) if self.glides else STARTS)]
        for first in level:
            x, f = self._newton(first, deadline)
            size = float(np.max(np.abs(f)))
            if np.isfinite(size) and (best is None or size < best[0]):
                best = size, x, f
            if size < ACCEPTED or time.process_time() > deadline:
                break
        if best is None:
            return None
        found = self.trim(best[1], best[2])
        return found if best[0] < ACCEPTED else Nearest(found, self._at(best[1]))

    def _newton(self, x: np.ndarray, deadline: float) -> tuple[np.ndarray, np.ndarray]:
        x = np.clip(x, *self.bounds.T)
        f = self.error(x)
        for _ in range(ITERATIONS):
            if np.max(np.abs(f)) < SOLVED or not np.all(np.isfinite(f)) or time.process_time() > deadline:
                break
            J = np.column_stack([self._slope(x, f, i) for i in self.free])
            if not np.all(np.isfinite(J)):
                break
            step = self._bounded_step(x, J, f)
            for part in (1.0, 0.4, 0.1):
                tried = x.copy()
                tried[self.free] = np.clip(x[self.free] + part * step, *self.bounds[self.free].T)
                g = self.error(tried)
                if np.all(np.isfinite(g)) and np.linalg.norm(g) < np.linalg.norm(f):
                    break
            else:
                break
            slow = np.linalg.norm(g) > 0.98 * np.linalg.norm(f)
            x, f = tried, g
            if slow:
                break
        return x, f

    def _bounded_step(self, x: np.ndarray, J: np.ndarray, f: np.ndarray) -> np.ndarray:
        """Return the least-squares step of the free unknowns that stays inside the bounds."""
        from scipy.optimize import lsq_linear  # noqa: PLC0415 - 0.1 s that a flight from a known trim need not pay

        low, high = self.bounds[self.free].T - x[self.free]
        most = self.most[self.free]
        low, high = np.maximum(low, -most) - 1e-12, np.minimum(high, most) + 1e-12
        return np.asarray(lsq_linear(J, -f, (low, high)).x)

    def _slope(self, x: np.ndarray, f: np.ndarray, i: int) -> np.ndarray:
        step = self.step[i] if x[i] + self.step[i] <= self.bounds[i, 1] else -self.step[i]
        moved = x.copy()
        moved[i] += step
        return (self.error(moved) - f) / step

    def _at(self, x: np.ndarray) -> tuple[str, ...]:
        third = "the flight path" if self.glides else "the throttle"
        names = ("alpha", third, "the bank", "the sideslip", "the aileron", "the elevator", "the rudder")
        found = []
        for i in self.free:
            low, high = self.bounds[i]
            if min(x[i] - low, high - x[i]) < NEAR * (high - low):
                found.append(names[i])
        return tuple(found)
