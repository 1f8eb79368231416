"""`uavftc survivable SCENARIO`: is there a steady state at the reference with what is left of the aircraft?"""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli.options import AircraftName, NoPlots, Overrides, PlantName, Quiet, ScenarioName, default_folder
from uavftc.cli.outcome import UNEXPECTED
from uavftc.errors import InputError

SHORT = "Could any controller hold it, with what is left?"
EXAMPLES = (
    "uavftc survivable beyond/engine-loss",
    "uavftc survivable beyond/fault-hardover-stop --json",
)


def survivable(
    scenario: ScenarioName,
    plant: PlantName = None,
    aircraft: AircraftName = None,
    overrides: Overrides = None,
    within_deg: Annotated[float, typer.Option(help="How near to the reference a steady state must be, deg.")] = 1.0,
    sweep: Annotated[
        bool,
        typer.Option(
            "--sweep/--no-sweep", help="Look at the worst phase at shares of its faults and at other airspeeds too."
        ),
    ] = True,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default results/survivable-<scenario>."),
    ] = None,
    no_plots: NoPlots = False,
    quiet: Quiet = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json, and nothing else, on stdout.")] = False,
) -> None:
    """Say whether any controller could hold SCENARIO's reference: a steady state with what faults and limits leave.

    Nothing is flown. Exit code 0: it was found out, whatever the answer. 2: the input is wrong, nothing is written.
    130: Ctrl-C, nothing is written.
    """
    if not (math.isfinite(within_deg) and 0.0 < within_deg <= 45.0):
        raise InputError(
            f"--within-deg {within_deg:g}",
            found=f"{within_deg:g}",
            expected="an angle above 0, up to 45",
            remedy="leave it out for 1 deg",
        )
    from uavftc.core.stage import is_compiled  # noqa: PLC0415 - what a bad option does not need is not imported
    from uavftc.jobs.survivable.job import write_survivable  # noqa: PLC0415
    from uavftc.report.progress import stages  # noqa: PLC0415
    from uavftc.scenario.load import find_scenario, load_scenario  # noqa: PLC0415

    loaded = load_scenario(scenario, overrides=overrides or (), plant=plant, aircraft=aircraft)
    folder = out if out is not None else default_folder(f"survivable-{loaded.name}", aircraft)
    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    with stages(quiet=quiet) as advance:
        document = write_survivable(
            loaded,
            folder,
            within_deg=within_deg,
            sweep=sweep,
            figures=not no_plots,
            advance=advance,
            inputs=[find_scenario(scenario)],
        )
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
    if not quiet:
        from uavftc.report.console import Terminal  # noqa: PLC0415
        from uavftc.report.survivable_text import print_survivable  # noqa: PLC0415

        print_survivable(Terminal(stderr=as_json), document, folder, aside=Terminal(stderr=True))
    if "figures_missing" in document:
        print(f"error: {folder} has no figure: {document['figures_missing']}", file=sys.stderr)
        raise typer.Exit(UNEXPECTED)
