"""Arguments and options that several commands share: one spelling and one help text each."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Optional

import typer

from uavftc.cli import complete

ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A scenario file, or the name of a shipped one (scenario3).",
        autocompletion=complete.scenario,
    ),
]
PlantName = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option("--plant", help="jsbsim or analytic.", autocompletion=complete.plant),
]
AircraftName = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option(
        "--aircraft",
        help="Name of a shipped aircraft, a folder, or jsbsim:NAME.",
        autocompletion=complete.aircraft,
    ),
]
Controllers = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option(
        "--controllers",
        metavar="LIST",
        help="Controllers, separated by commas (nndondi-l1,pid,./my.py); default: the scenario's.",
        autocompletion=complete.controllers,
    ),
]
Overrides = Annotated[
    Optional[list[str]],  # noqa: UP045
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Change one value, such as faults[0].effectiveness=0.2.",
        autocompletion=complete.key,
    ),
]
CampaignName = Annotated[
    str,
    typer.Argument(
        metavar="CAMPAIGN",
        help="A campaign file, or the name of a shipped one (uavftc scenarios).",
        autocompletion=complete.campaign,
    ),
]
CampaignOverrides = Annotated[
    Optional[list[str]],  # noqa: UP045
    typer.Option("--set", metavar="KEY=VALUE", help="Change one value of the campaign, such as cases=60."),
]
Workers = Annotated[
    Optional[int],  # noqa: UP045
    typer.Option(
        "--workers", min=1, metavar="N", help="Processes; default: as many as cores. Results do not depend on it."
    ),
]
Cluster = Annotated[
    Optional[str],  # noqa: UP045
    typer.Option(
        "--cluster", metavar="ADDRESS", help="Fly on a Dask cluster instead, tcp://host:8786 (extra `campaign`)."
    ),
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with what is in DIR: fly only what is missing.")]
NoPlots = Annotated[bool, typer.Option("--no-plots", help="Draw no figures.")]
Report = Annotated[
    bool, typer.Option("--report", help="Write report.html too: one page to look at, with the extra 'report'.")
]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]


def default_folder(name: str, aircraft: str | None) -> Path:
    """Return results/<name>, with the aircraft's name after it where it was an option."""
    return Path("results") / (name if aircraft is None else f"{name}-{Path(aircraft).name}".replace(":", "-"))
