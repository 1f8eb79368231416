"""A command of one file: `uavftc hello NAME`."""

from __future__ import annotations

from typing import Annotated

import typer

from uavftc.errors import InputError


def hello(name: Annotated[str, typer.Argument(help="Whom to greet.")]) -> None:
    """Greet NAME."""
    if not name.isalpha():
        raise InputError("NAME", found=repr(name), expected="letters", remedy="leave out everything else")
    print(f"hello {name}")
