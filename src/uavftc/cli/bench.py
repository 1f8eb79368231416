"""`uavftc bench`: how fast this is, each figure next to what it is built on."""

from __future__ import annotations

import difflib
import json
import sys
from typing import Annotated, Optional

import typer

from uavftc.errors import InputError

SHORT = "How fast it is, compared with bare JSBSim."
EXAMPLES = (
    "uavftc bench --only controller_step_us",
    "uavftc bench --json > bench.json",
)


def bench(
    as_json: Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")] = False,
    rounds: Annotated[int, typer.Option(metavar="N", help="Rounds of each measurement.")] = 7,
    only: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(metavar="NAME,...", help="Measure only these figures (closed_loop_over_bare_jsbsim, ...)."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Show no progress.")] = False,
) -> None:
    """Measure the closed loop next to bare JSBSim, its parts, processes, growth and peers (some minutes).

    Medians and spread of several rounds; what is a ratio was measured alternately. docs/performance.md says what each
    figure is. For figures worth keeping the machine must do nothing else.
    """
    if rounds < 1:
        raise InputError(
            f"--rounds {rounds}", found=f"{rounds}", expected="at least 1", remedy="leave the option out for 7 rounds"
        )
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.bench.catalogue import CATALOGUE, run  # noqa: PLC0415 - what a bad option does not need is not imported
    from uavftc.report.progress import stages  # noqa: PLC0415

    names = list(CATALOGUE) if only is None else [name.strip() for name in only.split(",")]
    for name in names:
        _check(name, list(CATALOGUE))
    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    with stages(quiet=quiet) as advance:
        document = run(names, rounds, advance)
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
        return
    from uavftc.jobs.bench.table import print_figures  # noqa: PLC0415
    from uavftc.report.console import Terminal  # noqa: PLC0415

    print_figures(Terminal(), document)


def _check(name: str, known: list[str]) -> None:
    if name in known:
        return
    near = difflib.get_close_matches(name, known, 1)
    raise InputError(
        f"--only {name}",
        found=f"'{name}'",
        expected=f"names of figures, separated by commas: {', '.join(known)}",
        remedy=f"did you mean {near[0]}?" if near else "leave the option out to measure all",
    )
