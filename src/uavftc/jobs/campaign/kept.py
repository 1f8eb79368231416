"""The folder of many flights: filled while they are flown, it can be left at any moment and gone on with.

`campaign.json` is there first and says what is flown into it; `summary.json` is there last, and makes it complete.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from uavftc.errors import InputError
from uavftc.jobs.campaign.identity import FILE, differences
from uavftc.jobs.campaign.table import whole
from uavftc.results import manifest
from uavftc.results.folder import ResultFolder
from uavftc.results.lock import Lock, NotOursError, TakenError

_SHOWN = 8  # differences shown


class Kept:
    """A folder that one job flies into; as a context manager it is that job's alone until it is left.

    Parameters
    ----------
    out
        The folder; an older result in it is replaced if it is ours and complete.
    resume
        Go on with what is there.
    inputs
        Files that the flights are made from; a folder that holds one of them is not replaced.
    """

    def __init__(self, out: Path, *, resume: bool = False, inputs: Sequence[Path] = ()) -> None:
        self.path = Path(os.path.realpath(out))
        self.begun = False
        """Whether something was written into it."""
        self._shown, self._resume, self._inputs = str(out), resume, inputs
        self._lock = Lock(self.path)

    def __enter__(self) -> Kept:
        """Take it, without writing into it.

        Raises
        ------
        InputError
            If another job has it.
        """
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._lock.take()
        except (TakenError, NotOursError):
            raise self._error(
                "another uavftc that is writing to it just now",
                "one job at a time",
                "wait until it has ended, or name another folder with --out",
            ) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._lock.release()

    def look(self, document: Mapping[str, Any]) -> None:
        """Refuse a folder that is not ours, one that holds an unfinished campaign, and one that holds another's.

        Raises
        ------
        InputError
            If it is one of these; nothing is changed then.
        """
        there = self._there()
        if self._resume and there is None:
            remedy = "leave --resume out, or name the folder of the campaign with --out"
            raise self._error(f"no {FILE} in it", "a folder in which this campaign was begun", remedy)
        if self._resume:
            found = list(differences(there, document))
            if found:
                more = [f"and {len(found) - _SHOWN} more"] if len(found) > _SHOWN else []
                raise self._error(
                    f"another campaign: {'; '.join([*found[:_SHOWN], *more])}",
                    "the same file, base, aircraft, code and versions, so that all rows are of one campaign",
                    "put back what differs, or name another folder with --out and begin anew",
                )
        elif there is not None and manifest.read_summary(self.path) is None:
            remedy = "go on with it (--resume), name another folder with --out, or remove it"
            raise self._error("an unfinished campaign", "a new folder", remedy)
        else:
            ResultFolder(self.path, self._inputs).check()

    def finished(self, document: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the summary of what is to be gone on with and is complete; None where something is missing."""
        return manifest.read_summary(self.path) if self._resume and self._there() == document else None

    def begin(self, document: Mapping[str, Any]) -> None:
        """Remove an older result, and say what is flown from here on."""
        if not self._resume:
            manifest.remove_ours(self.path)
        self.path.mkdir(parents=True, exist_ok=True)
        self._write(FILE, document)
        self.begun = True

    def complete(self, summary: Mapping[str, Any], files: Mapping[str, str]) -> dict[str, Any]:
        """Write the summary, with the checksums of the files that stay, and return what it holds."""
        document: dict[str, Any] = {**summary, "files": dict(files)}
        document[manifest.OWN_CHECKSUM] = manifest.own_checksum(document)
        self._write(manifest.SUMMARY, document)
        return document

    def _write(self, name: str, document: Mapping[str, Any]) -> None:
        with whole(self.path / name) as stream:
            stream.write(manifest.text_of(document).encode())

    def _there(self) -> dict[str, Any] | None:
        try:
            document = json.loads((self.path / FILE).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return document if isinstance(document, dict) else None

    def _error(self, found: str, expected: str, remedy: str) -> InputError:
        return InputError(f"--out {self._shown}", found=found, expected=expected, remedy=remedy)
