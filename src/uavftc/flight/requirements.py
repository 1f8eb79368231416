"""What a flight is asked to hold to: the requirements of its scenario, or the default set of its aircraft.

The default set, besides being flown to its end:

    tracking     error at most 1 deg in the last quarter of the flight
    excursion    error at most 5 deg after the first 5 s, where the flight is longer
    calm         each surface travels at most 1 rad/s in any 2 s: a hobby servo moves at up to 7 rad/s, and no
                 controller should keep one at a seventh of that
    bank         within the aircraft's envelope: `limits:` of its companion file, or `LIMITS`
    alpha        the same; where nothing says it, within `ALPHA_BAND_DEG` of its trim
    load-factor  the same

Axes that the aircraft does not control, and what its plant does not know, are left out.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence

from uavftc.aircraft.definition import Aircraft, FlightLimits
from uavftc.analysis.derived import WINDOW_S, Known, Limits, Window, known_signals
from uavftc.analysis.requirements import Requirement
from uavftc.config.explain import describe
from uavftc.config.formula import Formula, formula_of
from uavftc.config.values import Problem
from uavftc.core.axes import Controlled
from uavftc.core.given import Given
from uavftc.core.layout import Layout
from uavftc.core.signals import SURFACES, Column
from uavftc.flight.named import refuse
from uavftc.plants.analytic import UNKNOWN
from uavftc.plants.jsbsim.model import TrimmedModel
from uavftc.scenario import requirements as written
from uavftc.scenario.schema import Scenario

TRACKING_DEG = 1.0
TRACKED = 0.75  # of the flight, from where on tracking counts
EXCURSION_DEG = 5.0
SETTLED_S = 5.0  # s, from when on an excursion counts
TRAVEL_RADPS = 1.0
ANGLES = ("phi", "theta", "psi")

LIMITS = FlightLimits(bank_deg=60.0, load_factor=(-1.52, 3.8))
"""Where an aircraft has none of its own: the normal category of 14 CFR 23 (amendment 23-63): banks up to 60 deg (23.3),
load factors of 3.8 and -0.4 times that (23.337)."""
ALPHA_BAND_DEG = 10.0
"""Of alpha about its trim, where neither `limits` nor `trusted` of the companion file says it: ours, as most wings
stall some 10 deg above the alpha they cruise at."""


def default_set(
    scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None, axes: Controlled
) -> tuple[written.Requirement, ...]:
    """Return the default requirements of a scenario whose other defaults are filled in."""
    duration = scenario.duration_s
    angles = [name for name, own in zip(ANGLES, axes, strict=True) if own]
    surfaces = [name for name, own in zip(SURFACES, axes, strict=True) if own]
    found = [written.Requirement(name="tracking", always=_all(angles, "abs({}_error_deg)", TRACKING_DEG),
                                 from_s=TRACKED * duration)]  # fmt: skip
    if duration > SETTLED_S:
        errors = _all(angles, "abs({}_error_deg)", EXCURSION_DEG)
        found.append(written.Requirement(name="excursion", always=errors, from_s=SETTLED_S))
    travel = _all(surfaces, "{}_travel_radps", TRAVEL_RADPS)
    found.append(written.Requirement(name="calm", always=travel, window_s=WINDOW_S))
    return (*found, *_envelope(scenario, aircraft, model))


def _all(names: Sequence[str], value: str, limit: float) -> Formula:
    return formula_of(" and ".join(f"{value.format(name)} <= {limit:g}" for name in names))


def _envelope(scenario: Scenario, aircraft: Aircraft, model: TrimmedModel | None) -> list[written.Requirement]:
    own = aircraft.limits
    bank = own.bank_deg or LIMITS.bank_deg
    found = [written.Requirement(name="bank", always=formula_of(f"abs(phi_deg) <= {bank:g}"))]
    if scenario.plant == "jsbsim" and model is not None:
        trim = math.degrees(model.trim["alpha"])
        alpha = own.alpha_deg or aircraft.trusted.alpha_deg or (trim - ALPHA_BAND_DEG, trim + ALPHA_BAND_DEG)
        found.append(_between("alpha", "alpha_deg", *alpha))
        found.append(_between("load-factor", "load_factor", *(own.load_factor or LIMITS.load_factor or (-9, 9))))
    return found


def _between(name: str, signal: str, least: float, greatest: float) -> written.Requirement:
    """Return the requirement that a signal stays between two values, the scale half of what lies between."""
    formula = formula_of(f"{least:.6g} <= {signal} <= {greatest:.6g}")
    return written.Requirement(name=name, always=formula, scale=float(f"{0.5 * (greatest - least):.6g}"))


def signals_of(scenario: Scenario, layout: Layout, given: Given) -> dict[str, Known]:
    """Return every signal that a requirement on this flight may name."""
    return known_signals(_known(scenario, layout), _limits(given))


def _known(scenario: Scenario, layout: Layout) -> list[Column]:
    """Return the columns of the history that hold numbers on this plant."""
    unknown = UNKNOWN if scenario.plant == "analytic" else ()
    return [c for c in layout.columns if c.effector is not None or c.field not in unknown]


def _limits(given: Given) -> Limits:
    limits = given.design.limits_rad
    return {name: (float(limits[i][0]), float(limits[i][1])) for i, name in enumerate(SURFACES)}


def asked(scenario: Scenario, layout: Layout, known: Mapping[str, Known]) -> tuple[Requirement, ...]:
    """Return the requirements of a scenario in rows of its flight.

    Raises
    ------
    InputError
        If one names a signal that there is not, or has a window without a signal that looks back over it.
    """
    problems: list[Problem] = []
    found = []
    rate = scenario.controller.rate_hz
    elsewhere = left_out(scenario, layout, known)
    for i, one in enumerate(scenario.requirements or ()):
        if i in elsewhere:
            continue
        key = ("requirements", i, "always" if one.always is not None else "eventually")
        missing = [name for name in one.formula.names if name not in known]
        problems += [Problem(key, *_unknown(name, known)) for name in missing]
        if one.window_s is not None and not missing and not any(known[name].windowed for name in one.formula.names):
            expected = "a formula with a signal that looks back: NAME_travel_radps, NAME_saturated_share"
            problems.append(Problem((*key[:2], "window_s"), f"{one.window_s:g} s", expected, "remove window_s"))
        first, last = written.steps(scenario, one)
        window_s = WINDOW_S if one.window_s is None else one.window_s
        window = Window(max(1, round(window_s * rate)), window_s)
        always = one.always is not None
        hold = written.hold(scenario, one)
        found.append(Requirement(one.name, one.formula, first, last, always, hold, one.scale, window))
    refuse(scenario, problems)
    return tuple(found)


def left_out(scenario: Scenario, layout: Layout, known: Mapping[str, Known]) -> dict[int, str]:
    """Return the requirements that cannot be judged in this flight, by their place, with the reason."""
    found = {}
    for i, one in enumerate(scenario.requirements or ()):
        missing = [name for name in one.formula.names if name not in known]
        if missing and set(missing) <= known_signals(layout.columns, {}).keys():
            found[i] = f"plant: {scenario.plant} does not know {missing[0]}"
        elif not missing and written.too_late(scenario, one):
            found[i] = f"the flight ends at {scenario.duration_s:g} s, before it can be"
    return found


def remarks(scenario: Scenario, layout: Layout, known: Mapping[str, Known]) -> list[str]:
    """Return a line for each requirement that is not judged in this flight."""
    asked_of = scenario.requirements or ()
    return [
        f"requirements[{i}]: {asked_of[i].name} is not judged, as {why}"
        for i, why in left_out(scenario, layout, known).items()
    ]


def _unknown(name: str, known: Mapping[str, Known]) -> tuple[str, str, str]:
    """Return found, expected and fix."""
    near = difflib.get_close_matches(name, known, n=1)
    fix = f"did you mean {near[0]}?" if near else "choose one of them"
    expected = "a column of the history, or a signal derived from one (docs/requirements.md)"
    return f"the unknown signal {describe(name)}", expected, fix
