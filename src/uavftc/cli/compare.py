"""`uavftc compare SCENARIO`: one scenario on several plants and by several controllers, side by side."""

from __future__ import annotations

import functools
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
    Quiet,
    Report,
    ScenarioName,
    default_folder,
)
from uavftc.cli.outcome import LOST, UNEXPECTED, missing_lines

SHORT = "Several controllers, or both plants, side by side."
EXAMPLES = (
    "uavftc compare scenario3 --controllers nndondi-l1,pid,lqi",
    "uavftc compare scenario2 --variant slow:controller.outer.bandwidth=0.3",
)


def compare(
    scenario: ScenarioName,
    plants: Annotated[str, typer.Option(metavar="LIST", help="Plants, separated by commas.")] = "jsbsim,analytic",
    controllers: Controllers = None,
    variants: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Option(
            "--variant",
            metavar="NAME:KEY=VALUE",
            help="Fly the first controller again with a key changed, such as fast:controller.inner.filter_bandwidth=120"
            " or k6:controller.options.k=6; several of one name are one variant.",
        ),
    ] = None,
    aircraft: AircraftName = None,
    overrides: Overrides = None,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default results/compare-<scenario>."),
    ] = None,
    no_plots: NoPlots = False,
    report: Report = False,
    quiet: Quiet = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json, and nothing else, on stdout.")] = False,
) -> None:
    """Fly SCENARIO by every combination of plant and controller, and write tables, histories and figures.

    By default this is how JSBSim compares with the analytic model. Exit code 0: all flown to the end. 2: the input is
    wrong, nothing is written. 3: a vehicle was lost, everything is written. 130: Ctrl-C, nothing is written.
    """
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.compare import compare as fly_and_compare  # noqa: PLC0415
    from uavftc.jobs.compare import load_combinations  # noqa: PLC0415
    from uavftc.jobs.report import page_of_comparison  # noqa: PLC0415
    from uavftc.report.page.html import require_extra  # noqa: PLC0415
    from uavftc.report.progress import progress  # noqa: PLC0415
    from uavftc.scenario.load import find_scenario  # noqa: PLC0415

    if report:
        require_extra("--report")
    loaded = load_combinations(
        scenario,
        plants=plants,
        controllers=controllers,
        aircraft=aircraft,
        overrides=overrides or (),
        variants=variants or (),
    )
    first = next(iter(loaded.values()))
    folder = out if out is not None else default_folder(f"compare-{first.name}", aircraft)
    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    document = fly_and_compare(
        loaded,
        folder,
        figures=not no_plots,
        progress=functools.partial(progress, quiet=quiet),
        inputs=[find_scenario(scenario)],
        page=page_of_comparison if report else None,
    )
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
    if not quiet:
        from uavftc.report.console import Terminal  # noqa: PLC0415
        from uavftc.report.side_by_side import print_comparison  # noqa: PLC0415

        print_comparison(Terminal(stderr=as_json), document, folder, aside=Terminal(stderr=True))
    lacking = missing_lines(document, folder)
    for line in lacking:
        print(line, file=sys.stderr)
    if not document["completed"]:
        raise typer.Exit(LOST)
    if lacking:
        raise typer.Exit(UNEXPECTED)
