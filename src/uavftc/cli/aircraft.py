"""`uavftc aircraft`: the aircraft at hand, and whether the controller can fly each."""

from __future__ import annotations

import json
import shutil
import sys
from typing import Annotated

import typer

SHORT = "List the aircraft, and which of them can be flown."
EXAMPLES = (
    "uavftc aircraft",
    "uavftc aircraft --json > aircraft.json",
)


def aircraft(
    *,
    as_json: Annotated[bool, typer.Option("--json", help="One JSON list on standard output.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Measure nothing: show what is known already.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show no progress.")] = False,
) -> None:
    """List the aircraft at hand, ours and JSBSim's: mass, span, engines, trim, and whether the controller flies them.

    The figure in brackets is the authority of the weakest axis for steps of 5 deg: deflection available over deflection
    needed. The first list takes some minutes, because each aircraft is trimmed and linearised; later ones take none.
    Ctrl-C (130) keeps what was measured.
    """
    from uavftc.jobs.design import fleet  # noqa: PLC0415 - what --help does not need is not imported
    from uavftc.report import fleet_table  # noqa: PLC0415
    from uavftc.report.progress import stages  # noqa: PLC0415

    names = fleet.names()
    missing = 0 if quick else sum(fleet.cached(name) is None for name in names)
    if missing > 2 and not quiet:
        print(f"measuring {missing} aircraft (some minutes, once)", file=sys.stderr, flush=True)
    with stages(quiet=quiet) as show:
        rows = fleet.fleet(names, quick=quick, progress=lambda done: show(done, len(names), "measuring aircraft"))
    if as_json:
        print(json.dumps(rows, indent=2, allow_nan=False))
        return
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 0
    print("\n".join(fleet_table.lines(rows, max(width, fleet_table.WIDTH))))
