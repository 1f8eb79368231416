"""`uavftc export`: the history of a flight, or of each of a comparison, as CSV and as a MATLAB file."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from uavftc.errors import InputError
from uavftc.jobs.export.as_csv import write_csv
from uavftc.jobs.export.as_mat import write_mat
from uavftc.results.history import read_history, read_metadata
from uavftc.results.loaded import COMPARISON, FLIGHT, HISTORY, kind_of, read_document
from uavftc.results.manifest import OWN_CHECKSUM, SUMMARY

Part = tuple[str, Path, Mapping[str, Any]]
"""A flight of a folder: what its file is called by, behind the name that the user gave; its history; its summary."""

Write = Callable[[Path, Mapping[str, np.ndarray], Mapping[str, Any], str], None]
"""Writes a file of a history, a summary and the text of a scenario."""

FORMATS: dict[str, Write] = {
    "csv": lambda path, columns, summary, scenario: write_csv(path, columns),
    "mat": write_mat,
}


def export(folder: Path, files: Mapping[str, Path | None], *, force: bool = False) -> list[Path]:
    """Write the flights of a result folder into files, all of them or none, and return these.

    Parameters
    ----------
    folder
        Of a flight or a comparison. Of a comparison each flight has a file of its own, with `-<plant>-<controller>`
        before the ending.
    files
        By format, a key of `FORMATS`; None is not asked for.
    force
        Whether files that are there are replaced.

    Raises
    ------
    InputError
        If the folder is none of these or damaged, no format is asked for, or a file is there or cannot be written.
    OSError
        If there is no room; nothing is written then.
    """
    parts = _parts(folder)
    asked = {form: path for form, path in files.items() if path is not None}
    if not asked:
        remedy = f"add --csv {folder.name or 'flight'}.csv, or --mat {folder.name or 'flight'}.mat, or both"
        raise InputError("export", found="neither --csv nor --mat", expected="a format and its file", remedy=remedy)
    targets = [
        (form, path.with_name(f"{path.stem}{called}{path.suffix}"), history, summary)
        for form, path in asked.items()
        for called, history, summary in parts
    ]
    for form, target, *_ in targets:
        _refuse(f"--{form} {target}", target, force)
    if len({os.path.realpath(target) for _, target, *_ in targets}) < len(targets):
        remedy = "name two files"
        raise InputError("export", found="one file for both formats", expected="a file for each", remedy=remedy)
    token = secrets.token_hex(4)
    made: list[tuple[Path, Path]] = []
    try:
        for form, target, history, summary in targets:
            made.append((target.with_name(f".{target.name}.partial-{token}"), target))
            FORMATS[form](made[-1][0], read_history(history), summary, read_metadata(history).get("scenario", ""))
        for partial, target in made:
            os.replace(partial, target)
    finally:
        for partial, _ in made:
            with suppress(OSError):
                partial.unlink(missing_ok=True)
    return [target for _, target in made]


def _parts(folder: Path) -> list[Part]:
    document = read_document(folder, f"export {folder}")
    kind = kind_of(document)
    if kind == FLIGHT:
        return [("", folder / HISTORY, _without_files(document))]
    if kind == COMPARISON:
        names = [f"{one['plant']}-{one['controller']}" for one in document["combinations"]]
        of_all = {key: value for key, value in _without_files(document).items() if key != "combinations"}
        return [
            (f"-{name}", folder / "histories" / f"{name}.parquet", {**of_all, **one})
            for name, one in zip(names, document["combinations"], strict=True)
        ]
    raise InputError(
        f"export {folder}",
        found="the result of another job",
        expected="the result folder of a flight or of a comparison",
        remedy="name a folder that uavftc-fly or uavftc compare wrote; others keep no histories of this kind",
    )


def _without_files(document: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in document.items() if key not in ("files", OWN_CHECKSUM)}


def _refuse(where: str, target: Path, force: bool) -> None:
    """Refuse a file that is there, or that would stand where no other program's files belong."""
    if target.is_dir() or not target.parent.is_dir():
        found = "a folder" if target.is_dir() else f"{target.parent}, which is no folder"
        raise InputError(where, found=found, expected="a file to write", remedy="name a file in a folder that exists")
    if any((above / SUMMARY).is_file() for above in Path(os.path.realpath(target)).parents):
        raise InputError(
            where,
            found="a file inside a result folder, which would no longer be as uavftc wrote it",
            expected="a file elsewhere",
            remedy=f"name a file next to the folder, such as {target.name}",
        )
    if os.path.lexists(target) and not force:
        raise InputError(
            where, found="a file that is there already", expected="a new file", remedy="name another, or add --force"
        )
    if not os.access(target.parent, os.W_OK | os.X_OK):
        remedy = "name a file elsewhere"
        raise InputError(where, found=f"{target.parent}, which may not be written", expected="a file to write",
                         remedy=remedy)  # fmt: skip
