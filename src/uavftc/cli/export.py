"""`uavftc export DIR`: the history of a result folder as CSV and as a MATLAB file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli.options import Quiet

SHORT = "A flight's history as CSV, or for MATLAB."
EXAMPLES = (
    "uavftc export results/scenario3-nndondi-l1-jsbsim --csv scenario3.csv",
    "uavftc export results/mine --mat mine.mat",
)


def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A result folder: of fly or compare.")],
    csv: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option("--csv", metavar="FILE", help="Write the history as CSV."),
    ] = None,
    mat: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option("--mat", metavar="FILE", help="Write history, units, summary and scenario for MATLAB."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace files that are there.")] = False,
    quiet: Quiet = False,
) -> None:
    """Write the history of DIR, every signal at every sample, for other programs; every number reads back the same.

    Of a comparison each flight has a file of its own, named FILE-<plant>-<controller>.

    Exit code 0: written. 2: the folder is not one of a flight or a comparison, or a file is there already; nothing is
    written.
    """
    from uavftc.jobs.export.job import export as write  # noqa: PLC0415

    for path in write(folder, {"csv": csv, "mat": mat}, force=force):
        if not quiet:
            print(f"written: {path}")
