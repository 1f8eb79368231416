"""Measures the trimmed models of an aircraft in this process: engines, surfaces and gangs once, then each airspeed."""

from __future__ import annotations

import math
import time

import jsbsim
import numpy as np

from uavftc.aircraft.definition import Aircraft
from uavftc.aircraft.effectors import Measured, Surface
from uavftc.analysis.authority import can_be_held
from uavftc.core.signals import SURFACES
from uavftc.plants.jsbsim import controls_xml, discover, engines
from uavftc.plants.jsbsim.claims import check_effectors
from uavftc.plants.jsbsim.engines import has
from uavftc.plants.jsbsim.linearise import Linear, linearise
from uavftc.plants.jsbsim.load import inertia, initialised, missing
from uavftc.plants.jsbsim.model import FRAME_S, NOMINAL_RAD, NoTrimError, TrimmedModel
from uavftc.plants.jsbsim.refusals import gave_up, no_trim, too_few_axes
from uavftc.plants.jsbsim.rig import Bench, Rig, arrange, axes_of, axis_limits
from uavftc.plants.jsbsim.search import Nearest, Search
from uavftc.plants.jsbsim.settle import WINDOW_S, run_for, set_from_below, settle
from uavftc.plants.jsbsim.trim import Trim, configure, freeze, hold, place, set_throttle, trim_jsbsim, trim_own
from uavftc.plants.jsbsim.units import FT_M, SLUG_KG

MANY = 6  # surfaces
BEYOND = 2  # airspeeds in a row without a trim, after one with: the top speed is passed
DEADLINE_S = 20.0  # of processor time, so that a busy machine finds what an idle one does: for a first trim
CL_MAX = 1.4  # of a wing without flaps, for the lowest airspeed that is tried
SLOWEST, FASTEST = 1.25, 4.5  # airspeeds tried, in stall speeds
TYPICAL = 1.6  # airspeed in stall speeds at which engines and surfaces are tried
RHO_SI = 515.378818  # kg/m^3 per slug/ft^3
ENDS = {"rad": 1.5, "deg": 90.0}  # command at which a surface without a normalised command is taken to its stop
PARTS = (0.05, 0.1, 0.95, 1.0)  # of it: the slope is taken from the first two, a stop is seen on the last two
TRIAL_S = 0.3


def models_of(aircraft: Aircraft, speeds: tuple[float, ...], altitude: float) -> list[TrimmedModel]:
    """Return the models at those airspeeds, m/s, at which there is a trim; several are thinned to the aircraft's range.

    Raises
    ------
    InputError
        If the aircraft does not load.
    NoTrimError
        If it has a trim at none of the speeds; it says the nearest thing to one.
    """
    deadline = time.process_time() + DEADLINE_S
    bench = prepare(aircraft, altitude)  # a trim must not depend on the others that were asked for
    if len(speeds) > 1:
        low, high = SLOWEST * bench.stall, FASTEST * bench.stall
        speeds = tuple(v for v in speeds if low <= v <= high) or (TYPICAL * bench.stall,)
        if bench.rig.frame_s < FRAME_S or len(bench.rig.surfaces) > MANY:
            speeds = speeds[1::2] or speeds  # each takes seconds
    found: list[TrimmedModel] = []
    nearest: list[Nearest] = []
    beyond = 0
    for speed in speeds:
        # what has been found never depends on the clock; only the search for a first one is given up
        if not found and time.process_time() > deadline:
            break
        trim, fdm = trim_at(bench, speed, math.inf if found else deadline)
        if isinstance(trim, Trim):
            found.append(model_at(bench, trim, fdm))
            beyond = 0
            continue
        beyond += bool(found)
        if trim is not None:
            nearest.append(trim)
        if beyond == BEYOND:
            break
    if not found and time.process_time() > deadline:
        raise gave_up(bench, speeds, DEADLINE_S)
    if not found:
        raise no_trim(bench, speeds, min(nearest, key=lambda n: n.error, default=None))
    return found


SOON = 10  # frames after which a throttle has begun to follow its command


def prepare(aircraft: Aircraft, altitude: float) -> Bench:
    """Return the aircraft with its engines and surfaces tried, at its own airspeed or a typical one."""
    fdm = initialised(aircraft, FRAME_S)
    stall = stall_speed(fdm, altitude)
    given = aircraft.initial.airspeed_mps if aircraft.initial else None
    speed = given or TYPICAL * stall
    throttles: tuple[str, ...] = ()
    way, frame, powered = "running", FRAME_S, engines.count(fdm) > 0
    if powered:
        throttles, way, frame, powered = _engines(aircraft, fdm, speed, altitude)

    def fresh() -> jsbsim.FGFDMExec:
        made = _frozen(aircraft, speed, altitude, frame, way if powered else "running")
        set_throttle(made, throttles, 0.3 if powered else 0.0)
        settle(made, least_s=0.5)
        return made

    surfaces = aircraft.named_effectors() or discover.surfaces(aircraft, fresh, missing(aircraft))
    fdm = fresh()
    if not surfaces:
        raise NoTrimError(
            f"aircraft {aircraft.name}, {aircraft.xml}",
            found="no steady flight: nothing that the flight controls read moves it for as long as it is set; "
            f"{discover.why_none(fdm)}",
            expected="an aircraft whose surfaces can be commanded",
            remedy="name its surfaces in a companion file, key effectors (docs/new-aircraft.md); below flight controls "
            "that hold a rate of their own, whose integrators stand at their ends in a vehicle that is held",
        )
    rig = rough(aircraft, fdm, surfaces)._replace(throttles=throttles, way=way, frame_s=frame)
    if not np.all(np.isfinite(rig.B)):
        raise NoTrimError(
            f"aircraft {aircraft.name}, at {speed:.3g} m/s and {altitude:g} m",
            found="accelerations that are not a number, in level flight with the commands at rest",
            expected="an aircraft whose forces and moments are finite",
            remedy="look for a division by zero, or a missing property, in the aerodynamics and the engines",
        )
    check_effectors(aircraft, fdm, rig)
    if not can_be_held(rig.axes):
        raise too_few_axes(aircraft, rig)
    return Bench(aircraft, altitude, rig, stall, powered, engines.count(fdm))


def stall_speed(fdm: jsbsim.FGFDMExec, altitude: float) -> float:
    """Return the airspeed at which the wing carries the weight with `CL_MAX`, m/s."""
    place(fdm, airspeed=50.0, altitude=altitude, alpha=0.0)
    rho, area = fdm["atmosphere/rho-slugs_ft3"] * RHO_SI, fdm["metrics/Sw-sqft"] * FT_M**2
    return math.sqrt(2.0 * engines.weight(fdm) / (max(rho * area, 1e-9) * CL_MAX))


def _frozen(aircraft: Aircraft, speed: float, altitude: float, frame: float, way: str) -> jsbsim.FGFDMExec:
    fdm = initialised(aircraft, frame)
    freeze(fdm)
    place(fdm, airspeed=speed, altitude=altitude, alpha=0.05)
    configure(fdm, way)
    return fdm


def _engines(
    aircraft: Aircraft, fdm: jsbsim.FGFDMExec, speed: float, altitude: float
) -> tuple[tuple[str, ...], str, float, bool]:
    """Return throttles, the way to start the engines, the longest frame that they allow, and whether they run."""
    named = aircraft.throttle is not None or bool(aircraft.engines()) or aircraft.autothrottle is not None
    frame = FRAME_S
    for way in engines.WAYS:
        fdm = _frozen(aircraft, speed, altitude, frame, way)
        throttles = aircraft.throttle_commands(engines.count(fdm)) if named else discover.throttles(aircraft, fdm)
        if not throttles:  # none moves the thrust
            continue
        frame, pull = _frame(aircraft, speed, altitude, way, throttles, frame)
        if pull > engines.LIVE * engines.weight(fdm):
            return throttles, way, frame, True
        if aircraft.autothrottle is not None:  # an aircraft made for this project
            return throttles, "running", FRAME_S, True
    return (), "running", FRAME_S, False


def _frame(
    aircraft: Aircraft, speed: float, altitude: float, way: str, throttles: tuple[str, ...], frame: float
) -> tuple[float, float]:
    """Return the longest frame at which the thrust is that of the next finer one, s, and that thrust, N."""
    pulls: list[tuple[float, float]] = []
    for dt in (f for f in engines.FRAMES_S if f <= frame):
        fdm = _frozen(aircraft, speed, altitude, dt, way)
        set_throttle(fdm, throttles, engines.OPEN)
        run_for(fdm, TRIAL_S)
        early = engines.pull(fdm)
        wild = not math.isfinite(early) or abs(early) > 20.0 * engines.weight(fdm)
        if not wild:
            settle(fdm, least_s=engines.STARTER_S if way == "starter" else engines.SPIN_S, patience_s=6.0)
        pull = math.nan if wild else engines.pull(fdm)
        pulls.append((dt, pull))
        if len(pulls) > 1 and abs(pulls[-2][1] - pull) <= engines.ALIKE * max(abs(pull), 1e-3 * engines.weight(fdm)):
            return pulls[-2]
    return pulls[-1][0], (pulls[-1][1] if math.isfinite(pulls[-1][1]) else 0.0)


def rough(aircraft: Aircraft, fdm: jsbsim.FGFDMExec, surfaces: dict[str, Surface]) -> Rig:
    """Return the surfaces as measured at a frozen condition that is no trim, with gangs and the axes they hold."""
    n = len(surfaces)
    scale, ranges, backlash, B = np.ones(n), np.zeros((n, 2)), np.zeros(n), np.zeros((6, n))
    for j, (name, surface) in enumerate(surfaces.items()):
        known = surface.position if surface.position is not None and has(fdm, surface.position) else None
        per_unit = position_rad(surface.position)
        servo = controls_xml.servo(aircraft, surface.position)
        unit = discover.unit(surface.command)
        at = fdm[surface.command]
        ends = _ends(fdm, surface, known, unit)
        step = 0.2 * min(abs(ends[0] - at), abs(ends[1] - at)) or 0.1 * (ends[1] - ends[0])
        slack = {surface.command: 0.05 * (ends[1] - ends[0]) if servo.get("backlash_rad") else 0.0}
        answers = []
        for sign in (1.0, -1.0):
            set_from_below(fdm, {surface.command: at + sign * step}, slack)
            acceleration = settle(fdm, patience_s=2.0)
            answers.append((acceleration, fdm[known] * per_unit if known and per_unit else math.nan))
        set_from_below(fdm, {surface.command: at}, slack)
        settle(fdm, patience_s=2.0)
        slope = (answers[0][0] - answers[1][0]) / (2.0 * step)
        moved = (answers[0][1] - answers[1][1]) / (2.0 * step)
        nominal = NOMINAL_RAD / max(abs(ends[0]), abs(ends[1])) if unit != "rad" else 1.0
        scale[j] = moved if math.isfinite(moved) and abs(moved) > 1e-6 else nominal
        if surface.rad_per_command is not None:
            scale[j] = surface.rad_per_command
        elif name in SURFACES and not aircraft.effectors:  # positive for a positive moment about its axis
            scale[j] = math.copysign(scale[j], slope[3 + SURFACES.index(name)])
        if surface.stop_rad is not None and surface.rad_per_command is None:
            ends = (-surface.stop_rad / abs(scale[j]), surface.stop_rad / abs(scale[j]))
        ranges[j], B[:, j] = ends, slope / scale[j]
        backlash[j] = servo.get("backlash_rad", 0.0) / abs(scale[j])
    reach = np.max(np.abs(ranges * scale[:, None]), axis=1)
    names = tuple(surfaces)
    mixing, gangs = arrange(names, B, reach, aircraft.gangs)
    axes = axes_of(names, B, reach, mixing)
    return Rig(surfaces, (), scale, ranges, backlash, B, mixing, gangs, axes)


def position_rad(name: str | None) -> float:
    """Return rad per unit of a position property; 0 where it is no angle."""
    return {"rad": 1.0, "deg": math.pi / 180.0, "": 0.0}[discover.unit(name or "")]


def _ends(fdm: jsbsim.FGFDMExec, surface: Surface, known: str | None, unit: str) -> tuple[float, float]:
    """Return least and greatest command: those of a normalised one, as declared, or where the position stays."""
    if surface.stop_rad is not None and surface.rad_per_command is not None:
        reach = surface.stop_rad / abs(surface.rad_per_command)
        return -reach, reach
    if not unit:
        return -1.0, 1.0
    found = []
    at, full = fdm[surface.command], ENDS[unit]
    for sign in (-1.0, 1.0):
        places = []
        for part in PARTS:  # on the way to one side, so that backlash is taken up
            fdm[surface.command] = at + sign * part * full
            settle(fdm, least_s=WINDOW_S, patience_s=1.5)
            places.append(fdm[known] if known else 0.0)
        slope = (places[1] - places[0]) / ((PARTS[1] - PARTS[0]) * full)
        last = (places[3] - places[2]) / ((PARTS[3] - PARTS[2]) * full)
        if known is None or not slope or abs(last) > 0.1 * abs(slope):  # no stop, or none that is seen
            found.append(at + sign * NOMINAL_RAD * full / ENDS["rad"])
        else:
            found.append(at + sign * (PARTS[0] * full + (places[3] - places[0]) / slope))
    fdm[surface.command] = at
    settle(fdm, patience_s=1.5)
    return min(found), max(found)


def trim_at(bench: Bench, speed: float, deadline: float) -> tuple[Trim | Nearest | None, jsbsim.FGFDMExec]:
    """Return the trim at an airspeed, m/s, or the nearest thing to one, and the FDM, frozen."""
    aircraft, rig, altitude = bench.aircraft, bench.rig, bench.altitude
    plain = rig.frame_s == FRAME_S and rig.way == "running" and not np.any(rig.backlash) and all(rig.axes)
    plain = plain and bench.powered == (len(rig.throttles) > 0)
    trim: Trim | None = None
    if plain and aircraft.autothrottle is None and set(rig.surfaces) <= set(SURFACES):
        trim = trim_jsbsim(initialised(aircraft, FRAME_S), rig, speed, altitude)
    fdm = initialised(aircraft, rig.frame_s)
    simple = all(np.count_nonzero(row) == 1 for row in rig.mixing)
    if trim is None and plain and aircraft.named_effectors() and simple:
        trim = trim_own(fdm, rig, speed, altitude)
    if trim is not None:
        return trim, fdm
    search = Search(fdm, rig, speed, altitude, glides=not bench.powered)
    return search.solve(deadline), fdm


def model_at(bench: Bench, trim: Trim, fdm: jsbsim.FGFDMExec) -> TrimmedModel:
    """Return the model at a trim; the FDM is one that has been trimmed or is fresh."""
    rig, aircraft = bench.rig, bench.aircraft
    hold(fdm, trim)
    linear = linearise(fdm, rig, trim)
    found = [_measured(aircraft, name, j, rig, trim, linear) for j, name in enumerate(rig.surfaces)]
    limits, reach = np.array([m.limits_rad for m in found]), _reach(found)
    B, mixing = np.array([m.B for m in found]).T, rig.mixing
    if not np.array_equal(mixing, np.round(mixing)):  # a pseudo-inverse: that of the trim itself
        mixing, _ = arrange(tuple(rig.surfaces), B, np.max(np.abs(limits), axis=1), aircraft.gangs)
    axes, weight = rig.axes, np.abs(mixing)
    first = np.argmax(weight, axis=0)
    return TrimmedModel(
        trim=trim._asdict(),
        mass_kg=fdm["inertia/mass-slugs"] * SLUG_KG,
        inertia_kgm2=inertia(fdm).tolist(),
        engines=engines.count(fdm) if bench.powered else 0,
        rad_per_command=[found[j].rad_per_command for j in first],
        measured_rad=[all(m.measured for m, w in zip(found, weight[:, i], strict=True) if w) for i in range(3)],
        limits_rad=axis_limits(limits, mixing).tolist(),
        A=linear.A.tolist(),
        A_at_once=linear.A_at_once.tolist(),
        B=np.where(axes, B @ mixing, 0.0).tolist(),
        throttle_mps2=linear.throttle_mps2,
        nonlinearity=[max((m.nonlinearity for m, w in zip(found, weight[:, i], strict=True) if w > 0.1), default=0.0)
                      for i in range(3)],
        effectors=found,
        mixing=mixing.tolist(),
        gangs=rig.gangs,
        axes=list(axes),
        reach_rad=axis_limits(reach, mixing).tolist(),
        frame_s=rig.frame_s,
        declared=missing(aircraft),
        engine_names=list(aircraft.engines()) or [f"engine_{i + 1}" for i in range(engines.count(fdm))],
        engine_order=_order(aircraft, engines.count(fdm), rig.frame_s),
    )  # fmt: skip


def _order(aircraft: Aircraft, count: int, frame_s: float) -> list[str]:
    """Return a name of each engine in the order of the XML: the one whose throttle moves it alone, or a number."""
    names = [f"engine_{i + 1}" for i in range(count)]
    if not (commands := aircraft.engines()):
        return names
    for name, command in commands.items():
        fdm = initialised(aircraft, frame_s)
        engines.start(fdm)
        positions = np.array([throttle_positions(fdm, command, value, count) for value in (0.2, 0.4)])
        moved = np.flatnonzero(positions[0] != positions[1])
        if len(moved) == 1:
            names[int(moved[0])] = name
    return names


def throttle_positions(fdm: jsbsim.FGFDMExec, command: str, value: float, count: int) -> list[float]:
    """Return the throttle position of each engine soon after a command."""
    fdm[command] = value
    for _ in range(SOON):
        fdm.run()
    return [float(fdm[f"fcs/throttle-pos-norm[{i}]"]) for i in range(count)]


def _measured(aircraft: Aircraft, name: str, j: int, rig: Rig, trim: Trim, linear: Linear) -> Measured:
    """Return one effector from the response at the trim."""
    surface, found = list(rig.surfaces.values())[j], linear.surfaces
    per_unit = position_rad(surface.position)
    slope = found.position[j] * per_unit  # rad per unit of command
    known = bool(np.isfinite(slope) and abs(slope) > 1e-6)
    if surface.rad_per_command is not None:
        scale = surface.rad_per_command
    else:
        scale = math.copysign(abs(slope), rig.scale[j]) if known else float(rig.scale[j])
    sign = math.copysign(1.0, scale * slope) if known else 1.0  # of the deflection against the position
    low, high = (float(e) for e in found.ends[j])
    at = trim.surfaces[j]
    if surface.stop_rad is not None or not known:
        limits = sorted(((low - at) * scale, (high - at) * scale))
    else:
        limits = sorted(sign * per_unit * (end - found.at_trim[j]) for end in found.at_ends[j])
    return Measured(
        name=name,
        command=surface.command,
        position=surface.position if known else None,
        position_rad=sign * per_unit if known else 0.0,
        rad_per_command=scale,
        measured=bool(surface.rad_per_command is not None or known),
        trim_command=float(at),
        trim_rad=float(sign * per_unit * found.at_trim[j]) if known else float(at * scale),
        commands=[low, high],
        limits_rad=[min(limits[0], 0.0), max(limits[1], 0.0)],
        ideal=bool(found.ideal[j]),
        B=(found.B_command[:, j] / scale).tolist(),
        full_response=[float(x) if math.isfinite(x) else 1.0 for x in found.full[j]],
        nonlinearity=float(found.nonlinearity[j]),
        servo=controls_xml.servo(aircraft, surface.position),
    )


def _reach(found: list[Measured]) -> np.ndarray:
    """Return (n, 2), rad: deflections that would do by the slope what the ends of the command do."""
    ends = []
    for m in found:
        pair = [r * (end - m.trim_command) * m.rad_per_command
                for r, end in zip(m.full_response, m.commands, strict=True)]  # fmt: skip
        ends.append(sorted(pair))
    return np.array(ends)
