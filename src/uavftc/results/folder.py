"""The result folder of a flight or of another job: written whole or not at all, and nothing of the user's is lost.

The results are written into a hidden sibling, `.<name>.partial-<token>`, which takes the folder's place once it is
complete. An older folder is replaced only if it is ours: a `summary.json` of ours, and no other files than those it
lists, as they were written (`results.manifest`). Old results are removed file by file, by that list, so that a file
which is not ours, or was edited, cannot be removed, whenever it appears.

One job at a time writes to a folder (`results.lock`). Old and new folder change places in one step
(`results.exchange`); where the system cannot do that, by two renames, the old folder being `.<name>.old-<token>` for a
moment, and what a kill between the two leaves there the next job puts back. Signals wait until that is done
(`results.hold`). What could not be removed is said on the logger `uavftc`: on standard error, unless set otherwise.
"""

from __future__ import annotations

import errno
import logging
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from uavftc.errors import InputError
from uavftc.results import manifest
from uavftc.results.exchange import exchange
from uavftc.results.hold import Hold
from uavftc.results.lock import Lock, NotOursError, TakenError
from uavftc.results.summary import write_json

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""No room: the disk's, the user's share of it, or the size that a file may have (`ulimit -f`)."""

_log = logging.getLogger("uavftc")


class ResultFolder:
    """A result folder in the making; `path` is where to write while it is open.

    Used as a context manager it opens, and on leaving the block commits, or discards if there was an exception.

    Parameters
    ----------
    target
        The folder to be; a symbolic link is followed.
    inputs
        Files that the results are made from; a folder that holds one of them is not replaced.
    """

    def __init__(self, target: Path, inputs: Sequence[Path] = ()) -> None:
        self.target = Path(os.path.realpath(target))
        self._shown = str(target)
        self._inputs = [Path(os.path.realpath(file)) for file in inputs]
        self._lock = Lock(self.target)
        self.path = self._sibling("partial", self._lock.token)
        self._old = self._sibling("old", self._lock.token)
        self._made: os.stat_result | None = None  # of the folder made here, wherever it stands
        self._created: list[Path] = []

    def check(self) -> None:
        """Make sure, before the flight and without writing, that the folder can be written.

        Raises
        ------
        InputError
            If the target is a file, a folder that is not ours holds a file that the user added or edited, or one of the
            inputs, a mount point or the working folder, or if it cannot be written there.
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
            for file in self._inputs:
                if target in file.parents:
                    raise self._error(
                        f"{file.relative_to(target)}, which is to be flown, inside it",
                        "a folder that holds nothing that is still needed",
                        "name another folder with --out, or copy the file out of it and fly the copy",
                    )
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
            As `check`, or if the folder cannot be created, or if another job writes to it.
        OSError
            If there is no room for it.
        """
        self.check()
        if self._lock.held:
            raise RuntimeError(f"opened twice: {self.target}")
        with Hold():
            try:
                for parent in reversed([p for p in self.target.parents if not p.exists()]):
                    parent.mkdir(exist_ok=True)
                    self._created.append(parent)
                for token in self._lock.take():
                    self._clean_up_after(token)
                self.path.mkdir()
                self._made = self.path.stat()
            except TakenError:
                raise self._error(
                    "another uavftc that is writing to it just now",
                    "one job at a time",
                    "wait until it has ended, or name another folder with --out",
                ) from None
            except NotOursError:
                raise self._error(
                    f"{self._lock.path}, which uavftc did not write and needs while it writes to this folder",
                    "that name to be free",
                    f"move {self._lock.path.name} elsewhere, or name another folder with --out",
                ) from None
            except OSError as error:
                if error.errno in FULL:
                    raise
                raise self._error(
                    str(error), "a place that can be written", "name another folder with --out"
                ) from error
            finally:
                if self._made is None:
                    self._end()
        return self.path

    def write_summary(self, document: Mapping[str, Any]) -> dict[str, Any]:
        """Write `summary.json`, after all other files, and return what it holds: `document` and the list of files.

        The list is under the key `files`: the path of each file in the folder, with its SHA-256.
        """
        whole = {**document, "files": manifest.checksums(self.path)}
        whole[manifest.OWN_CHECKSUM] = manifest.own_checksum(whole)
        write_json(self.path / manifest.SUMMARY, whole)
        return whole

    def figures(self, draw: Callable[[Path], object]) -> str | None:
        """Draw into the folder `figures`; where there is no room for them, leave none and return why.

        An exception of any other kind passes through, and then none are left either.
        """
        return self.extra("figures", draw)

    def extra(self, name: str, write: Callable[[Path], object]) -> str | None:
        """Let `write` write a file or folder that the results can do without; else as `figures`."""
        path = self.path / name
        try:
            write(path)
        except BaseException as error:
            with Hold():
                if path.is_dir():
                    shutil.rmtree(path, ignore_errors=True)
                else:
                    path.unlink(missing_ok=True)
            if isinstance(error, OSError) and error.errno in FULL:
                return os.strerror(error.errno)
            raise
        return None

    def commit(self) -> None:
        """Put the new folder in place of the old one; a second call does nothing.

        Raises
        ------
        InputError
            If something that is not ours appeared in the old folder meanwhile. The old folder stays as it is.
        """
        if self._made is None:
            return
        document = manifest.read_summary(self.path)  # what the next job into this folder will see
        if document is None:
            raise RuntimeError("not a result folder: no summary")
        if stray := manifest.foreign(self.path, manifest.names_of(document)):
            raise RuntimeError(f"not a result folder: its summary does not list {stray}")
        with Hold():
            self.check()
            try:
                self._put_in_place()
            except OSError as error:
                raise self._error(
                    str(error), "a folder that no other process writes to", "fly again, or name another folder"
                ) from error
            self._end()

    def discard(self) -> None:
        """Remove the unfinished folder and the parents created for it; does nothing once committed."""
        if self._made is not None:
            with Hold():
                self._end()

    def __enter__(self) -> ResultFolder:
        try:
            self.open()
        except BaseException:
            self.discard()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if kind is None:
                self.commit()
        finally:
            self.discard()

    def _sibling(self, role: str, token: str) -> Path:
        return self.target.with_name(f".{self.target.name}.{role}-{token}") if self.target.name else self.target

    def _put_in_place(self) -> None:
        """Let the new folder take the place of the old one, which is then `self.path` or `self._old`."""
        if not os.path.lexists(self.target):
            self.path.rename(self.target)
        elif exchange(self.path, self.target):
            try:
                self._refuse_what_is_not_ours(self.path)  # a file put there between the look and the exchange
            except BaseException:
                exchange(self.path, self.target)
                raise
        else:
            self.target.rename(self._old)
            try:
                self._refuse_what_is_not_ours(self._old)
                self.path.rename(self.target)
            except BaseException:
                self._old.rename(self.target)
                raise

    def _is_made_here(self, folder: Path) -> bool:
        try:
            return self._made is not None and os.path.samestat(os.lstat(folder), self._made)
        except OSError:
            return False

    def _end(self) -> None:
        """Leave either the new folder in its place or no trace of it, and nothing beside it but what is said."""
        committed = self._is_made_here(self.target)
        for _ in range(3):  # what failed once by chance is tried again
            away = _is_there(self._old) and not os.path.lexists(self.target)
            if not away:
                break
            with suppress(OSError):
                self._old.rename(self.target)
        for folder in [self.path] if away else [self.path, self._old]:
            for _ in range(2):
                if not _is_there(folder):
                    break
                if self._is_made_here(folder):
                    shutil.rmtree(folder, ignore_errors=True)
                    continue
                with suppress(OSError):
                    if self._made is not None or folder is self._old:
                        manifest.remove_ours(folder)
                    else:  # made, and not even looked at yet
                        folder.rmdir()
            self._say_what_remains(folder)
        self._made = None
        if away:
            _log.warning("warning: the old results are in %s; the next job into this folder puts them back", self._old)
        self._lock.release(forget=not away)
        if not committed:
            self._remove_created()

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

    def _clean_up_after(self, token: str) -> None:
        """Remove what a killed job into this folder left, and put back an old folder caught between two renames."""
        old = self._sibling("old", token)
        if os.path.lexists(old) and not old.is_symlink() and not os.path.lexists(self.target):
            old.rename(self.target)
        for folder in (self._sibling("partial", token), old):
            manifest.remove_ours(folder, unfinished=folder is not old)
            self._say_what_remains(folder)

    def _say_what_remains(self, folder: Path) -> None:
        if _is_there(folder):
            inside: list[str] = []
            with suppress(OSError):
                inside = sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if not p.is_dir())
            what = ", ".join(inside[:3]) + (f" and {len(inside) - 3} more" if len(inside) > 3 else "")
            _log.warning(
                "warning: %s stays, with %s: edited, not written by uavftc, or not removable; look, then remove it",
                folder,
                what or "nothing that can be seen",
            )

    def _remove_created(self) -> None:
        for parent in reversed(self._created):
            with suppress(OSError):  # somebody else uses it by now
                parent.rmdir()
        self._created.clear()

    def _error(self, found: str, expected: str, remedy: str) -> InputError:
        return InputError(f"--out {self._shown}", found=found, expected=expected, remedy=remedy)


def _is_there(path: Path) -> bool:
    """Return whether something has the name; what cannot be looked at may."""
    try:
        os.lstat(path)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return True
