"""The commands. Each has a file of its own; here they meet, and errors become exit codes."""

from __future__ import annotations

import sys
from collections.abc import Callable

import typer

from uavftc import __version__
from uavftc.cli.fly import fly
from uavftc.errors import InputError

WRONG_INPUT, LOST, INTERRUPTED, UNEXPECTED = 2, 3, 130, 1
"""Exit codes besides 0: wrong input, vehicle lost, Ctrl-C (the shell's own convention), anything unexpected."""

umbrella = typer.Typer(
    name="uavftc",
    help="Fault-tolerant flight control on JSBSim: does this controller survive that fault?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
umbrella.command("fly")(fly)

single = typer.Typer(
    name="uavftc-fly",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
single.command()(fly)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"uavftc {__version__}")
        raise typer.Exit


@umbrella.callback()
def _umbrella(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
) -> None:
    """Fault-tolerant flight control on JSBSim: does this controller survive that fault?"""


def guarded(command: Callable[[], None]) -> None:
    """Run a command; exit with the code its outcome calls for."""
    try:
        command()
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(WRONG_INPUT)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(UNEXPECTED)


def main() -> None:
    """Entry point of `uavftc`."""
    guarded(umbrella)


def main_fly() -> None:
    """Entry point of `uavftc-fly`."""
    guarded(single)
