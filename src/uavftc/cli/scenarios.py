"""`uavftc scenarios`: what is shipped, to fly or to copy."""

from __future__ import annotations

import json
from typing import Annotated

import typer

SHORT = "List the scenarios and campaigns that are shipped."
EXAMPLES = ("uavftc scenarios", "uavftc scenarios --json")


def scenarios(
    as_json: Annotated[bool, typer.Option("--json", help="Print a list of {name, kind, file, description}.")] = False,
) -> None:
    """List the shipped scenarios and campaigns by the names that commands take, each with what it is about."""
    from uavftc.scenario.catalogue import catalogue  # noqa: PLC0415

    listed = catalogue()
    if as_json:
        print(json.dumps([entry._asdict() for entry in listed], indent=2))
        return
    from uavftc.report.catalogue_text import print_catalogue  # noqa: PLC0415
    from uavftc.report.console import Terminal  # noqa: PLC0415

    print_catalogue(Terminal(), listed)
