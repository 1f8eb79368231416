"""The commands, one a file, put together."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import typer

from uavftc import __version__
from uavftc.cli.aircraft import aircraft
from uavftc.cli.bench import bench
from uavftc.cli.compare import compare
from uavftc.cli.design import design
from uavftc.cli.export import export
from uavftc.cli.falsify import falsify
from uavftc.cli.fly import fly
from uavftc.cli.margin import margin
from uavftc.cli.outcome import exit_codes
from uavftc.cli.process import run
from uavftc.cli.report import report
from uavftc.cli.reproduce import reproduce
from uavftc.cli.scenarios import scenarios
from uavftc.cli.schema import schema
from uavftc.cli.survivable import survivable
from uavftc.cli.sweep import sweep
from uavftc.cli.sweep_report import sweep_report

COMMANDS = (
    fly, scenarios, compare, report, export, margin, survivable, sweep, sweep_report, falsify,
    design, aircraft, schema, reproduce, bench,
)  # fmt: skip
"""The commands of `uavftc`, in the order in which its help lists them."""

_SETTINGS: dict[str, Any] = {
    "pretty_exceptions_enable": False,
    "rich_markup_mode": None,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


def umbrella_of(commands: Sequence[Callable[..., None]]) -> typer.Typer:
    """Return the command `uavftc` with these commands below it, each named as its function."""
    umbrella = typer.Typer(name="uavftc", no_args_is_help=True, callback=_umbrella, **_SETTINGS)
    for command in commands:
        umbrella.command(command.__name__.replace("_", "-"), **_help_of(command))(exit_codes(command))
    return umbrella


def _help_of(command: Callable[..., None], script: str = "uavftc fly") -> dict[str, Any]:
    """Return what a command's file says for its help: the line in the list of commands, and its examples."""
    module = sys.modules.get(command.__module__)
    found: dict[str, Any] = {}
    if (short := getattr(module, "SHORT", None)) is not None:
        found["short_help"] = short
    if examples := getattr(module, "EXAMPLES", ()):
        lines = (f"  {example.replace('uavftc fly', script)}" for example in examples)
        found["epilog"] = "\n".join(["\b", "Examples:", *lines])
    return found


def _version(asked: bool) -> None:
    if asked:
        print(f"uavftc {__version__}")
        raise typer.Exit


def _umbrella(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    """Fault-tolerant flight control on JSBSim: does this controller survive that fault?"""


umbrella = umbrella_of(COMMANDS)
single = typer.Typer(name="uavftc-fly", **_SETTINGS)
single.command(**_help_of(fly, "uavftc-fly"))(exit_codes(fly))


def main() -> NoReturn:
    """Entry point of `uavftc`."""
    run(umbrella)


def main_fly() -> NoReturn:
    """Entry point of `uavftc-fly`."""
    run(single)
