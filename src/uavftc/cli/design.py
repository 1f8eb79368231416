"""`uavftc design AIRCRAFT`: the design of the inner loop, and what theory says of it, as numbers."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli import complete
from uavftc.errors import InputError

_POSITIVE = {"sigma_r", "airspeed_mps", "altitude_m"}
Float = Optional[float]  # noqa: UP045 - typer reads it


SHORT = "Trim, linear model, modes, gains and bounds of an aircraft."
EXAMPLES = (
    "uavftc design hale",
    "uavftc design jsbsim:c172p --figure c172p.png",
)


def design(
    aircraft: Annotated[
        str,
        typer.Argument(
            metavar="AIRCRAFT",
            help="A shipped aircraft (hale), a folder, or jsbsim:NAME (jsbsim:c172p).",
            autocompletion=complete.aircraft,
        ),
    ],
    *,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")] = False,
    scenario: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(metavar="SCENARIO", help="Take controller, condition and reference from here; default scenario1."),
    ] = None,
    flight: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(metavar="SCENARIO", help="Fly this scenario, and compare it with the reference system."),
    ] = None,
    overrides: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--set", metavar="KEY=VALUE", help="Change one scenario value, such as controller.rate_hz=500."),
    ] = None,
    airspeed_mps: Annotated[Float, typer.Option(help="Trim here; default the aircraft's, or chosen.")] = None,
    altitude_m: Annotated[Float, typer.Option(help="Trim here; default the aircraft's, or 1500.")] = None,
    figure: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="FILE", help="Draw poles, authority and B to a .png, .svg or .pdf file."),
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace the file of --figure even if uavftc did not write it.")
    ] = False,
    write_companion: Annotated[
        bool, typer.Option("--write-companion", help="Write what was found into AIRCRAFT/uavftc.yaml, to be edited.")
    ] = False,
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
    """Print AIRCRAFT's trim, linear model, modes, authority, and its inner loop's gains, L1 norms and bounds.

    Exit code 0: it loads and trims; the verdict says whether the controller can fly it. 2: the input is wrong, or there
    is no trim. What has no value is null, with the reason.
    """
    stated = {
        "sigma_0": sigma_0,
        "sigma_r": sigma_r,
        "r_max": r_max,
        "delta_5": delta_5,
        "lipschitz": lipschitz,
        "gamma_0": gamma_0,
    }
    condition = {"airspeed_mps": airspeed_mps, "altitude_m": altitude_m}
    for name, value in (stated | condition).items():
        _check(name, value)
    factors = _omega(omega)
    if figure is not None:
        from uavftc.results.single import check_figure  # noqa: PLC0415

        check_figure("--figure", figure, force=force)
    changes = [*(overrides or ()), *(f"initial.{k}={v!r}" for k, v in condition.items() if v is not None)]

    from uavftc.aircraft.definition import load_aircraft  # noqa: PLC0415 - what a bad option does not need is not imported
    from uavftc.analysis.l1_condition import Given  # noqa: PLC0415
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.design.document import DEFAULT_SCENARIO, design_document  # noqa: PLC0415
    from uavftc.scenario.load import load_scenario  # noqa: PLC0415

    listed = scenario is None and flight is None and not changes  # designed as `uavftc aircraft` lists it
    definition = load_aircraft(aircraft, "AIRCRAFT")  # before the scenarios, which would name it as an option
    if write_companion:
        from uavftc.jobs.design import companion  # noqa: PLC0415

        companion.check(definition)
    if scenario is None and flight is None:
        scenario = DEFAULT_SCENARIO
    design_of, flown = (
        None if name is None else load_scenario(name, aircraft=aircraft, overrides=changes)
        for name in (scenario, flight)
    )
    if flight is not None and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    document = design_document(aircraft, scenario=design_of, flight=flown, given=Given(**stated), omega=factors)
    if listed:
        from uavftc.jobs.design import fleet  # noqa: PLC0415

        fleet.remember(aircraft)
    if write_companion:
        source = design_of or flown
        assert source is not None
        written = companion.write(source, definition)
        what = f"A and B within {written.model:.1g}, limits within {written.limits:.1g} of what was measured without"
        print(f"companion: {written.file} (read back: {what})", file=sys.stderr)
    if figure is not None:
        from uavftc.report.backend import load_matplotlib  # noqa: PLC0415

        load_matplotlib()
        from uavftc.report.design_figure import write_design_figure  # noqa: PLC0415

        write_design_figure(figure, document)
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
        return
    from uavftc.report.console import Terminal  # noqa: PLC0415
    from uavftc.report.design_text import print_design  # noqa: PLC0415

    print_design(Terminal(), document, aside=Terminal(stderr=True))
    if figure is not None:
        print(f"figure: {figure}")


def _check(name: str, value: float | None) -> None:
    if value is None or (math.isfinite(value) and value >= 0.0 and (value > 0.0 or name not in _POSITIVE)):
        return
    expected, bound = "above 0" if name in _POSITIVE else "0 or above", not name.endswith(("_mps", "_m"))
    raise InputError(
        f"--{name.replace('_', '-')} {value:g}",
        found=f"{value:g}",
        expected=f"a finite number, {expected}",
        remedy="leave the option out where the bound is not known: what depends on it is then null"
        if bound
        else "leave the option out for the aircraft's default condition",
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
            expected="one number, or three separated by commas, each above 0 and at most 1",
            remedy="write --omega 0.5, or --omega 0.5,0.7,1 for aileron, elevator and rudder",
        )
    return values[0], values[1], values[2]
