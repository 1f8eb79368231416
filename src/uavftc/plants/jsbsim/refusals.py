"""Why an aircraft has no trim, in words: the nearest thing to one, and the equation, limit or axis in the way."""

from __future__ import annotations

from uavftc.aircraft.definition import Aircraft
from uavftc.analysis.authority import RESPONSE_MIN
from uavftc.core.signals import SURFACES
from uavftc.errors import InputError
from uavftc.plants.jsbsim.model import FRAME_S, NoTrimError
from uavftc.plants.jsbsim.rig import Bench, Rig
from uavftc.plants.jsbsim.search import Nearest


def too_few_axes(aircraft: Aircraft, rig: Rig) -> NoTrimError:
    """Return the refusal of an aircraft that lacks pitch, or both roll and yaw."""
    B = rig.B[3:] @ rig.mixing
    missing = [SURFACES[i] for i in range(3) if not rig.axes[i]]
    numbers = ", ".join(f"{SURFACES[i]} {abs(B[i, i]):.2g} rad/s^2 per rad" for i in range(3) if not rig.axes[i])
    return NoTrimError(
        f"aircraft {aircraft.name}",
        found=f"no {' and no '.join(missing)}: nothing acts about that axis by {RESPONSE_MIN:g} rad/s^2 ({numbers})",
        expected="surfaces about pitch and about roll or yaw",
        remedy="name the surfaces in a companion file, key effectors, if it has others (docs/new-aircraft.md)",
    )


def _where(bench: Bench, speeds: tuple[float, ...]) -> str:
    span = f"{speeds[0]:.4g}" if len(speeds) == 1 else f"{speeds[0]:.4g} to {speeds[-1]:.4g}"
    return f"aircraft {bench.aircraft.name}, trim at {span} m/s and {bench.altitude:g} m"


def gave_up(bench: Bench, speeds: tuple[float, ...], seconds: float) -> InputError:
    """Return the refusal that time is to blame for: no `NoTrimError`, so that it is not remembered."""
    return InputError(
        _where(bench, speeds),
        found=f"no steady flight found within {seconds:g} s of computing",
        expected="a condition at which a trim is found in that time",
        remedy="give initial.airspeed_mps, so that one speed is tried",
    )


def no_trim(bench: Bench, speeds: tuple[float, ...], nearest: Nearest | None) -> NoTrimError:
    """Return the refusal at airspeeds, m/s, none of which has a trim; `nearest` is the nearest thing to one."""
    aircraft = bench.aircraft
    default = aircraft.initial
    remedy = "choose another initial.airspeed_mps or initial.altitude_m"
    if default:
        remedy += f" (the aircraft's default: {default.airspeed_mps:g} m/s, {default.altitude_m:g} m)"
    found = "no steady flight: nothing finite was found"
    if nearest is not None:
        found = f"no steady flight; {nearest.words()}"
        if "the throttle" in nearest.at and nearest.trim.throttle > 0.5 and nearest.trim.residual[0] < 0.0:
            found += " (thrust is lacking)"
    if engines_dead := (bench.engines > 0 and not bench.powered):
        found += "; no throttle moves the thrust of its engines, whatever was tried to start them"
        remedy = "correct its engines, or name what starts them in the XML; " + remedy
    if bench.rig.frame_s < FRAME_S and not engines_dead:
        found += f"; its propellers need frames of {bench.rig.frame_s * 1e3:g} ms"
    return NoTrimError(
        _where(bench, speeds),
        found=found,
        expected="a condition in which surfaces and throttle within their limits bring all accelerations to zero",
        remedy=remedy,
    )
