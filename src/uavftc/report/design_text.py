"""The design document for reading, in 80 to 100 columns. Plain ASCII, so that it prints anywhere."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.core.axes import left_to_the_airframe
from uavftc.core.signals import AXES, SURFACES
from uavftc.report import effectors_text
from uavftc.report.fleet_table import times

Line = Callable[..., None]

METHODS = {
    "jsbsim": "JSBSim's own trim",
    "own": "the project's trim",
    "glide": "a glide, no engines",
    "solved": "the project's trim, with servos and backlash",
}


def print_design(console: Console, document: dict[str, Any], *, aside: Console | None = None) -> None:
    """Print the document of `uavftc.jobs.design.document.design_document`; warnings on `aside`, where there is one."""

    def line(text: str, style: str = "") -> None:
        console.print(Text(text, style=style))

    _print_trimmed(console, line, document)
    _print_loop(console, line, document)
    for flown in document.get("flight", {}).get("flights", ()):
        _print_flight(line, document["flight"]["scenario"], flown)
    for warning in document["warnings"]:
        (aside or console).print(Text.assemble(("warning: ", "yellow"), warning))


def _print_trimmed(console: Console, line: Line, document: dict[str, Any]) -> None:
    trim, refused = document["trim"], document["verdict"] == "refused"
    has = [name for name in SURFACES if trim[f"{name}_rad"] is not None]
    line(f"{document['aircraft']}: {document['verdict']}", "bold red" if refused else "bold")
    for reason in document["reasons"]:
        line(f"  {reason}", "red")
    for text in missing(document):
        line(f"  {text}")
    console.print(
        _pairs(
            ("trim", f"{trim['airspeed_mps']:g} m/s, {trim['altitude_m']:g} m ({METHODS[trim['method']]})"),
            ("", f"{_attitude(trim)}, throttle {trim['throttle']:.4f}"),
            ("", "deflections " + ", ".join(f"{name} {_deg(trim[f'{name}_rad'])}" for name in has) + " deg"),
            ("", f"largest acceleration left {max(map(abs, trim['residual'].values())):.1e} (SI)"),
            ("mass", f"{document['mass_kg']:.6g} kg, {_engines(document['engines'])}"),
        )
    )
    table = _table("mode", "eigenvalue\n[1/s]", "frequency\n[rad/s]", "damping\n", "time\nconstant [s]")
    for mode in document["modes"]:
        real, imaginary = mode["eigenvalue"]
        periodic = imaginary != 0.0
        cells = (
            mode["name"],
            complex_text(real, imaginary, "+/-"),
            f"{mode['natural_frequency_radps']:.4g}" if periodic else "-",
            f"{mode['damping']:.3f}" if periodic else "-",
            "-" if mode["time_constant_s"] is None else f"{mode['time_constant_s']:.4g}",
        )
        table.add_row(*map(Text, cells), style="red" if real > 0.0 else "")
    _print_table(console, table)
    authority, controllability = document["authority"], document["controllability"]
    limits = document["limits_rad"]
    table = _table("", "limits\n[deg]", "step\n[deg]", "at once\n[deg]", "held\n[deg]", "authority\n")
    for j, (axis, surface) in enumerate(zip(AXES, SURFACES, strict=True)):
        found = authority[axis]
        row = [f"{axis} ({surface})"]
        row += ["-"] * 2 if limits[j] is None else [" .. ".join(map(_deg, limits[j])), _deg(authority["step_rad"][j])]
        if found is None:
            row += ["-"] * 3
        else:
            row += [_deg(found["first_rad"]), _deg(found["steady_rad"]), times(found["ratio"])]
        short = document["controlled"][axis] or refused
        table.add_row(*map(Text, row), style="red" if short and not (found and found["ratio"] >= 1.0) else "")
    _print_table(console, table)
    _print_effectors(console, line, document)
    reported = dict(zip(SURFACES, document["deflection_measured"], strict=True))
    if unknown := [name for name in has if not reported[name]]:
        line(f"deflection not reported by the aircraft, full command counts as 20 deg: {', '.join(unknown)}")
    condition = controllability["condition"]
    rank = f"rate loop: rank {controllability['rank']} of {controllability['axes']}, condition of B "
    rank += "-" if condition is None else f"{condition:.4g}"
    line(f"{rank} (at most {controllability['condition_max']:g})")


def _print_effectors(console: Console, line: Line, document: dict[str, Any]) -> None:
    effectors = document["effectors"]
    if effectors_text.has_table(effectors):
        headers = ["roll\n", "pitch\n", "yaw\n", "p_dot\n[1/s^2]", "q_dot\n[1/s^2]", "r_dot\n[1/s^2]"]
        table = _table("", "limits\n[deg]", *headers)
        for row in effectors_text.rows(effectors):
            table.add_row(*map(Text, row))
        console.print(table)
        line("roll, pitch, yaw: deflection per deflection of the axis; p_dot, q_dot, r_dot: effect per rad\n")
    for text in (*effectors_text.servo_lines(effectors), *effectors_text.full_lines(effectors)):
        line(text)


def _print_loop(console: Console, line: Line, document: dict[str, Any]) -> None:
    line("\ninner loop", "bold")
    matrices = (
        ("A", "of p, q, r at the trim, 1/s"),
        ("B", "of p, q, r at the trim, 1/s^2 per rad"),
        ("A_m", "reference model, 1/s"),
        ("A_s", "A_m + K_1, 1/s"),
        ("K", f"reference gain ({document['reference_gain']}), rad per rad/s"),
        ("K_0", "linear feedback, rad per rad/s"),
        ("P", "of the Lyapunov equation"),
    )
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_header=False, show_edge=False)
    for name, what in matrices:
        rows = document[name] or []
        text = "\n".join(" ".join(f"{fixed(value):>9}" for value in row) for row in rows) or "none"
        table.add_row(Text(name, style="bold"), Text(text), Text(what))
    _print_table(console, table)
    for name in ("A_m", "A_s"):
        line(f"eigenvalues of {name}: {', '.join(complex_text(*pair) for pair in document[f'eigenvalues_{name}'])}")
    table = _table("", "with A_s (printed)", "with A_m")
    figures = (
        ("||H||", "l1_norm_H"),
        ("||G||", "l1_norm_G"),
        ("||H C K||", "l1_norm_HCK"),
        ("condition (33) holds", "condition_holds"),
        ("largest Lipschitz constant", "lipschitz_max"),
        ("gamma_1 [rad/s]", "gamma_1"),
        ("gamma_2 [rad]", "gamma_2"),
    )
    for label, key in figures:
        table.add_row(Text(label), *(Text(_cell(document[key + suffix])) for suffix in ("", "_A_m")))
    _print_table(console, table)
    for key in ("condition_reason", "lipschitz_max_is", "reason"):
        texts = {document[key + suffix] for suffix in ("", "_A_m")} - {None}
        for text in sorted(texts):
            line(f"{key.replace('_', ' ')}: {text}")
    theorem_2 = document["theorem_2"]
    factors = theorem_2["weighted"]
    line(
        f"Theorem 2, weighted by lambda_min(Q): int |x2_tilde|^2 dt <= {factors['per_V']:.4g} V(0) + "
        f"{factors['per_e']:.4g} int |e_min|^2 dt"
    )
    if theorem_2["reason"]:
        line(f"eq. (44) as printed gives none: {theorem_2['reason']}")


def _print_flight(line: Line, scenario: str, flown: dict[str, Any]) -> None:
    line(f"\n{scenario} on {flown['plant']}", "bold")
    if not flown["completed"]:
        line(f"ended early: {flown['ended_because']}", "red")
    largest = max(r for r in flown["max_r_radps"] if r is not None)
    line(f"max |x2_tilde| {flown['gamma_0']:.3g} rad/s; max |r| {largest:.4g} rad/s")
    for name, found in (flown["reference_system"] or {}).items():
        bound = (flown["bounds"] or {}).get(name)
        against = "" if bound is None else f" (gamma_1 {bound['gamma_1']:.3g})"
        also = "" if bound is None else f" (gamma_2 {bound['gamma_2']:.3g})"
        line(
            f"reference system {name}: max |x_ref - x2| {found['largest_radps']:.3g} rad/s{against}, "
            f"{100.0 * found['share_of_max_r']:.1f} % of max |r|; "
            f"max |v_ref - v_ad| {found['largest_rad']:.3g} rad{also}"
        )
    for text in flown["assumptions_not_met"]:
        line(f"assumption not met: {text}")
    if flown["reason"]:
        line(flown["reason"])


def _table(*headers: str) -> Table:
    """Return a table of narrow columns: in 80 characters every number is whole."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 0, 0, 1), show_edge=False)
    for header in headers:
        table.add_column(Text(header), justify="left" if header in ("", "mode") else "right", overflow="fold")
    return table


def _print_table(console: Console, table: Table) -> None:
    console.print()
    console.print(table)
    console.print()


def _pairs(*rows: tuple[str, str]) -> Table:
    table = Table.grid(padding=(0, 2))
    for name, text in rows:
        table.add_row(Text(name), Text(text))
    return table


def _attitude(trim: dict[str, Any]) -> str:
    angles: Sequence[tuple[str, float]] = [(name, trim[f"{name}_rad"]) for name in ("alpha", "theta", "phi")]
    path = "" if trim["method"] != "glide" else f", path {_deg(trim['gamma_rad'])}"
    return ", ".join(f"{name} {_deg(value)}" for name, value in angles) + path + " deg"


def _engines(count: int) -> str:
    return {0: "no engine", 1: "1 engine"}.get(count, f"{count} engines")


def _deg(value: float) -> str:
    return f"{round(math.degrees(value), 3) + 0.0:.2f}"  # + 0.0: no minus before a zero


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return ("yes" if value else "no") if isinstance(value, bool) else f"{value:.6g}"


def missing(document: dict[str, Any]) -> list[str]:
    """Return a line for each axis that the aircraft does not control."""
    roll, pitch, yaw = (document["controlled"][axis] for axis in AXES)
    return left_to_the_airframe((roll, pitch, yaw))


def fixed(value: float | None) -> str:
    """Return a number with four decimals, zero without a sign; None is a dash."""
    if value is None:
        return "-"
    return f"{round(value, 4) + 0.0:.4f}"


def complex_text(real: float, imaginary: float, sign: str = "") -> str:
    """Return a complex number, or with `sign` "+/-" the pair it stands for."""
    if not imaginary:
        return fixed(real)
    return f"{fixed(real)} {sign or ('+' if imaginary > 0 else '-')} {abs(imaginary):.4f}j"
