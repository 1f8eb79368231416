"""A frozen vehicle brought to rest, and its surfaces moved with their backlash always taken up from below."""

from __future__ import annotations

import jsbsim
import numpy as np

from uavftc.plants.jsbsim.units import FT_M

WINDOW_S = 0.1
AT_REST = 1e-9  # change in a window, of the largest acceleration or of 1 m/s^2, that counts as none
FINE_S = 4e-3  # frames below this are many
PATIENCE_S = 2.6  # a servo of 8 rad/s comes to rest in it; an autopilot that integrates never does

ACCELERATIONS = (
    "accelerations/udot-ft_sec2", "accelerations/vdot-ft_sec2", "accelerations/wdot-ft_sec2",
    "accelerations/pdot-rad_sec2", "accelerations/qdot-rad_sec2", "accelerations/rdot-rad_sec2",
)  # fmt: skip


def accelerations(fdm: jsbsim.FGFDMExec) -> tuple[float, ...]:
    """Return u_dot, v_dot, w_dot, m/s^2, and p_dot, q_dot, r_dot, rad/s^2."""
    linear, angular = ACCELERATIONS[:3], ACCELERATIONS[3:]
    return (*(fdm[name] * FT_M for name in linear), *(fdm[name] for name in angular))


def run_for(fdm: jsbsim.FGFDMExec, seconds: float) -> None:
    """Run frames for a time, s."""
    for _ in range(round(seconds / fdm.get_delta_t())):
        fdm.run()


def settle(
    fdm: jsbsim.FGFDMExec, *, least_s: float = 0.0, patience_s: float = PATIENCE_S, at_rest: float = AT_REST
) -> np.ndarray:
    """Run frames until nothing changes any more, and return the accelerations, shape (6,)."""
    run_for(fdm, least_s)
    before = np.array(accelerations(fdm))
    for _ in range(round(patience_s / WINDOW_S)):
        run_for(fdm, WINDOW_S)
        now = np.array(accelerations(fdm))
        if not np.all(np.isfinite(now)):
            return now
        if np.max(np.abs(now - before)) <= at_rest * max(1.0, np.max(np.abs(now))):
            return now
        before = now
    return before


def rest(fdm: jsbsim.FGFDMExec, seconds: float) -> None:
    """Run frames for a time, s; where frames are fine, which is where engines are quick, until nothing changes."""
    if fdm.get_delta_t() >= FINE_S:
        run_for(fdm, seconds)
    else:
        settle(fdm, patience_s=seconds)


def set_from_below(fdm: jsbsim.FGFDMExec, commands: dict[str, float], backlash: dict[str, float]) -> None:
    """Set commands; a surface with backlash, in units of its command, comes from below, so that it is where it is."""
    if any(backlash.values()):
        for name, value in commands.items():
            fdm[name] = value - 2.0 * backlash.get(name, 0.0)
        settle(fdm, patience_s=1.0)
    for name, value in commands.items():
        fdm[name] = value
