"""Which files of a result folder are ours: those that its `summary.json` lists, each with its checksum.

A folder is ours if its `summary.json` is, and every file in it is listed there under `files` and still has the content
that was written. Folders of the first versions list nothing: there, and in what a killed job left unfinished, a file
is ours by its name (`FLIGHT`, `COMPARISON`, `REPRODUCTION`). These names are frozen; a new job adds none.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any

SUMMARY = "summary.json"
MAX_BYTES = 64_000_000  # of a summary.json; a longer one is not ours
_HASHED_BYTES = 1 << 20  # read at a time

_PLANTS = ("jsbsim", "analytic")
FLIGHT = frozenset(
    [SUMMARY, "scenario.yaml", "history.parquet", "report.html"]
    + [f"figures/{name}.png" for name in ("tracking", "control", "estimates", "air")]
)
COMPARISON = frozenset(
    [SUMMARY, "scenario.yaml", "comparison.md", "comparison.csv"]
    + [f"figures/{name}.png" for name in ("tracking", "commands", "difference")]
)
REPRODUCTION = frozenset(
    [SUMMARY, "reproduction.md", "reproduce.json", "tables.csv", "improvements.csv"]
    + [f"figures/{plant}-figure-{n:02d}.{kind}" for plant in _PLANTS for n in range(2, 12) for kind in ("png", "pdf")]
)


def checksums(folder: Path) -> dict[str, str]:
    """Return every file in a folder but its `summary.json`, path inside it to SHA-256, in order of the paths."""
    return {name: checksum(folder / name) for name in sorted(set(_files(folder)) - {SUMMARY})}


def checksum(file: Path) -> str:
    """Return the SHA-256 of a regular file, in hexadecimal digits.

    Raises
    ------
    OSError
        If it cannot be read, or is a link, a pipe or the like.
    """
    digest = hashlib.sha256()
    with _regular(file) as stream:
        while piece := stream.read(_HASHED_BYTES):
            digest.update(piece)
    return digest.hexdigest()


def read_summary(folder: Path) -> dict[str, Any] | None:
    """Return the `summary.json` of a folder if uavftc wrote it; None if it is another's, or cannot be read at all."""
    try:
        with _regular(folder / SUMMARY) as stream:
            text = stream.read(MAX_BYTES + 1)
        document = json.loads(text) if len(text) <= MAX_BYTES else None
    except (OSError, ValueError, RecursionError, MemoryError):
        return None
    origin = document.get("provenance") if isinstance(document, dict) else None
    return document if isinstance(origin, dict) and "uavftc" in origin else None


def names_of(document: Mapping[str, Any] | None) -> frozenset[str]:
    """Return the path of every file that may be in the folder of this `summary.json`, itself included.

    Parameters
    ----------
    document
        From `read_summary`; None of a folder that is unfinished or not ours, where every name of ours counts.
    """
    if document is None:
        return FLIGHT | COMPARISON | REPRODUCTION
    if "files" in document:
        return frozenset({SUMMARY, *_listed(document)})
    if "combinations" in document:
        return COMPARISON | _histories(document["combinations"])
    return REPRODUCTION if "claims" in document else FLIGHT


def foreign(folder: Path, names: frozenset[str]) -> str | None:
    """Return the path inside `folder` of something that is not one of these files or a folder of one, or None.

    A link, a pipe and the like never count as ours; nothing is followed out of the folder.
    """
    folders = {str(parent) for name in names for parent in PurePosixPath(name).parents}
    for path in _walk(folder):
        if path not in (folders if _is_folder(folder / path) else names if _is_file(folder / path) else ()):
            return path
    return None


def changed(folder: Path, document: Mapping[str, Any]) -> str | None:
    """Return the path inside `folder` of a listed file whose content is not the one that was written, or None."""
    listed = _listed(document)
    for path in _walk(folder):
        if path in listed and not _is_unchanged(folder / path, listed[path]):
            return path
    return None


def remove_ours(folder: Path) -> None:
    """Remove the files of a folder that are ours and unchanged, then the folders, which stay if anything else is in."""
    document = read_summary(folder)
    names, listed = names_of(document), _listed(document or {})

    def unfinished(path: str) -> bool:  # histories have too many names to be in the frozen lists
        return document is None and path.startswith("histories/") and path.endswith(".parquet")

    for path in sorted(set(_walk(folder)) - {SUMMARY}, reverse=True):  # what is in a folder before the folder
        inside = folder / path
        with suppress(OSError):
            if _is_folder(inside):
                inside.rmdir()
            elif _is_unchanged(inside, listed[path]) if path in listed else path in names or unfinished(path):
                inside.unlink()
    with suppress(OSError):
        (folder / SUMMARY).unlink(missing_ok=True)  # last: without it, the next job would not recognise the others
        folder.rmdir()


def _listed(document: Mapping[str, Any]) -> Mapping[str, str]:
    files = document.get("files")
    return files if isinstance(files, dict) else {}


def _histories(flights: Any) -> frozenset[str]:
    """Return the histories of a comparison of an earlier version, which had a file for each flight."""
    if not isinstance(flights, list):
        return frozenset()
    pairs = [(f.get("plant"), f.get("controller")) for f in flights if isinstance(f, dict)]
    return frozenset(f"histories/{plant}-{controller}.parquet" for plant, controller in pairs)


def _files(folder: Path) -> Iterator[str]:
    return (path for path in _walk(folder) if not _is_folder(folder / path))


def _walk(folder: Path) -> Iterator[str]:
    """Yield everything beneath, links not followed, as paths with slashes inside the folder; names in order."""
    for root, folders, files in os.walk(folder):
        inside = Path(root).relative_to(folder)
        for name in sorted([*folders, *files]):
            yield (inside / name).as_posix()


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _is_file(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()


def _is_unchanged(file: Path, written: object) -> bool:
    try:
        return checksum(file) == written
    except OSError:
        return False


def _regular(file: Path):  # type: ignore[no-untyped-def]  # a binary stream, whose type has no public name
    """Open a regular file for reading; a link, a pipe or a device is an OSError, and nothing waits for a pipe."""
    descriptor = os.open(file, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0))
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(f"{file} is not a file")
    return os.fdopen(descriptor, "rb")
