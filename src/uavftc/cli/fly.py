"""`uavftc-fly SCENARIO`, also `uavftc fly`: fly a scenario and write its result folder."""

from __future__ import annotations

import functools
import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Optional

import typer

from uavftc.cli import complete
from uavftc.cli.options import AircraftName, NoPlots, Overrides, PlantName, Quiet, Report, ScenarioName, default_folder
from uavftc.cli.outcome import BROKEN, INTERRUPTED, LOST, UNEXPECTED, missing_lines

if TYPE_CHECKING:
    from uavftc.jobs.fly import Page
    from uavftc.jobs.live.target import Target


SHORT = "Fly a scenario: table, verdict, history, figures."
EXAMPLES = (
    "uavftc fly scenario3",
    "uavftc fly scenario3 --controller pid --set 'faults[1].effectiveness=0.2'",
)


def fly(
    scenario: ScenarioName,
    plant: PlantName = None,
    aircraft: AircraftName = None,
    controller: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(
            help="nndondi-l1, ndi-l1, nndondi-mrac, ndi-mrac; pid, lqi; or a custom one: ./file.py, pkg.module.",
            autocompletion=complete.controller,
        ),
    ] = None,
    overrides: Overrides = None,
    out: Annotated[
        Optional[Path],  # noqa: UP045
        typer.Option(metavar="DIR", help="Result folder; default results/<scenario>-<controller>-<plant>."),
    ] = None,
    no_plots: NoPlots = False,
    quiet: Quiet = False,
    twin: Annotated[
        bool, typer.Option("--twin", help="Fly the same without faults, too, and show what the faults did.")
    ] = False,
    report: Report = False,
    live: Annotated[
        Optional[str],  # noqa: UP045
        typer.Option(
            metavar="flightgear[:HOST[:PORT]]", help="Send it to FlightGear while it flies; default 127.0.0.1:5550."
        ),
    ] = None,
    pace: Annotated[
        Optional[float],  # noqa: UP045
        typer.Option(metavar="X", help="Seconds of flight in a second; 1.0 with --live, else as fast as it can."),
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 4 where a requirement is broken.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json, and nothing else, on stdout.")] = False,
) -> None:
    """Fly SCENARIO and write table, history and figures of the flight.

    Exit code 0: flown to the end. 2: the input is wrong, nothing is written. 3: the vehicle was lost, or the plant's
    own integration does not converge (numerical); the flight up to there is written. 4: with --strict, flown to the
    end with a requirement broken. 130: Ctrl-C, the flight up to there is written. 1: anything else, as a full disk, in
    one line; where there is room for the flight without its figures it is kept.
    """
    from uavftc.scenario.load import controller_name, find_scenario, load_scenario  # noqa: PLC0415 - not needed for a bad option

    loaded = load_scenario(scenario, overrides=overrides or (), plant=plant, aircraft=aircraft, controller=controller)
    name = f"{loaded.name}-{controller_name(loaded)}-{loaded.plant}"
    folder = out if out is not None else default_folder(name, None if aircraft is None else loaded.aircraft)

    shown: tuple[float, Target | None] | None = None
    if live is not None or pace is not None:
        from uavftc.jobs.live.pace import checked_pace  # noqa: PLC0415
        from uavftc.jobs.live.target import target_of  # noqa: PLC0415

        shown = checked_pace(pace), None if live is None else target_of(live)
    page: Page | None = None
    if report:
        from uavftc.jobs.report import page_of_flight  # noqa: PLC0415
        from uavftc.report.page.html import require_extra  # noqa: PLC0415

        require_extra("--report")
        page = page_of_flight
    from uavftc.core.stage import is_compiled  # noqa: PLC0415
    from uavftc.jobs.fly import fly_mission  # noqa: PLC0415
    from uavftc.report.progress import progress  # noqa: PLC0415

    if not quiet and not is_compiled():
        print("first flight: compiling the control laws (about ten seconds, once)", file=sys.stderr, flush=True)
    document, outcome = fly_mission(
        loaded,
        folder,
        figures=not no_plots,
        progress=functools.partial(progress, quiet=quiet),
        inputs=[find_scenario(scenario)],
        twin=twin,
        page=page,
        live=shown,
    )
    if as_json:
        print(json.dumps(document, indent=2, allow_nan=False))
    if not quiet:
        from uavftc.report.console import Terminal  # noqa: PLC0415
        from uavftc.report.table import print_result  # noqa: PLC0415

        print_result(Terminal(stderr=as_json), document, folder, aside=Terminal(stderr=True))
        if shown is not None:
            from uavftc.jobs.live.pace import lateness_text  # noqa: PLC0415

            print(lateness_text(document["timing"]), file=sys.stderr)
        if sys.stderr.isatty():  # for people: a script reads nothing but what is wrong there
            for line in next_steps(document, [scenario, *_given(aircraft, overrides)], folder):
                print(f"next: {line}", file=sys.stderr)
    lacking = missing_lines(document, folder)
    for line in lacking:
        print(line, file=sys.stderr)
    if outcome.interrupted:
        raise typer.Exit(INTERRUPTED)
    if not outcome.completed:
        raise typer.Exit(LOST)
    if lacking:
        raise typer.Exit(UNEXPECTED)
    if strict and document["verdict"]["outcome"] != "survived":
        raise typer.Exit(BROKEN)


def next_steps(document: Mapping[str, Any], scenario: Sequence[str], folder: Path) -> list[str]:
    """Return what the user may want to do after a flight, as commands."""
    verdict = document["verdict"]
    if verdict is None:
        return []
    name = shlex.join(scenario)
    if verdict["outcome"] == "survived":
        page = f"uavftc report {shlex.quote(str(folder))}  (one page, to zoom and play)"
        return [] if (folder / "report.html").exists() else [page]
    if verdict["outcome"] == "numerical":
        return [f"uavftc fly {name} --set simulation.substeps=N  (with smaller plant steps)"]
    return [
        f"uavftc survivable {name}  (could any controller hold it?)",
        f"uavftc fly {name} --twin  (what did each fault do?)",
    ]


def _given(aircraft: str | None, overrides: Sequence[str] | None) -> list[str]:
    """Return the options by which the scenario was changed, and other commands take too."""
    return [*([] if aircraft is None else ["--aircraft", aircraft]), *(f"--set={one}" for one in overrides or ())]
