"""The commands. Each has a file of its own; here they meet."""

from __future__ import annotations

from typing import Any, NoReturn

import typer

from uavftc import __version__
from uavftc.cli.aircraft import aircraft
from uavftc.cli.bench import bench
from uavftc.cli.compare import compare
from uavftc.cli.design import design
from uavftc.cli.fly import fly
from uavftc.cli.outcome import exit_codes
from uavftc.cli.process import run
from uavftc.cli.reproduce import reproduce

COMMANDS = (fly, design, aircraft, reproduce, compare, bench)
"""The commands of `uavftc`, in the order in which its help lists them."""

_SETTINGS: dict[str, Any] = {
    "add_completion": False,
    "pretty_exceptions_enable": False,
    "rich_markup_mode": None,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}

umbrella = typer.Typer(name="uavftc", no_args_is_help=True, **_SETTINGS)
for _command in COMMANDS:
    umbrella.command(_command.__name__)(exit_codes(_command))

single = typer.Typer(name="uavftc-fly", **_SETTINGS)
single.command()(exit_codes(fly))


def _version(asked: bool) -> None:
    if asked:
        print(f"uavftc {__version__}")
        raise typer.Exit


@umbrella.callback()
def _umbrella(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    """Fault-tolerant flight control on JSBSim: does this controller survive that fault?"""


def main() -> NoReturn:
    """Entry point of `uavftc`."""
    run(umbrella)


def main_fly() -> NoReturn:
    """Entry point of `uavftc-fly`."""
    run(single)
