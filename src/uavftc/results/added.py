"""A file added to a result folder: its summary lists it, and a kill at any moment leaves a folder that is ours.

The summary that lists the new file takes the place of the old one before the file does: a file that is listed and not
there is no fault of a folder, one that is there and not listed, or with another content, is.
"""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

from uavftc.errors import InputError
from uavftc.results import manifest
from uavftc.results.hold import Hold
from uavftc.results.lock import Lock, NotOursError, TakenError
from uavftc.results.summary import write_json


def own_summary(folder: Path, where: str) -> dict[str, Any]:
    """Return the `summary.json` of a result folder that is complete and as uavftc wrote it.

    Parameters
    ----------
    folder
        The folder.
    where
        What names it in messages.

    Raises
    ------
    InputError
        If it is no such folder, or a file in it was added or edited.
    """
    remedy = "name the folder of a flight, a comparison, a reproduction or a campaign"
    if not folder.is_dir():
        found = "a file" if folder.exists() else "no such folder"
        raise InputError(where, found=found, expected="a result folder of uavftc", remedy=remedy)
    document = manifest.read_summary(folder)
    if document is None:
        found, expected = "no summary.json of uavftc in it", "a result folder that is complete"
        if (folder / "campaign.json").is_file():
            found, remedy = "an unfinished campaign", "fly the rest of it: uavftc sweep ... --resume"
        raise InputError(where, found=found, expected=expected, remedy=remedy)
    if stray := manifest.foreign(folder, manifest.names_of(document)):
        raise InputError(
            where,
            found=f"{stray}, which uavftc did not write",
            expected="a result folder with nothing else in it",
            remedy=f"move {stray} elsewhere",
        )
    if edited := manifest.changed(folder, document):
        raise InputError(
            where,
            found=f"{edited}, which was changed after uavftc wrote it",
            expected="a result folder as it was written",
            remedy="put the file back, or fly again",
        )
    return document


def add_file(folder: Path, name: str, text: str, where: str) -> None:
    """Write a file into a result folder, in place of one of ours of this name, and list it in the summary.

    Parameters
    ----------
    folder
        A folder that `own_summary` takes.
    name
        Of the file in it.
    text
        What it holds.
    where
        What names the folder in messages.

    Raises
    ------
    InputError
        If another job writes to the folder, or it is no longer as uavftc wrote it, or cannot be written.
    OSError
        If there is no room; the folder is as it was then.
    """
    folder = Path(os.path.realpath(folder))
    lock = Lock(folder)
    partial = folder.with_name(f".{folder.name}.partial-{lock.token}")
    try:
        lock.take()
    except (TakenError, NotOursError):
        raise InputError(
            where,
            found="another uavftc that is writing to it just now",
            expected="one job at a time",
            remedy="wait until it has ended",
        ) from None
    except PermissionError as error:
        raise InputError(
            where,
            found=f"{folder.parent} cannot be written: {error.strerror}",
            expected="a folder that can be written",
            remedy="copy the results to one",
        ) from None
    try:
        document = own_summary(folder, where)
        partial.mkdir()
        (partial / name).write_text(text, encoding="utf-8", newline="\n")
        listed = {**manifest.checksums(folder), name: manifest.checksum(partial / name)}
        document["files"] = {path: listed[path] for path in sorted(listed)}
        document.pop(manifest.OWN_CHECKSUM, None)
        document[manifest.OWN_CHECKSUM] = manifest.own_checksum(document)
        write_json(partial / manifest.SUMMARY, document)
        with Hold():
            with suppress(FileNotFoundError):
                (folder / name).unlink()
            (partial / manifest.SUMMARY).replace(folder / manifest.SUMMARY)
            (partial / name).replace(folder / name)
    finally:
        with Hold():
            shutil.rmtree(partial, ignore_errors=True)
            lock.release()
