"""`uavftc sweep-report DIR`: what came of a campaign."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli.options import NoPlots, Quiet
from uavftc.cli.outcome import UNEXPECTED

SHORT = "Success, pairs, sensitivity and worst cases of a campaign."
EXAMPLES = (
    "uavftc sweep-report results/sweep-paper-faults",
    "uavftc sweep-report results/sweep-paper-faults --json > report.json",
)


def sweep_report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder that uavftc sweep wrote to.")],
    on_axes: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option("--map", metavar="X,Y", help="Keys of the map; default: the two most influential."),
    ] = None,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default DIR/report, of a campaign that is finished."),
    ] = None,
    no_plots: NoPlots = False,
    quiet: Quiet = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json, and nothing else, on stdout.")] = False,
) -> None:
    """Say how often each controller of a campaign holds, which is better on the same cases, and what matters most.

    Of a campaign that is not finished the cases that have ended count, and nothing is written but with --out. Exit code
    0: reported. 2: the input is wrong, nothing is written.
    """
    from uavftc.jobs.sweep_report.job import sweep_report as report  # noqa: PLC0415
    from uavftc.jobs.sweep_report.job import write_report  # noqa: PLC0415

    flown, document = report(folder, on_axes)
    written = None
    if flown.finished or out is not None:
        document = write_report(flown, document, out, figures=not no_plots)
        written = out if out is not None else folder / "report"
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
    if not quiet:
        from uavftc.report.campaign_text import print_report  # noqa: PLC0415
        from uavftc.report.console import Terminal  # noqa: PLC0415

        print_report(Terminal(stderr=as_json), document, written)
    if "figures_missing" in document:
        print(f"error: {written} has no figures: {document['figures_missing']}", file=sys.stderr)
        raise typer.Exit(UNEXPECTED)
