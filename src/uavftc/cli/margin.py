"""`uavftc margin SCENARIO`: how far each controller is from failing, along each of several quantities."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli.options import (
    AircraftName,
    Controllers,
    NoPlots,
    Overrides,
    PlantName,
    Quiet,
    ScenarioName,
    default_folder,
)
from uavftc.cli.outcome import UNEXPECTED

SHORT = "Find how much delay, gain, noise or fault it takes to fail."
EXAMPLES = (
    "uavftc margin scenario2 --controllers nndondi-l1,pid --quantity delay",
    "uavftc margin scenario3 --over 'faults[3].effectiveness=0..1'",
)


def margin(
    scenario: ScenarioName,
    controllers: Controllers = None,
    quantity: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(
            metavar="LIST",
            help="delay, gain, gain_reduction, actuator_bandwidth, effectiveness, bias, gyro_noise, separated by "
            "commas; effectiveness:rudder for one effector. Default: all.",
        ),
    ] = None,
    over: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option("--over", metavar="KEY=LOW..HIGH", help="Any number of the scenario, first where it survives."),
    ] = None,
    plant: PlantName = None,
    aircraft: AircraftName = None,
    overrides: Overrides = None,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default results/margin-<scenario>-<plant>."),
    ] = None,
    no_plots: NoPlots = False,
    quiet: Quiet = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the limits as JSON on standard output.")] = False,
) -> None:
    """Find the delay, gain, bandwidth, effectiveness, bias and noise at which the verdict on SCENARIO changes.

    Each range is scanned first, then the first change is bracketed to 1 %; no limit is given without its bracket.
    Exit code 0: done. 2: the input is wrong, nothing is written. 130: Ctrl-C, nothing is written.
    """
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.margin.limits import find_and_write, load  # noqa: PLC0415
    from uavftc.report.progress import stages  # noqa: PLC0415
    from uavftc.scenario.load import find_scenario  # noqa: PLC0415

    loaded = load(scenario, controllers=controllers, plant=plant, aircraft=aircraft, overrides=overrides or ())
    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    first = next(iter(loaded.values()))
    folder = out if out is not None else default_folder(f"margin-{first.name}-{first.plant}", aircraft)
    names = None if quantity is None else [name.strip() for name in quantity.split(",")]
    with stages(quiet=quiet) as advance:
        document = find_and_write(
            loaded,
            folder,
            quantities=names,
            over=over or (),
            figures=not no_plots,
            progress=advance,
            inputs=[find_scenario(scenario)],
        )
    if as_json:
        shown = [{key: value for key, value in entry.items() if key != "curve"} for entry in document["limits"]]
        print(json.dumps(shown, indent=2, allow_nan=False))
    if not quiet:
        from uavftc.report.console import Terminal  # noqa: PLC0415
        from uavftc.report.margin_text import print_limits  # noqa: PLC0415

        console = Terminal(stderr=as_json)
        print_limits(console, document["title"], document["limits"])
        console.print(f"results: {folder}", soft_wrap=True)
    if "figures_missing" in document:
        print(f"error: {folder} has no figure: {document['figures_missing']}", file=sys.stderr)
        raise typer.Exit(UNEXPECTED)
