"""`uavftc design AIRCRAFT`: the design of the inner loop, and what theory says of it, as numbers."""

from __future__ import annotations

import json
import math
import sys
from typing import TYPE_CHECKING, Annotated, Any, Optional

import typer

from uavftc.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

_POSITIVE = {"sigma_r"}
Float = Optional[float]  # noqa: UP045 - typer reads it


def design(
    aircraft: Annotated[
        str, typer.Argument(metavar="AIRCRAFT", help="Name of a shipped aircraft, or the folder of one.")
    ],
    *,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")] = False,
    scenario: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(metavar="SCENARIO", help="Take controller and initial condition from this scenario."),
    ] = None,
    flight: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(metavar="SCENARIO", help="Fly this scenario, and compare it with the reference system."),
    ] = None,
    overrides: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Change one value of the scenarios, as controller.rate_hz=500."
        ),
    ] = None,
    sigma_0: Annotated[Float, typer.Option(help="Bound of the initial body rates, rad/s.")] = None,
    sigma_r: Annotated[Float, typer.Option(help="Bound of the reference rates to be shown, rad/s.")] = None,
    r_max: Annotated[Float, typer.Option(help="Bound of the commanded rates, rad/s.")] = None,
    delta_5: Annotated[Float, typer.Option(help="Bound of the lumped disturbance at rest, rad.")] = None,
    lipschitz: Annotated[Float, typer.Option(help="Lipschitz constant L, rad per rad/s.")] = None,
    gamma_0: Annotated[Float, typer.Option(help="Bound of the prediction error, rad/s, for Theorem 3.")] = None,
    omega: Annotated[
        str, typer.Option(metavar="W[,W,W]", help="Constant effectiveness in C(s), one number or one a surface.")
    ] = "1",
) -> None:
    """Print trim, linear model, gains, L1 norms, the L1-norm condition and the bounds of AIRCRAFT's inner loop.

    Exit code 2: the input is wrong. What has no value is null, with the reason.
    """
    stated = {
        "sigma_0": sigma_0,
        "sigma_r": sigma_r,
        "r_max": r_max,
        "delta_5": delta_5,
        "lipschitz": lipschitz,
        "gamma_0": gamma_0,
    }
    for name, value in stated.items():
        _check(name, value)
    factors = _omega(omega)
    if overrides and scenario is None and flight is None:
        raise InputError(
            f"--set {overrides[0]}",
            found="no scenario to change",
            expected="--scenario or --flight beside it",
            remedy="name the scenario whose value is to be changed",
        )

    from uavftc.aircraft import load_aircraft  # noqa: PLC0415 - what a bad option does not need is not imported
    from uavftc.analysis.l1_condition import Given  # noqa: PLC0415
    from uavftc.design.document import design_document  # noqa: PLC0415
    from uavftc.scenario.load import load_scenario  # noqa: PLC0415
    from uavftc.stage import is_compiled  # noqa: PLC0415

    load_aircraft(aircraft, "AIRCRAFT")  # before the scenarios, which would name it as an option
    loaded = [
        None if name is None else load_scenario(name, aircraft=aircraft, overrides=overrides or ())
        for name in (scenario, flight)
    ]
    if flight is not None and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    document = design_document(aircraft, scenario=loaded[0], flight=loaded[1], given=Given(**stated), omega=factors)
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
        return
    from rich.console import Console  # noqa: PLC0415

    print_design(Console(highlight=False), document)


def _check(name: str, value: float | None) -> None:
    if value is None or (math.isfinite(value) and value >= 0.0 and (value > 0.0 or name not in _POSITIVE)):
        return
    wanted = "above 0" if name in _POSITIVE else "0 or above"
    raise InputError(
        f"--{name.replace('_', '-')} {value:g}",
        found=f"{value:g}",
        expected=f"a finite number, {wanted}",
        remedy="leave the option out where the bound is not known: what depends on it is then null",
    )


def _omega(text: str) -> tuple[float, float, float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) == 1:
        values *= 3
    if len(values) != 3 or not all(0.0 < value <= 1.0 for value in values):
        raise InputError(
            f"--omega {text}",
            found=repr(text),
            expected="one number, or three with commas between, each above 0 and at most 1",
            remedy="write --omega 0.5, or --omega 0.5,0.7,1 for aileron, elevator and rudder",
        )
    return values[0], values[1], values[2]


# --- for reading -----------------------------------------------------------------------------------------------------


def print_design(console: Console, document: dict[str, Any]) -> None:
    """Print the document of `uavftc.design.document.design_document` for reading."""
    from rich import box  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    def line(text: str, style: str = "") -> None:
        console.print(Text(text, style=style), soft_wrap=True)

    line(f"{document['aircraft']}: design of the inner loop", "bold")
    trim = document["trim"]
    left = max(abs(value) for value in trim["residual"].values())
    line(
        f"level trim on JSBSim at {trim['airspeed_mps']:g} m/s, {trim['altitude_m']:g} m: "
        f"alpha = theta = {_fixed(math.degrees(trim['alpha_rad']))} deg, "
        f"elevator {_fixed(math.degrees(trim['elevator_rad']))} deg, "
        f"throttle {trim['throttle']:.4f}; largest acceleration left {left:.1e} (SI)"
    )
    matrices = (
        ("A", "of JSBSim at the trim, 1/s"),
        ("B", "of JSBSim at the trim, 1/s^2"),
        ("A_m", "reference model, 1/s"),
        ("A_s", "A_m + K_1, 1/s"),
        ("K", f"reference gain ({document['reference_gain']}), rad per rad/s"),
        ("K_0", "linear feedback, rad per rad/s"),
        ("P", "of the Lyapunov equation"),
    )
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_header=False)
    for name, what in matrices:
        text = "\n".join(" ".join(f"{_fixed(value):>9}" for value in row) for row in document[name])
        table.add_row(Text(name, style="bold"), Text(text), Text(what))
    console.print(table)
    for name in ("A_m", "A_s"):
        line(f"eigenvalues of {name}: {', '.join(_complex(*pair) for pair in document[f'eigenvalues_{name}'])}")
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for header in ("", "with A_s (printed)", "with A_m"):
        table.add_column(header, justify="right" if header else "left")
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
    console.print(table)
    for key in ("condition_reason", "lipschitz_max_is", "reason"):
        told = {document[key + suffix] for suffix in ("", "_A_m")} - {None}
        for text in sorted(told):
            line(f"{key.replace('_', ' ')}: {text}")
    if document["theorem_2"]["reason"]:
        line(f"no bound of Theorem 2: {document['theorem_2']['reason']}")
    for flown in document.get("flight", {}).get("flights", ()):
        _print_flight(line, document["flight"]["scenario"], flown)


def _print_flight(line: Any, scenario: str, flown: dict[str, Any]) -> None:
    line(f"\n{scenario} on {flown['plant']}", "bold")
    if not flown["completed"]:
        line(f"ended early: {flown['ended_because']}", "red")
    line(f"max |x2_tilde| {flown['gamma_0']:.3g} rad/s; max |r| {max(flown['max_r_radps']):.4g} rad/s")
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


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return ("yes" if value else "no") if isinstance(value, bool) else f"{value:.6g}"


def _fixed(value: float) -> str:
    return f"{round(value, 4) + 0.0:.4f}"  # + 0.0: no minus before a zero


def _complex(real: float, imaginary: float) -> str:
    return f"{real:.4f}" + (f" {'+' if imaginary > 0 else '-'} {abs(imaginary):.4f}j" if imaginary else "")
