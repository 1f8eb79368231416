"""What a command's outcome is for the shell: the exit codes, and errors shown without a traceback."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ParamSpec

import typer

from uavftc.cli import interrupt
from uavftc.cli.early import INTERRUPTED
from uavftc.errors import InputError

UNEXPECTED = 1
WRONG_INPUT = 2
LOST = 3
BROKEN = 4

P = ParamSpec("P")


def exit_codes(command: Callable[P, None]) -> Callable[P, None]:
    """Turn wrong input, Ctrl-C and what the system refuses, from wherever a command raises it, into line and code.

    Anything else that is raised is a bug of ours: it leaves a traceback and exit code 1.
    """

    @functools.wraps(command)
    def guarded(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with interrupt.raising():
                _require_working_folder()
                command(*args, **kwargs)
            if sys.stdout is not None:
                sys.stdout.flush()
        except InputError as error:
            _say(f"error: {error}")
            raise typer.Exit(WRONG_INPUT) from None
        except KeyboardInterrupt:
            _say("interrupted")
            raise typer.Exit(INTERRUPTED) from None
        except typer.Exit:
            raise
        except BrokenPipeError:  # the reader of our output has gone, where it is not `streams` that sees to it
            raise typer.Exit(0) from None
        except Exception as error:
            if interrupt.was_seen():  # a library made something else of it
                _say("interrupted")
                raise typer.Exit(INTERRUPTED) from None
            if not isinstance(error, (OSError, MemoryError)):
                raise
            _say(f"error: {_in_one_line(error)}; nothing was written")
            raise typer.Exit(UNEXPECTED) from None

    return guarded


def missing_lines(document: Mapping[str, Any], folder: Path) -> list[str]:
    """Return a line for each of figures and page that a result folder has no room for, by its `summary.json`."""
    lacking = {"figures_missing": "figures", "report_missing": "report.html"}.items()
    return [f"error: {folder} has no {what}: {document[key]}" for key, what in lacking if key in document]


def _say(text: str) -> None:
    print(text, file=sys.stderr)


def _in_one_line(error: OSError | MemoryError) -> str:
    if isinstance(error, MemoryError):
        return "not enough memory"
    text = os.strerror(error.errno) if error.errno else error.strerror or str(error) or type(error).__name__
    return " ".join((f"{text}: {error.filename}" if error.filename else text).split())


def _require_working_folder() -> None:
    try:
        os.getcwd()
    except OSError:
        raise InputError(
            "the working folder",
            found="it was deleted",
            expected="a folder that is there",
            remedy="go to another one (cd), and try again",
        ) from None
