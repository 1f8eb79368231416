"""The result folder of a flight or of another job: written whole or not at all; no file of the user is ever lost.

The results are written into a hidden sibling, `.<name>.partial-<pid>`, which takes the folder's place by renaming only
once it is complete. An older folder is replaced only if it is ours: a `summary.json` of ours, and no other files than
those it lists, as they were written (`results.manifest`). Old results are removed file by file, by that list, so that
a file which is not ours, or was edited, cannot be removed, whenever it appears.

A kill between the two renames leaves the old folder as `.<name>.old-<pid>`; the next job into the folder puts it
back.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from uavftc.errors import InputError
from uavftc.results import manifest
from uavftc.results.summary import write_json

_open_here: set[Path] = set()  # partial folders of this process, so that no other flight in it takes them for stale


class ResultFolder:
    """A result folder in the making; `path` is where to write while it is open.

    Used as a context manager it opens, and on leaving the block commits, or discards if there was an exception.

    Parameters
    ----------
    target
        The folder to be; a symbolic link is followed.
    """

    def __init__(self, target: Path) -> None:
        self.target = Path(os.path.realpath(target))
        self._shown = str(target)
        self.path = self._sibling("partial", os.getpid())
        self._created: list[Path] = []

    def check(self) -> None:
        """Make sure, before the flight and without writing, that the folder can be written.

        Raises
        ------
        InputError
            If the target is a file, a folder that is not ours or holds a file that the user added or edited, a mount
            point or the working folder, or if it cannot be written there.
        """
        target = self.target
        if os.path.lexists(target):
            if not target.is_dir():
                raise self._error("a file", "a folder, or a name not yet taken", "name another folder with --out")
            if target.samefile(os.getcwd()) or target in Path.cwd().parents or os.path.ismount(target):
                raise self._error(
                    "the working folder, a folder above it, or a mount point",
                    "a folder that can be replaced as a whole",
                    f"name a folder inside it: --out {os.path.join(self._shown, 'NAME')}",
                )
            self._refuse_what_is_not_ours(target)
            self._require_writable(target)
        parent = target.parent
        while not os.path.lexists(parent) and parent != parent.parent:
            parent = parent.parent
        self._require_writable(parent)

    def open(self) -> Path:
        """Check again, create the parents and the hidden folder to write into, and return the latter.

        Raises
        ------
        InputError
            As `check`, or if the folder cannot be created.
        """
        self.check()
        if self.path in _open_here:
            raise RuntimeError(f"two flights of one process write to {self.target}")
        try:
            missing = [p for p in self.target.parents if not p.exists()]
            for parent in reversed(missing):
                parent.mkdir(exist_ok=True)
                self._created.append(parent)
            self._clean_up_after_the_dead()
            self.path.mkdir()
        except OSError as error:
            self._remove_created()
            raise self._error(str(error), "a place that can be written", "name another folder with --out") from error
        _open_here.add(self.path)
        return self.path

    def write_summary(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Write `summary.json`, after all other files, and return what it holds: `document` and the list of files.

        The list is under the key `files`: the path of each file in the folder, with its SHA-256.
        """
        whole = {**document, "files": manifest.checksums(self.path)}
        write_json(self.path / manifest.SUMMARY, whole)
        return whole

    def commit(self) -> None:
        """Put the new folder in place of the old one; a second call does nothing.

        Raises
        ------
        InputError
            If something that is not ours appeared in the old folder meanwhile. The old folder stays as it is.
        """
        if self.path not in _open_here:
            return
        document = manifest.read_summary(self.path)  # what the next job into this folder will see
        if document is None:
            raise RuntimeError("not a result folder: no summary")
        if stray := manifest.foreign(self.path, manifest.names_of(document)):
            raise RuntimeError(f"not a result folder: its summary does not list {stray}")
        old = self._sibling("old", os.getpid())
        self.check()
        if os.path.lexists(self.target):
            self._rename(self.target, old)
        try:
            if old.exists():
                self._refuse_what_is_not_ours(old)  # a file put there between the look and the move
            self._rename(self.path, self.target)
        except BaseException:
            if old.exists() and not os.path.lexists(self.target):
                old.rename(self.target)
            raise
        _open_here.discard(self.path)
        manifest.remove_ours(old)

    def discard(self) -> None:
        """Remove the unfinished folder and the parents created for it; does nothing once committed."""
        if self.path in _open_here:
            shutil.rmtree(self.path, ignore_errors=True)
            _open_here.discard(self.path)
            self._remove_created()

    def __enter__(self) -> ResultFolder:
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.commit()
        finally:
            self.discard()

    def _sibling(self, role: str, pid: int) -> Path:
        return self.target.with_name(f".{self.target.name}.{role}-{pid}") if self.target.name else self.target

    def _rename(self, source: Path, destination: Path) -> None:
        try:
            source.rename(destination)
        except OSError as error:
            raise self._error(
                str(error), "a folder that no other process writes to", "fly again, or name another folder with --out"
            ) from error

    def _refuse_what_is_not_ours(self, folder: Path) -> None:
        document = manifest.read_summary(folder)
        expected = "an empty folder, or one that holds only results of uavftc"
        remedy = "move {} elsewhere, or name another folder with --out"
        if stray := manifest.foreign(folder, manifest.names_of(document)):
            raise self._error(f"{stray}, which uavftc did not write", expected, remedy.format(stray))
        if document is None and any(folder.iterdir()):
            found = "files with the names of results, but no summary.json of uavftc"
            raise self._error(found, expected, remedy.format("the files"))
        if document is not None and (edited := manifest.changed(folder, document)):
            raise self._error(f"{edited}, which was changed after uavftc wrote it", expected, remedy.format(edited))

    def _require_writable(self, folder: Path) -> None:
        if not folder.is_dir():
            raise self._error(f"{folder} is not a folder", "a path of folders", "name another folder with --out")
        if not os.access(folder, os.W_OK | os.X_OK):
            raise self._error(
                f"{folder} may not be written", "a place that may be written", "name another folder with --out"
            )

    def _clean_up_after_the_dead(self) -> None:
        """Remove what killed jobs left of this folder, and put back an old folder caught between two renames."""
        pattern = re.compile(re.escape(f".{self.target.name}.") + r"(partial|old)-(\d+)")
        for sibling in sorted(self.target.parent.iterdir()):
            match = pattern.fullmatch(sibling.name)
            if not match or sibling.is_symlink() or sibling in _open_here or _alive(int(match[2])):
                continue
            if match[1] == "old" and not os.path.lexists(self.target):
                sibling.rename(self.target)
            else:
                manifest.remove_ours(sibling)

    def _remove_created(self) -> None:
        for parent in reversed(self._created):
            with suppress(OSError):  # somebody else uses it by now
                parent.rmdir()
        self._created.clear()

    def _error(self, found: str, expected: str, remedy: str) -> InputError:
        return InputError(f"--out {self._shown}", found=found, expected=expected, remedy=remedy)


def _alive(pid: int) -> bool:
    if pid == os.getpid():  # not in _open_here, so it belonged to a dead process that had our number
        return False
    if os.name == "nt":  # there, signal 0 would interrupt the process
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
