"""`uavftc report DIR`: the page of a result folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uavftc.cli.options import Quiet

SHORT = "Write one page to look at, from a result folder."
EXAMPLES = (
    "uavftc report results/scenario3-nndondi-l1-jsbsim",
    "uavftc report results/sweep-paper-faults",
)


def report(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="A result folder: of fly, compare, reproduce or sweep.")
    ],
    quiet: Quiet = False,
) -> None:
    """Write report.html into DIR: one page with plots to zoom, verdict, tables and, of a flight, a moving view.

    It needs the extra 'report' (pip install 'uavftc[report]'), and no network to be read.

    Exit code 0: written. 2: the folder is not one of uavftc's, was edited, or has nothing to show; nothing is changed.
    """
    from uavftc.jobs.report import report as write  # noqa: PLC0415

    path = write(folder)
    if not quiet:
        print(f"page: {path}")
