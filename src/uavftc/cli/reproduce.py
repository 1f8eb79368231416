"""`uavftc reproduce`: section 4 of the paper again, each number next to the printed one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uavftc.cli.options import NoPlots, Quiet
from uavftc.cli.outcome import UNEXPECTED
from uavftc.errors import InputError

if TYPE_CHECKING:
    from uavftc.jobs.paper.reproduction import Reproduction

_PLANTS = {"analytic": ("analytic",), "jsbsim": ("jsbsim",), "both": ("analytic", "jsbsim")}


SHORT = "The paper's tables and figures, printed next to ours."
EXAMPLES = (
    "uavftc reproduce",
    "uavftc reproduce --no-plots --out results/paper",
)


def reproduce(
    plant: Annotated[str, typer.Option(help="analytic, jsbsim or both.")] = "both",
    out: Annotated[Path, typer.Option(metavar="DIR", help="Result folder.")] = Path("results/reproduce"),
    no_plots: NoPlots = False,
    quiet: Quiet = False,
) -> None:
    """Fly the paper's scenarios with all its controllers and write Tables 2 to 6 and Figures 2 to 11 next to the print.

    Writes reproduction.md (the page to read), reproduce.json, tables.csv, improvements.csv, summary.json and figures.
    """
    if plant not in _PLANTS:
        raise InputError(
            f"--plant {plant}", found=f"'{plant}'", expected="analytic, jsbsim or both", remedy="choose one of them"
        )
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.paper.reproduction import reproduce as run  # noqa: PLC0415
    from uavftc.report.progress import stages  # noqa: PLC0415

    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    with stages(quiet=quiet) as advance:
        result = run(_PLANTS[plant], out, figures=not no_plots, advance=advance)
    if not quiet:
        _print(result, out)
    if result.figures_missing is not None:
        print(f"error: {out} has no figures: {result.figures_missing}", file=sys.stderr)
        raise typer.Exit(UNEXPECTED)


def _print(result: Reproduction, out: Path) -> None:
    from uavftc.jobs.paper.terminal import print_reproduction  # noqa: PLC0415
    from uavftc.report.console import Terminal  # noqa: PLC0415

    print_reproduction(Terminal(), result, out)
