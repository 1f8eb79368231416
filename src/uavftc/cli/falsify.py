"""`uavftc falsify CAMPAIGN`: the fault inside the ranges of a campaign that breaks a controller."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal, Optional

import typer

from uavftc.cli.options import CampaignName, CampaignOverrides, Cluster, NoPlots, Quiet, Resume, Workers
from uavftc.cli.outcome import UNEXPECTED

SHORT = "Search a campaign's ranges for what breaks a controller."
EXAMPLES = (
    "uavftc falsify falsify-paper --budget 200",
    "uavftc falsify falsify-paper --objective nearest --out results/nearest",
)


def falsify(
    campaign: CampaignName,
    budget: Annotated[int, typer.Option(min=1, metavar="N", help="Flights of each controller.")] = 500,
    objective: Annotated[
        Literal["margin", "nearest"],
        typer.Option(help="margin: the lowest margin; nearest: the failure nearest to nominal."),
    ] = "margin",
    seed: Annotated[
        Optional[int],  # noqa: UP045
        typer.Option(min=0, metavar="S", help="Of the search; default: that of the campaign."),
    ] = None,
    workers: Workers = None,
    cluster: Cluster = None,
    controller: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(metavar="NAME", help="Search this controller in place of those of the campaign."),
    ] = None,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default results/falsify-<campaign>."),
    ] = None,
    resume: Resume = False,
    overrides: CampaignOverrides = None,
    no_plots: NoPlots = False,
    quiet: Quiet = False,
) -> None:
    """Search the ranges of CAMPAIGN for what breaks each controller, and write the scenario found: found.yaml.

    A flight breaks it whose verdict is not `survived`. Exit code 0: it was searched, whatever was found. 2: the input
    is wrong, nothing is written. 130: Ctrl-C; what was flown is kept, and --resume goes on.
    """
    from uavftc.control.custom.module import is_path  # noqa: PLC0415
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.campaign.sweep import ready  # noqa: PLC0415
    from uavftc.jobs.falsify.job import Asked, Falsify  # noqa: PLC0415
    from uavftc.report.rate import Rate  # noqa: PLC0415
    from uavftc.scenario.campaign import find_campaign, load_campaign  # noqa: PLC0415
    from uavftc.scenario.text import value_text  # noqa: PLC0415

    changes = list(overrides or ())
    if controller is not None:
        name = str(Path(controller).resolve()) if is_path(controller) else controller
        changes.append(f"controllers={value_text([name])}")
    made = ready(load_campaign(campaign, changes))
    folder = out if out is not None else Path("results") / f"falsify-{made.campaign.name}"
    asked = Asked(objective, budget, made.campaign.seed if seed is None else seed)
    job = Falsify(made, folder, asked, resume=resume, inputs=(find_campaign(campaign), made.campaign.base_file))
    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    rate = Rate()
    try:
        summary = job.fly(workers=workers, cluster=cluster, figures=not no_plots, progress=None if quiet else rate)
    except (KeyboardInterrupt, OSError) as error:
        rate.end()
        if job.begun:
            kept = f"{job.done} flights are kept in {folder}; --resume goes on"
            if isinstance(error, OSError):
                print(f"error: {error.strerror or error}; {kept}", file=sys.stderr)
                raise typer.Exit(UNEXPECTED) from None
            print(kept, file=sys.stderr)
        raise
    rate.end()
    for name in job.unlike:
        print(
            f"warning: {name} flies to another margin alone: its controller keeps something from flight to flight",
            file=sys.stderr,
        )
    if not quiet:
        from uavftc.report.console import Terminal  # noqa: PLC0415
        from uavftc.report.falsify_text import print_falsify  # noqa: PLC0415

        print_falsify(Terminal(), summary, folder)
    if "figures_missing" in summary:
        print(f"error: {folder} has no figure: {summary['figures_missing']}", file=sys.stderr)
        raise typer.Exit(UNEXPECTED)
