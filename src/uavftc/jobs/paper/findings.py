"""What the flights show and the paper does not: each finding computed from them, with the command that shows it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from uavftc.aircraft.definition import load_aircraft
from uavftc.analysis.metrics import INTEGRALS
from uavftc.control.gains import lyapunov_P
from uavftc.control.rbf import NODES, basis
from uavftc.core.signals import AXES, SURFACES
from uavftc.jobs.campaign.pool import Flown
from uavftc.jobs.paper import printed
from uavftc.jobs.paper.captions import NOISY
from uavftc.jobs.paper.plan import (
    CASES,
    CLAIM_DELAY_MS,
    DELAYS_MS,
    EXPLICIT,
    EXPLICIT_HZ,
    GYRO_BIAS_DEGPS,
    L1,
    MRAC,
    NDI_L1,
    PRINTED_GAIN,
    RADIAN_DEG,
    RUDDER_CONSTANT,
    Flights,
    Key,
    of_variant,
    rudder_fault,
    rudder_override,
)
from uavftc.jobs.paper.tables import BEST, Row, ratio, rows_of, score, scored

TABLE_OF = {"scenario1": 2, "scenario2": 3, "scenario3": 5}
"""The table that prints each scenario."""
SATURATED = "saturated"
MET = 0.2  # up to which a printed integral counts as met


class Finding(NamedTuple):
    """One finding on one plant."""

    key: str
    plant: str
    title: str
    statement: str
    header: tuple[str, ...]
    rows: list[tuple[Any, ...]]
    command: str


def _metric(flown: Flown, axis: str, name: str) -> float:
    value = flown.axes[axis][name]
    return float("nan") if value is None else value


def _axes(flown: Flown, name: str) -> list[float]:
    return [_metric(flown, axis, name) for axis in AXES]


def _history(flown: Flown, name: str) -> np.ndarray:
    assert flown.history is not None
    return flown.history[name]


def _printed(table: int, controller: str, axis: str, metric: str) -> float:
    """Return a figure of Table 2 (with saturation), 3 or 5, as printed."""
    (value,) = (
        p.value
        for p in printed.tables()
        if (p.table, p.controller, p.axis, p.metric) == (table, controller, axis, metric) and p.saturation == SATURATED
    )
    assert value is not None
    return value


def _inner(flown: Flown) -> Any:
    """Return the inner loop's section of the scenario, as flown."""
    controller: Any = flown.scenario.controller
    return controller.inner


def idle_observer(flights: Flights, plant: str) -> Finding:
    """Where the observer is inactive, and what a gyro bias changes."""
    paper, biased = of_variant(flights, plant, "paper"), of_variant(flights, plant, "gyro bias")
    names = ("d1_hat_phi_radps", "d1_hat_theta_radps", "d1_hat_psi_radps")
    rows: list[tuple[Any, ...]] = []
    largest = apart = 0.0
    for scenario in ("scenario2", "scenario3"):
        observer, bare = paper[scenario, L1], paper[scenario, NDI_L1]
        peak = max(float(np.max(np.abs(_history(observer, n)))) for n in names)
        differences = [
            abs(a / b - 1.0) for q in INTEGRALS for a, b in zip(_axes(observer, q), _axes(bare, q), strict=True)
        ]
        largest, apart = max(largest, peak), max(apart, *differences)
        rows.append((f"{scenario}, as printed", f"{np.degrees(peak):.1e} deg/s", f"{100 * max(differences):.1e} %"))
    observer, bare = biased["scenario1", L1], biased["scenario1", NDI_L1]
    with_, without = _axes(observer, "steady_state_error_deg"), _axes(bare, "steady_state_error_deg")
    fall = [100 * (1 - a / b) for a, b in zip(_axes(observer, "iae"), _axes(bare, "iae"), strict=True)]
    for axis, a, b, f in zip(AXES, with_, without, fall, strict=True):
        text = f"steady-state error {b:.3f} deg without, {a:.3f} deg with the observer"
        rows.append((f"scenario1, gyro bias {GYRO_BIAS_DEGPS} deg/s, {axis}", text, f"IAE lower by {f:.0f} %"))
    return Finding(
        "idle-observer",
        plant,
        "The disturbance observer is idle in the paper's scenarios",
        f"With exact kinematics e of eq. (15) stays at zero, so NDI-L1 and NNDONDI-L1 are one controller: the largest "
        f"|d1_hat| is {np.degrees(largest):.1e} deg/s and no integral metric differs by more than {100 * apart:.1e} %. "
        f"A gyro bias of {GYRO_BIAS_DEGPS} deg/s on each axis makes the difference that the paper reports without a "
        f"cause: the steady-state errors fall from {min(without):.2f}-{max(without):.2f} deg to "
        f"{min(with_):.3f}-{max(with_):.3f} deg, IAE by {min(fall):.0f}-{max(fall):.0f} %.",
        ("flight", "observer", "difference"),
        rows,
        f"uavftc compare scenario1 --plants {plant} --controllers nndondi-l1,ndi-l1 "
        f"--set sensors.gyro_bias_degps={GYRO_BIAS_DEGPS}",
    )


def loop_delay(flights: Flights, plant: str) -> Finding:
    """L1 against MRAC as the loop gets slower."""
    rows: list[tuple[Any, ...]] = []
    activity: dict[tuple[str, float], float] = {}
    for ms in DELAYS_MS:
        flown = of_variant(flights, plant, "delay", ms)
        cells: list[str] = []
        for controller in (L1, MRAC):
            item = flown["scenario2", controller]
            total = max(_axes(item, "control_activity_rad"))
            activity[controller, ms] = total
            cells.append("lost" if not item.outcome.completed else f"{max(_axes(item, 'iae')):.4f}")
            cells.append(f"{total:.2f}")
        rows.append((f"{ms:g}", *cells))
    at, duration = (
        CLAIM_DELAY_MS,
        of_variant(flights, plant, "delay", CLAIM_DELAY_MS)["scenario2", L1].scenario.duration_s,
    )
    return Finding(
        "loop-delay",
        plant,
        "L1 stays calm as the loop slows down; MRAC does not",
        f"On a perfect loop both track alike. With {at:g} ms of delay between command and surface the busiest surface "
        f"of L1 travels {activity[L1, at]:.2f} rad in {duration:g} s, that of MRAC {activity[MRAC, at]:.1f} rad. "
        + (
            "JSBSim moves before it computes forces, which is one frame of delay; so MRAC moves the surfaces "
            f"{activity[MRAC, 0.0] / activity[L1, 0.0]:.0f} times as much as L1 without any added delay. "
            "(With a delay of part of a sample JSBSim runs finer frames, and its frame of delay is shorter.)"
            if plant == "jsbsim"
            else "Tracking alone hides it: the integral metrics stay close until the loop is lost."
        )
        + f" {NOISY}",
        ("delay [ms]", "L1 largest IAE", "L1 activity [rad]", "MRAC largest IAE", "MRAC activity [rad]"),
        rows,
        f"uavftc compare scenario2 --plants {plant} --controllers nndondi-l1,nndondi-mrac "
        f"--set controller.delay_s={at / 1e3:g}",
    )


def scores_by_scale(flights: Flights, plant: str) -> dict[float, tuple[float, float]]:
    """Return, for each scale of the additive fault that was flown, the score over all tables and over Table 5."""
    paper = of_variant(flights, plant, "paper")
    result: dict[float, tuple[float, float]] = {}
    for key, flown in flights.items():
        if key.variant == "fault scale" and key.plant == plant and flown.outcome.completed:
            rows = rows_of(plant, {**paper, ("scenario3", BEST): flown})
            result[key.value] = score(rows), score(rows, 5)
    return dict(sorted(result.items()))


def best_scale(flights: Flights, plant: str) -> float:
    """Return the scale of the additive fault that fits all figures best among those flown."""
    scores = scores_by_scale(flights, plant)
    return min(scores, key=lambda s: scores[s][0])


def fault_scale(flights: Flights, plant: str) -> Finding:
    """How Table 5 depends on the unit of the additive fault."""
    scores = scores_by_scale(flights, plant)
    best = best_scale(flights, plant)
    radian = of_variant(flights, plant, "fault in rad", RADIAN_DEG)["scenario3", L1].outcome
    end = "is flown to the end" if radian.completed else f"is lost: {radian.ended_because}"
    shown = sorted({s for s in scores if round(s * 10) % 2 == 0 and round(s * 100) % 10 == 0} | {best})
    rows = [
        (f"{s:.2f}{' (best fit)' if s == best else ''}", f"{scores[s][0]:.3f}", f"{scores[s][1]:.3f}") for s in shown
    ]
    return Finding(
        "fault-scale",
        plant,
        "Table 5 turns on the unit of the additive fault",
        f"In plain degrees the score over the {scored()} figures is {scores[1.0][0]:.3f} ({scores[1.0][1]:.3f} over "
        f"Table 5). A fit, found by search and not read from the text: at {best:.2f} deg a printed unit it is "
        f"{scores[best][0]:.3f} ({scores[best][1]:.3f}). Beyond, the rudder saturates and the figures run away. Read "
        f"in rad the vehicle {end}.",
        ("deg per printed unit", "score, all tables", "score, Table 5"),
        rows,
        f"uavftc reproduce --plant {plant}",
    )


def printed_gain(flights: Flights, plant: str) -> Finding:
    """What the printed K_2 does."""
    paper, gain = of_variant(flights, plant, "paper"), of_variant(flights, plant, "printed gain")
    inner = _inner(gain["scenario2", L1])
    A_m = np.array(inner.A_m)
    settled = np.linalg.solve(A_m, A_m + np.array(inner.K_1))[1, 1]  # of A_m^-1 A_s, which is I with unit gain
    rows: list[tuple[Any, ...]] = []
    for scenario, controller in CASES:
        if controller != L1 or scenario == "scenario1-unsaturated":
            continue
        for axis in AXES:
            ours, theirs = (_metric(f[scenario, L1], axis, "iae") for f in (paper, gain))
            value = _printed(TABLE_OF[scenario], L1, axis, "iae")
            rows.append((scenario, axis, f"{value:.4f}", f"{ours:.4f}", f"{theirs:.4f}"))
    all_rows = rows_of(plant, {**paper, **gain})
    return Finding(
        "printed-gain",
        plant,
        "The printed K_2 cannot have been flown",
        "K_2 = B_m^-1 A_s is the gain of a plant with A_s, and eq. (27) has A_m: even with the sign that makes it "
        f"follow, the rates settle at A_m^-1 A_s r, which gives pitch {100 * settled:.0f} % of its command. Its score "
        f"over the {scored()} figures is {score(all_rows):.3f}, against {score(rows_of(plant, paper)):.3f} with "
        "K = B_m^-1 A_m.",
        ("scenario", "axis", "IAE printed", "IAE, K of A_m", "IAE, printed K_2"),
        rows,
        f"uavftc-fly scenario2 --plant {plant} --set {PRINTED_GAIN}",
    )


def adaptation_krad_s(flown: Flown) -> tuple[float, float]:
    """Return the slowest and the fastest natural frequency of the adaptive laws (31) at rest, krad/s.

    x2_tilde'' = -Gamma (1 + |Phi|^2) B_m B_m^T P x2_tilde, with Phi at x1 = x2 = 0 and no command.
    """
    inner = _inner(flown)
    aircraft = load_aircraft(flown.scenario.aircraft)
    assert aircraft.analytic is not None
    B_m = np.array(inner.B_m or aircraft.analytic.B_m)
    P = lyapunov_P(np.array(inner.A_m) + np.array(inner.K_1), np.array(inner.Q))
    Phi = np.empty(NODES)
    basis(np.zeros(3), np.zeros(3), 0.0, np.ones(3), np.array(inner.rbf.centres), inner.rbf.width, Phi)
    squares = np.linalg.eigvals(inner.adaptation_gain * (1.0 + Phi @ Phi) * B_m @ B_m.T @ P).real
    return 1e-3 * float(np.sqrt(squares.min())), 1e-3 * float(np.sqrt(squares.max()))


def explicit_integration(flights: Flights, plant: str) -> Finding:
    """What an explicit step makes of MRAC and of L1."""
    paper, explicit = of_variant(flights, plant, "paper"), of_variant(flights, plant, "explicit")
    accurate, crude, l1 = paper["scenario2", MRAC], explicit["scenario2", MRAC], explicit["scenario2", L1]
    rows: list[tuple[Any, ...]] = []
    for axis in AXES:
        value = {m: _printed(TABLE_OF["scenario2"], MRAC, axis, m) for m in ("iae", "steady_state_error_deg")}
        rows.append(
            (
                axis,
                f"{value['iae']:.4f} / {value['steady_state_error_deg']:.4f}",
                f"{_metric(accurate, axis, 'iae'):.4f} / {_metric(accurate, axis, 'steady_state_error_deg'):.4f}",
                f"{_metric(crude, axis, 'iae'):.4f} / {_metric(crude, axis, 'steady_state_error_deg'):.4f}",
            )
        )
    apart: dict[str, list[float]] = {
        axis: [abs(_metric(crude, axis, m) / _printed(TABLE_OF["scenario2"], MRAC, axis, m) - 1.0) for m in INTEGRALS]
        for axis in AXES
    }
    near = [axis for axis in AXES if max(apart[axis]) <= MET]
    far = [axis for axis in AXES if axis not in near]
    said = []
    if near:
        most = max(max(apart[axis]) for axis in near)
        said.append(
            f"In {' and '.join(near)} the {len(near) * len(INTEGRALS)} integrals of Table {TABLE_OF['scenario2']} are "
            f"then met within {math.ceil(100 * most):.0f} %"
        )
    for axis in far:
        name = INTEGRALS[int(np.argmax(apart[axis]))]
        said.append(
            f"in {axis} they are not: {name.upper()} comes out at {_metric(crude, axis, name):.2g} and is printed as "
            f"{_printed(TABLE_OF['scenario2'], MRAC, axis, name):.3g}"
        )
    ended = "/".join(f"{error:.0f}" for error in _axes(l1, "steady_state_error_deg"))
    end = (
        f"ends {ended} deg off in roll/pitch/yaw, though the flight is completed"
        if l1.outcome.completed
        else f"is lost: {l1.outcome.ended_because}"
    )
    slowest, fastest = adaptation_krad_s(paper["scenario2", MRAC])
    gamma = f"{_inner(l1).adaptation_gain:.0e}".replace("e+0", "e")
    step = f"{1e3 / l1.scenario.controller.rate_hz:g} ms"
    return Finding(
        "explicit-integration",
        plant,
        "The MRAC column looks like a numerical artefact "
        + (f"in {' and '.join(near)}" if near else "in no axis")
        + (f", not in {' and '.join(far)}" if near and far else ""),
        f"Gamma = {gamma} makes the adaptation stiff ({slowest:.1f} to {fastest:.1f} krad/s). Solved accurately, MRAC "
        f"tracks as well as L1. An explicit Euler step of {step} gives it worse figures. {_sentence('; '.join(said))} "
        f"And the paper's L1 column cannot come from such a step: L1 under it {end}. "
        f"A plausible reading for {' and '.join(near) or 'no axis'}, then, and not a proof.",
        ("axis", "printed IAE / error [deg]", "solved accurately", f"explicit Euler, {step}", "furthest integral off"),
        [(*row, f"{100 * max(apart[axis]):.0f} %") for axis, row in zip(AXES, rows, strict=True)],
        f"uavftc-fly scenario2 --plant {plant} --controller nndondi-mrac "
        f"--set {EXPLICIT} --set controller.rate_hz={EXPLICIT_HZ:g}",
    )


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def saturation(flights: Flights, plant: str) -> Finding:
    """Whether the limits act in scenario 1."""
    paper = of_variant(flights, plant, "paper")
    free = paper["scenario1-unsaturated", L1]
    commands = {s: _history(free, f"{s}_cmd_rad") for s in SURFACES}
    rows: list[tuple[Any, ...]] = [(s, f"{v.min():.4f}", f"{v.max():.4f}") for s, v in commands.items()]
    low, high = paper["scenario1", L1].scenario.limits_rad()[0]  # of every surface
    binds = any(v.min() < low or v.max() > high for v in commands.values())
    halves: dict[tuple[str, str], list[float]] = {}
    for p in printed.tables():
        if p.table == 2 and p.metric in INTEGRALS and p.value is not None:
            halves.setdefault((p.axis, p.metric), []).append(p.value)
    apart = max(max(pair) / min(pair) - 1.0 for pair in halves.values())
    said = "do act" if binds else "never act: no command reaches them, so both halves of Table 2 are one flight"
    return Finding(
        "saturation",
        plant,
        "What saturation does in scenario 1",
        f"The limits of {low:g} and {high:+g} rad {said}. The printed halves differ by up to "
        f"{100 * apart:.0f} % in an integral.",
        ("surface", "least command [rad]", "largest command [rad]"),
        rows,
        f"uavftc-fly scenario1-unsaturated --plant {plant}",
    )


def rudder_reading(flights: Flights, plant: str) -> Finding:
    """The rudder's effectiveness 0.2 t, literal and as a constant."""
    literal = of_variant(flights, plant, "paper")["scenario3", L1]
    constant = of_variant(flights, plant, "constant rudder effectiveness")["scenario3", L1]
    _, fault = rudder_fault(literal.scenario)
    window, law = f"{fault.start_s:g}-{fault.end_s:g} s", str(fault.effectiveness.written).replace("*", " ")
    omega = fault.effectiveness.sample(np.array([fault.start_s, fault.end_s]))
    least, most, value = min(omega), max(omega), f"{RUDDER_CONSTANT:g}"
    rows: list[tuple[Any, ...]] = []
    peaks: list[float] = []
    for name, flown in ((f"{law}, as printed ({least:g} to {most:g})", literal), (f"{value}, constant", constant)):
        psi, reference, t = (_history(flown, n) for n in ("psi_rad", "psi_ref_rad", "time_s"))
        peak = float(np.degrees(np.max(np.abs(reference - psi)[(t >= fault.start_s)])))
        peaks.append(peak)
        rows.append((name, f"{_metric(flown, 'yaw', 'iae'):.4f}", f"{peak:.2f}"))
    return Finding(
        "rudder-effectiveness",
        plant,
        f"The rudder effectiveness {law} is meant as printed",
        f"On {window} it is {least:g} to {most:g}, outside the paper's own (0, 1]. Read as a constant {value} the "
        f"heading is driven {peaks[1]:.1f} deg off, against {peaks[0]:.2f} deg with {law}; Table 5 prints an IAE of "
        f"{_printed(TABLE_OF['scenario3'], L1, 'yaw', 'iae'):.4f}.",
        (f"effectiveness on {window}", "yaw IAE", f"largest heading error after {fault.start_s:g} s [deg]"),
        rows,
        f"uavftc-fly scenario3 --plant {plant} --set {rudder_override(literal.scenario)}",
    )


ALL = (
    idle_observer,
    loop_delay,
    fault_scale,
    printed_gain,
    explicit_integration,
    saturation,
    rudder_reading,
)


def findings(flights: Flights, plant: str) -> list[Finding]:
    """Return all findings of one plant."""
    return [finding(flights, plant) for finding in ALL]


def conditions(flights: Flights, plant: str) -> Mapping[str, tuple[str, Mapping[tuple[str, str], Flown]]]:
    """Return the named conditions under which the ordering claims are asked again (`tables.claims_of`)."""
    explicit = {**of_variant(flights, plant, "paper"), **of_variant(flights, plant, "explicit")}
    explicit = {k: v for k, v in explicit.items() if k[1] == MRAC} | {
        k: v for k, v in of_variant(flights, plant, "paper").items() if k[1] == L1
    }
    return {
        f"a gyro bias of {GYRO_BIAS_DEGPS} deg/s": (NDI_L1, of_variant(flights, plant, "gyro bias")),
        f"a loop delay of {CLAIM_DELAY_MS:g} ms": (MRAC, of_variant(flights, plant, "delay", CLAIM_DELAY_MS)),
        f"an MRAC integrated by explicit Euler at {1e3 / EXPLICIT_HZ:g} ms": (MRAC, explicit),
    }


__all__ = ["Finding", "Key", "Row", "best_scale", "conditions", "findings", "ratio", "scores_by_scale"]
