"""`uavftc sweep CAMPAIGN`: thousands of flights, each a row of one table."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli.options import CampaignName, CampaignOverrides, Cluster, Quiet, Resume, Workers
from uavftc.cli.outcome import UNEXPECTED

SHORT = "Fly a campaign: thousands of random cases in one table."
EXAMPLES = (
    "uavftc sweep paper-faults --set cases=60",
    "uavftc sweep my-campaign.yaml --out results/mine --resume",
)


def sweep(
    campaign: CampaignName,
    workers: Workers = None,
    cluster: Cluster = None,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default results/sweep-<campaign>."),
    ] = None,
    resume: Resume = False,
    until_width: Annotated[
        Optional[float],  # noqa: UP045
        typer.Option(
            min=0.0001,
            max=1.0,
            metavar="W",
            help="End when the 95 % interval of success of every controller is this narrow, such as 0.02.",
        ),
    ] = None,
    overrides: CampaignOverrides = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show the first cases, the count and an estimate; write nothing.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Fly every case of CAMPAIGN by every controller, and write flights.parquet: a row a flight.

    Exit code 0: all flown, whatever came of them. 2: the input is wrong, nothing is written. 130: Ctrl-C; what was
    finished is kept, and --resume flies the rest.
    """
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.errors import InputError  # noqa: PLC0415
    from uavftc.jobs.campaign.sweep import Sweep, ready  # noqa: PLC0415
    from uavftc.report.rate import Rate  # noqa: PLC0415
    from uavftc.scenario.campaign import find_campaign, load_campaign  # noqa: PLC0415

    made = ready(load_campaign(campaign, overrides or ()))
    if dry_run:
        from uavftc.jobs.campaign.dry_run import lines  # noqa: PLC0415

        for text in lines(made, workers):
            print(text)
        return
    folder = out if out is not None else Path("results") / f"sweep-{made.campaign.name}"
    inputs = (find_campaign(campaign), made.campaign.base_file)
    job = Sweep(made, folder, resume=resume, inputs=inputs, until_width=until_width)
    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    rate = Rate()
    try:
        summary = job.fly(workers=workers, cluster=cluster, progress=None if quiet else rate)
    except (KeyboardInterrupt, OSError, InputError) as error:
        rate.end()
        if job.begun:
            kept = f"{job.kept} of {made.flights} flights are kept in {folder}; --resume flies the rest"
            if isinstance(error, OSError):
                print(f"error: {error.strerror or error}; {kept}", file=sys.stderr)
                raise typer.Exit(UNEXPECTED) from None
            print(kept, file=sys.stderr)
        raise
    rate.end()
    if quiet:
        return
    if job.torn:
        print(f"warning: {job.torn} torn part(s) of the table were flown again", file=sys.stderr)
    from uavftc.report.console import Terminal  # noqa: PLC0415
    from uavftc.report.sweep_text import print_sweep  # noqa: PLC0415

    console = Terminal()
    print_sweep(console, summary)
    console.print(f"results: {folder}; uavftc sweep-report says what came of them", soft_wrap=True)
