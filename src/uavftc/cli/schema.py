"""`uavftc schema scenario|campaign|aircraft`: the JSON Schema of a file, for editors and other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Optional

import typer

SHORT = "JSON Schema of scenarios, campaigns, aircraft, for editors."
EXAMPLES = ("uavftc schema scenario --out scenario.schema.json", "uavftc schema aircraft")


def schema(
    file: Annotated[str, typer.Argument(metavar="[scenario|campaign|aircraft]", help="Of which kind of file.")] = (
        "scenario"
    ),
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="FILE", help="Write it into FILE; left out, it is printed."),
    ] = None,
) -> None:
    """Print the JSON Schema (draft 2020-12) of scenarios, campaigns or companion files of aircraft.

    An editor with it completes keys, shows what they mean, and marks what is wrong (docs/editor.md).

    Exit code 0: printed or written. 2: there is no such kind of file, or FILE cannot be written.
    """
    from uavftc.jobs.schema import write_schema  # noqa: PLC0415

    text = write_schema(file, out)
    print(f"schema: {out}" if out is not None else text, end="\n" if out is not None else "")
