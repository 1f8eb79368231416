"""Which files of a result folder are ours: those that its `summary.json` lists, each with its checksum.

A folder is ours if its `summary.json` is, and every file in it is listed there under `files` and still has the content
that was written; of the summary itself `summary_sha256` tells that, for all but its wall-clock figures. Folders of the
first versions list nothing: there, and in what a killed job left unfinished, a file is ours by its name (`FLIGHT`,
`COMPARISON`, `REPRODUCTION`). These names are frozen; a new job adds none.
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
OWN_CHECKSUM = "summary_sha256"
MAX_BYTES = 64_000_000  # of a summary.json; a longer one is not ours
_HASHED_BYTES = 1 << 20  # read at a time

_PLANTS = ("jsbsim", "analytic")
FLIGHT = frozenset(
    [SUMMARY, "scenario.yaml", "history.parquet", "report.html"]
    + [f"figures/{name}.png" for name in ("tracking", "control", "estimates", "air", "custom", "overview")]
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


def text_of(document: Mapping[str, Any]) -> str:
    """Return the text of a `summary.json`.

    Raises
    ------
    ValueError
        If there is a NaN or an infinity in it.
    """
    text = json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    return text.encode(errors="backslashreplace").decode()  # a path that is no text: JSON's own spelling of it


def own_checksum(document: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a summary without this checksum and its wall-clock figures, which no two runs share."""
    return hashlib.sha256(json.dumps(_lasting(document), sort_keys=True).encode()).hexdigest()


def _lasting(value: Any) -> Any:
    if isinstance(value, Mapping):
        own = (OWN_CHECKSUM, "timing")
        return {k: _lasting(v) for k, v in value.items() if k not in own and not k.startswith("wall_")}
    return [_lasting(item) for item in value] if isinstance(value, (list, tuple)) else value


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
    """Return the path inside `folder` of a file of ours whose content is not the one that was written, or None."""
    listed = _listed(document)
    for path in _walk(folder):
        if path in listed and not _is_unchanged(folder / path, listed[path]):
            return path
    return SUMMARY if _summary_changed(folder, document) else None


def remove_ours(folder: Path, *, unfinished: bool = False) -> None:
    """Remove the files of a folder that are ours and unchanged, then the folders, which stay if anything else is in.

    What cannot be removed stays too, and the summary with it, which says what the rest is; a link in place of the
    folder is not followed. Of an `unfinished` folder, which has no summary yet, files are ours by their names.
    """
    if folder.is_symlink():
        return
    document = read_summary(folder)
    by_name = unfinished and document is None
    names, listed = names_of(document) if by_name or document else frozenset(), _listed(document or {})

    def history(path: str) -> bool:  # these have too many names to be in the frozen lists
        return by_name and path.startswith("histories/") and path.endswith(".parquet")

    for path in sorted(set(_walk(folder)) - {SUMMARY}, reverse=True):  # what is in a folder before the folder
        inside = folder / path
        with suppress(OSError):
            if _is_folder(inside):
                inside.rmdir()
            elif _is_unchanged(inside, listed[path]) if path in listed else path in names or history(path):
                inside.unlink()
    with suppress(OSError):
        if set(_walk(folder)) == {SUMMARY} and (by_name or (document and not _summary_changed(folder, document))):
            (folder / SUMMARY).unlink()
        folder.rmdir()


def _summary_changed(folder: Path, document: Mapping[str, Any]) -> bool:
    """Return whether somebody edited the `summary.json` that `document` was read from; earlier versions cannot tell."""
    if OWN_CHECKSUM not in document:
        return False
    try:
        with _regular(folder / SUMMARY) as stream:
            text = stream.read(MAX_BYTES + 1)
        return text != text_of(document).encode() or document[OWN_CHECKSUM] != own_checksum(document)
    except (OSError, ValueError, RecursionError):
        return True


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
