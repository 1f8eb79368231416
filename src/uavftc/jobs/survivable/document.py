"""The document of `uavftc survivable`: phases, what stands in the way, what could be held, authority, severity.

SI and radians; docs/survivable.md describes every key. The deflections are total, as the aircraft counts them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from uavftc.analysis.attainable import outline
from uavftc.core.signals import AXES
from uavftc.flight.build import Flight
from uavftc.jobs.survivable.judge import HELD, Judged, Question, Spare, instead, unmet
from uavftc.jobs.survivable.phases import words_of
from uavftc.jobs.survivable.study import Seen, Study, shares_of
from uavftc.jobs.survivable.vehicle import EQUATIONS, FORWARD, UNITS
from uavftc.plants.interface import State
from uavftc.results.flight import notes_of, origin_of
from uavftc.results.summary import plain

STATE = {
    "airspeed_mps": State.AIRSPEED,
    "alpha_rad": State.ALPHA,
    "beta_rad": State.BETA,
    "bank_rad": State.BANK,
    "pitch_rad": State.PITCH,
    "turn_radps": State.TURN,
    "throttle": State.THROTTLE,
}
FLOW = ("airspeed_mps", "alpha_rad", "beta_rad", "throttle")
"""What the rotational model does not have."""
WIDEST_RAD = 1.0
"""A surface without a stop is drawn to here."""


def document_of(
    study: Study,
    seen: Sequence[Seen],
    *,
    speeds: list[tuple[float, Judged, Judged]] | None,
    swept: tuple[list[dict[str, Any]], tuple[float, float] | None] | None,
) -> dict[str, Any]:
    """Return the document of a study whose phases were all looked at.

    Parameters
    ----------
    speeds, swept
        Of the limiting phase, from `Study.speeds`, and from `Study.severities` and `Study.ends_at`; None where they
        were not asked for or there is nothing to ask.
    """
    flight = study.flight
    scenario = flight.scenario
    k = limiting(seen)
    phases = [
        phase_document(flight, one, thorough=not one.judged.holds or one.judged.level != "steady") for one in seen
    ]
    return {
        "scenario": scenario.name,
        "aircraft": scenario.aircraft,
        "plant": scenario.plant,
        "airspeed_mps": scenario.initial.airspeed_mps if scenario.plant == "jsbsim" else None,
        "altitude_m": scenario.initial.altitude_m if scenario.plant == "jsbsim" else None,
        "within_rad": study.within,
        "survivable": all(one.judged.holds for one in seen),
        "limiting": k,
        "phases": phases,
        "airspeeds": None if speeds is None else _speeds(k, speeds),
        "severity": None if swept is None else _severity(k, *swept),
        "warnings": [*notes_of(flight), *_remarks(flight, seen)],
        "provenance": plain(origin_of(flight)),
    }


def limiting(seen: Sequence[Seen]) -> int:
    """Return the place of the phase that is worst: without a steady state, or with the least authority left."""

    def rank(one: Seen) -> tuple[bool, float, bool]:
        return one.judged.holds, round(one.weakest, 2), not one.phase.active

    return min(range(len(seen)), key=lambda i: rank(seen[i]))


def phase_document(flight: Flight, seen: Seen, *, thorough: bool) -> dict[str, Any]:
    """Return one phase; `thorough` says what stands in the way, and what could be held instead."""
    judged, question, case = seen.judged, seen.question, seen.judged.case
    in_the_way = unmet(question, judged) if thorough and judged.level not in HELD else []
    disturbance = None
    if not math.isnan(judged.disturbance):
        disturbance = {"share": plain(judged.disturbance), "radps2": plain(judged.worst)}
    return {
        "start_s": seen.phase.start_s,
        "end_s": seen.phase.end_s,
        "active": words_of(seen.phase.active),
        "cases": seen.cases,
        "at_s": case.t,
        "survivable": judged.holds,
        "level": judged.level,
        "reference": {"bank_rad": case.bank, "pitch_rad": case.pitch, "turn_radps": case.turn},
        "state": state_of(question, judged.at.x),
        "deflections_rad": deflections_of(flight, question, judged.at.x),
        "held": [name for name, held in zip(flight.layout.names, _immovable(question), strict=True) if held],
        "residual": _residual(question, judged.at.residual),
        "unmet": [
            {"equation": EQUATIONS[u.row], "residual": u.residual, "unit": UNITS[u.row], "alone": u.alone}
            for u in in_the_way
        ],
        "instead": _instead(question, judged) if thorough else {},
        "authority": None if seen.spare is None else _authority(seen.spare, seen.clean_spare),
        "disturbance": disturbance,
        "without_faults": seen.clean_judged.level,
    }


def state_of(question: Question, x: np.ndarray) -> dict[str, float | None]:
    """Return the unknowns by name; None of what the rotational model does not have."""
    has_flow = question.vehicle.has_flow
    return {name: float(x[i]) if has_flow or name not in FLOW else None for name, i in STATE.items()}


def deflections_of(flight: Flight, question: Question, x: np.ndarray) -> dict[str, float]:
    """Return the total deflection of each effector, rad, as the aircraft counts it."""
    reach, layout = question.case.reach, flight.layout
    moved = reach.at(x[State.COUNT :], float(x[State.ALPHA]), float(x[State.BETA]))
    total = layout.sense * (layout.trim_rad + np.clip(moved, *question.vehicle.stops.T))
    return {name: float(value) + 0.0 for name, value in zip(layout.names, total, strict=True)}


def _immovable(question: Question) -> np.ndarray:
    reach = question.case.reach
    fixed: np.ndarray = reach.low == reach.high
    return fixed


def _residual(question: Question, residual: np.ndarray) -> dict[str, float | None]:
    rows = question.vehicle.rows
    return {name: float(residual[i]) if i in rows else None for i, name in enumerate(EQUATIONS)}


def _instead(question: Question, judged: Judged) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, one in instead(question, judged).items():
        if one is None:
            found[name] = None
            continue
        level, at = one
        found[name] = {
            "level": level,
            "state": state_of(question, at.x),
            "airspeed_rate_mps2": float(at.residual[FORWARD]),
        }
    return found


def _authority(spare: Spare, clean: Spare | None) -> dict[str, Any]:
    left = spare.authority()
    share = np.full((3, 2), np.nan) if clean is None else shares_of(spare, clean)
    return {
        axis: plain(
            {
                "negative_radps2": left[i, 0],
                "positive_radps2": left[i, 1],
                "negative_share": share[i, 0],
                "positive_share": share[i, 1],
            }
        )
        for i, axis in enumerate(AXES)
    }


def _speeds(phase: int, speeds: list[tuple[float, Judged, Judged]]) -> dict[str, Any]:
    def held(which: int) -> list[float] | None:
        those = [entry[0] for entry in speeds if entry[which].holds]  # type: ignore[union-attr]
        return [min(those), max(those)] if those else None

    return {
        "phase": phase,
        "held_mps": held(1),
        "held_without_faults_mps": held(2),
        "points": [
            {
                "airspeed_mps": v,
                "level": judged.level if judged.holds else None,
                "survivable": judged.holds,
                "level_without_faults": clean.level if clean.holds else None,
                "survivable_without_faults": clean.holds,
            }
            for v, judged, clean in speeds
        ],
    }


def _severity(phase: int, swept: list[dict[str, Any]], ends: tuple[float, float] | None) -> dict[str, Any]:
    clean = swept[0]["spare"]
    return {
        "phase": phase,
        "ends_between": None if ends is None else list(ends),
        "points": [
            {
                "share": point["share"],
                "level": point["judged"].level if point["judged"].holds else None,
                "survivable": point["judged"].holds,
                "bank_rad": [list(pair) for pair in point["bank"]],
                "pitch_rad": [list(pair) for pair in point["pitch"]],
                "authority": _authority(point["spare"], clean) if point["judged"].holds else None,
                "roll_yaw_radps2": plain(_outline(point["spare"], point["judged"])),
            }
            for point in swept
        ],
    }


def _outline(spare: Spare, judged: Judged) -> np.ndarray:
    """Return the corners of what roll and yaw can be made, (m, 2), rad/s^2: with 0, 0 inside they can be balanced."""
    low, high = np.maximum(spare.low, -WIDEST_RAD), np.minimum(spare.high, WIDEST_RAD)
    return judged.at.residual[[3, 5]] + outline(spare.B[[0, 2]], low, high)


def _remarks(flight: Flight, seen: Sequence[Seen]) -> list[str]:
    """Return what is worth knowing of how far the answers can be trusted, one line each."""
    lines = []
    trusted = flight.aircraft.trusted
    for one in seen:
        if trusted is None or not one.question.vehicle.has_flow or not one.judged.at.met:
            continue
        state = state_of(one.question, one.judged.at.x)
        outside = [
            f"{name} {value:.3g} {unit}"
            for name, value, unit, limits in (
                ("incidence", math.degrees(state["alpha_rad"] or 0.0), "deg", trusted.alpha_deg),
                ("sideslip", math.degrees(state["beta_rad"] or 0.0), "deg", trusted.beta_deg),
                ("airspeed", state["airspeed_mps"] or 0.0, "m/s", trusted.airspeed_mps),
            )
            if limits is not None and not limits[0] <= value <= limits[1]
        ]
        if outside:
            when = f"{one.phase.start_s:g} to {one.phase.end_s:g} s"
            lines.append(f"the steady state of {when} is outside the range that the aircraft is trusted in: "
                         f"{', '.join(outside)}")  # fmt: skip
    moments = [key for one in seen for key, entry in one.phase.active if _stays_where_it_is(entry)]
    for key in dict.fromkeys(moments):
        lines.append(f"{key}: where it finds its surface or throttle is taken from the steady state before it")
    return lines


def _stays_where_it_is(entry: Any) -> bool:
    if getattr(entry, "kind", "") != "stuck":
        return False
    return (entry.at if hasattr(entry, "engine") else entry.at_deg) is None
