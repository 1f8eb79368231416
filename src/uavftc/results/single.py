"""A single file as output: written whole or not at all, and no file of the user's is replaced unless it is ours.

A figure is ours by its metadata, which names uavftc as what made it.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable
from contextlib import suppress
from importlib import metadata
from pathlib import Path

from uavftc.errors import InputError
from uavftc.results.hold import Hold

_LOOKED_AT = 1 << 26  # bytes of a file in which the metadata is looked for
_OURS = {
    ".png": (b"\x89PNG", b"Software\0uavftc "),
    ".svg": (b"<?xml", b"<dc:title>uavftc "),
    ".pdf": (b"%PDF", b"/Creator (uavftc "),
}
"""By the ending of a figure's name: how such a file begins, and what ours have in them."""

KINDS = tuple(_OURS)


def figure_metadata(kind: str) -> dict[str, str | None]:
    """Return the metadata, as matplotlib takes it, by which such a figure is known as ours; without a date."""
    program = f"uavftc {metadata.version('uavftc')}"
    known: dict[str, dict[str, str | None]] = {
        ".png": {"Software": program},
        ".svg": {"Creator": program, "Date": None},
        ".pdf": {"Creator": program, "CreationDate": None},
    }
    return known[kind]


def check_figure(option: str, file: Path, *, force: bool) -> None:
    """Make sure, before anything is computed, that a figure can be written and replaces nothing of the user's.

    Parameters
    ----------
    option
        The option that names the file.
    file
        Where to.
    force
        Whether a file that is not ours may be replaced.

    Raises
    ------
    InputError
        If it cannot, or would.
    """
    if file.suffix not in KINDS:
        found, remedy = file.suffix or "no ending", f"write {file.stem}.png"
    elif not file.parent.is_dir():
        found, remedy = f"no folder {file.parent}", "make the folder first"
    elif file.is_dir():
        found, remedy = "a folder", "name a file"
    elif (refused := cannot_write(file)) is not None:
        found, remedy = refused, "name a file in another folder"
    elif os.path.lexists(file) and not force and not _is_ours(file):
        found, remedy = "a file that uavftc did not write", f"name another file, or replace it: {option} {file} --force"
    else:
        return
    raise InputError(
        f"{option} {file}",
        found=found,
        expected=f"a file ending in {', '.join(KINDS)}, in a folder that can be written, new or made by uavftc",
        remedy=remedy,
    )


def write_single(file: Path, draw: Callable[[Path], object]) -> None:
    """Let `draw` write a file, and put it in its place once it is complete.

    Raises
    ------
    OSError
        If it cannot be written; what was there before stays then.
    """
    partial = _beside(file)
    try:
        draw(partial)
        partial.replace(file)
    finally:
        with Hold(), suppress(OSError):
            partial.unlink()


def _beside(file: Path) -> Path:
    return file.with_name(f".uavftc-{secrets.token_hex(8)}{file.suffix}")


def cannot_write(file: Path) -> str | None:
    """Return why nothing can be written next to a file: tried, for permissions do not say it of every user."""
    probe = _beside(file)
    try:
        os.close(os.open(probe, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))
        probe.unlink()
    except OSError as error:
        return f"{file.parent} cannot be written: {error.strerror}"
    return None


def _is_ours(file: Path) -> bool:
    if file.is_symlink() or not file.is_file():
        return False
    begins, has = _OURS[file.suffix]
    try:
        with file.open("rb") as stream:
            content = stream.read(_LOOKED_AT)
    except OSError:
        return False
    return content.startswith(begins) and has in content
