"""Every file operation of writing a result folder fails, is interrupted, or is the last one of its process.

Whatever happens: the old results or the new ones are there, whole; nothing of the user's is touched; nothing is left
over, or it is said and the next job removes it. Prints its counts:

    python -m pytest -n 0 -m slow -s tests/hostile/test_hostile_files.py
"""

from __future__ import annotations

import builtins
import errno
import io
import os
import signal
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from uavftc.errors import InputError
from uavftc.results import exchange as exchanges
from uavftc.results import folder as results
from uavftc.results import manifest
from uavftc.results.folder import ResultFolder

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name == "nt", reason="signals, fork"),
    # an interrupt right after an open leaves the file to the garbage collector
    pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning"),
]

OPERATIONS = (
    "open", "mkdir", "rename", "replace", "unlink", "rmdir", "ftruncate", "pwrite", "close", "stat", "lstat", "scandir"
)  # fmt: skip
WAYS = ("exchange", "two renames")
CODES = (errno.ENOSPC, errno.EIO, errno.EACCES)
Act = Callable[[str], None]


class Injector:
    """Counts the file operations, and acts before or after one of them, or before each from one on."""

    def __init__(self, at: int, act: Act, *, after: bool = False, on: bool = False) -> None:
        self.count = 0
        self._at, self._act, self._after, self._on = at, act, after, on

    def wrap(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def wrapped(*arguments: Any, **options: Any) -> Any:
            self.count += 1
            hit = self.count == self._at or (self._on and self.count > self._at)
            after = self._after or name == "close"  # whose failure leaves nothing open either
            if hit and not after:
                self._act(name)
            done = function(*arguments, **options)
            if hit and after:
                self._act(name)
            return done

        return wrapped


@contextmanager
def injected(injector: Injector, way: str) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name in OPERATIONS:
            patch.setattr(os, name, injector.wrap(name, getattr(os, name)))
        opened = injector.wrap("open", io.open)
        patch.setattr(io, "open", opened)
        patch.setattr(builtins, "open", opened)
        if way == "two renames":
            patch.setattr(results, "exchange", lambda one, other: False)
        else:
            patch.setattr(results, "exchange", injector.wrap("exchange", exchanges.exchange))
        yield


def write(target: Path, run: int) -> None:
    with ResultFolder(target) as folder:
        (folder.path / "figures").mkdir()
        for name in ("history.parquet", "scenario.yaml", "figures/tracking.png"):
            (folder.path / name).write_bytes(f"{name} {run}".encode())
        folder.write_summary({"provenance": {"uavftc": "0"}, "run": run})


def run_of(target: Path) -> int | None:
    """Return which results these are, once they are seen to be whole; None where there is no folder."""
    if not target.exists():
        return None
    document = manifest.read_summary(target)
    assert document is not None, sorted(target.rglob("*"))
    assert manifest.foreign(target, manifest.names_of(document)) is None
    assert manifest.changed(target, document) is None
    assert set(document["files"]) == {"history.parquet", "scenario.yaml", "figures/tracking.png"}
    assert all((target / name).is_file() for name in document["files"])
    return int(document["run"])


class Place:
    """A folder in which results are written, with what is the user's next to them."""

    def __init__(self, folder: Path, old: bool) -> None:
        self.target = folder / "run"
        folder.mkdir()
        (folder / "notes.txt").write_text("mine")
        (folder / ".run.partial-99999").mkdir()
        (folder / ".run.partial-99999" / "history.parquet").write_text("mine")
        (folder / ".run.old-99998").write_text("mine")
        self.before = self._users()
        if old:
            write(self.target, 1)

    def _users(self) -> dict[str, bytes | None]:
        parts = [self.target.parent / name for name in ("notes.txt", ".run.partial-99999", ".run.old-99998")]
        files = [file for part in parts for file in (part, *part.rglob("*"))]
        return {str(file): file.read_bytes() if file.is_file() else None for file in files}

    def remains(self) -> set[str]:
        return set(os.listdir(self.target.parent)) - {"notes.txt", ".run.partial-99999", ".run.old-99998", "run"}

    def check(self, old: bool, *, wrote: bool | None) -> None:
        assert self._users() == self.before
        run = run_of(self.target)
        possible = {True: {2}, False: {1 if old else None}, None: {1 if old else None, 2}}[wrote]
        assert run in possible

    def check_the_next_job_clears_up(self) -> None:
        write(self.target, 3)
        assert run_of(self.target) == 3
        assert self.remains() == set()
        assert self._users() == self.before


def operations(folder: Path, way: str, old: bool) -> int:
    place, counter = Place(folder, old), Injector(0, lambda name: None)
    with injected(counter, way):
        write(place.target, 2)
    assert counter.count > 30  # the injector sees what it is for
    return counter.count


def fail(code: int) -> Act:
    def act(name: str) -> None:
        raise OSError(code, os.strerror(code))

    return act


def interrupt(name: str) -> None:
    os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize("old", [True, False], ids=["old results", "none"])
@pytest.mark.parametrize("way", WAYS)
def test_an_operation_that_fails(tmp_path: Path, caplog: pytest.LogCaptureFixture, way: str, old: bool) -> None:
    cases = 0
    for on in (False, True):  # once, and from there on: a disk that is gone
        for code in CODES:
            for at in range(1, operations(tmp_path / f"count-{on}-{code}", way, old) + 1):
                caplog.clear()
                place = Place(tmp_path / f"{on}-{code}-{at}", old)
                wrote = True
                try:
                    with injected(Injector(at, fail(code), on=on), way):
                        write(place.target, 2)
                except (OSError, InputError, RuntimeError):
                    wrote = False
                with_trouble = on and not (place.target.exists() or not old)  # the rename back failed too
                if with_trouble:
                    assert "puts them back" in caplog.text
                else:
                    place.check(old, wrote=True if wrote else None)
                left = place.remains() - {".run.uavftc"}
                assert not left if not on else all(name in caplog.text for name in left), (at, left)
                place.check_the_next_job_clears_up()
                cases += 1
    print(f"\n{cases} cases of a failing operation ({way}, {'old results' if old else 'none'}), 0 defects")


@pytest.mark.parametrize("old", [True, False], ids=["old results", "none"])
@pytest.mark.parametrize("way", WAYS)
def test_ctrl_c_at_an_operation(tmp_path: Path, way: str, old: bool) -> None:
    cases = 0
    for after in (False, True):
        for at in range(1, operations(tmp_path / f"count-{after}", way, old) + 1):
            place = Place(tmp_path / f"{after}-{at}", old)
            with pytest.raises(KeyboardInterrupt), injected(Injector(at, interrupt, after=after), way):  # noqa: PT012
                write(place.target, 2)
                raise KeyboardInterrupt  # held to the end of everything
            place.check(old, wrote=None)
            assert place.remains() == set(), (at, after)
            cases += 1
    print(f"\n{cases} cases of Ctrl-C at an operation ({way}, {'old results' if old else 'none'}), 0 defects")


@pytest.mark.parametrize("old", [True, False], ids=["old results", "none"])
@pytest.mark.parametrize("way", WAYS)
def test_a_process_killed_at_an_operation(tmp_path: Path, way: str, old: bool) -> None:
    cases = 0
    for at in range(1, operations(tmp_path / "count", way, old) + 1):
        place = Place(tmp_path / str(at), old)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of threads of other tests
            child = os.fork()
        if child == 0:
            with injected(Injector(at, lambda name: os.kill(os.getpid(), signal.SIGKILL)), way):
                write(place.target, 2)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        assert os.WIFSIGNALED(status), at
        if way == "exchange" or not old or place.target.exists():
            place.check(old, wrote=None)  # at once: the target is never gone
        else:  # between the two renames: hidden, whole, and the next job puts it back
            (hidden,) = place.target.parent.glob(".run.old-" + "[0-9a-f]" * 16)
            assert run_of(hidden) == 1
            folder = ResultFolder(place.target)
            folder.open()
            folder.discard()
            assert run_of(place.target) == 1
        place.check_the_next_job_clears_up()
        cases += 1
    print(f"\n{cases} cases of a process killed at an operation ({way}, {'old results' if old else 'none'}), 0 defects")


def test_ctrl_c_at_an_operation_of_a_flight_loses_nothing_of_it(tmp_path: Path) -> None:
    from uavftc.jobs.fly import fly_mission
    from uavftc.scenario.load import load_scenario

    scenario = load_scenario("scenario1", plant="analytic", overrides=["duration_s=1"])
    fly_mission(scenario, tmp_path / "first", figures=False)  # compiled by now
    opened = ResultFolder.open
    cases = 0

    def flown(at: int, target: Path) -> tuple[int, bool]:
        counter = Injector(at, interrupt)

        def open_and_count(self: ResultFolder) -> Path:
            path = opened(self)
            counter.count = 0  # what is interrupted before it flies is simply not flown
            return path

        with pytest.MonkeyPatch.context() as patch, injected(counter, "exchange"):
            patch.setattr(ResultFolder, "open", open_and_count)
            counter.count = 10_000
            _, outcome = fly_mission(scenario, target, figures=False)
        return counter.count, outcome.interrupted

    total, interrupted = flown(0, tmp_path / "counted")
    assert not interrupted
    for at in range(1, total + 1):
        target = tmp_path / f"flight-{at}"
        _, interrupted = flown(at, target)
        assert interrupted
        document = manifest.read_summary(target)
        assert document is not None
        assert manifest.changed(target, document) is None
        assert {"history.parquet", "scenario.yaml"} <= set(document["files"])
        assert not list(tmp_path.glob(f".flight-{at}.*"))
        cases += 1
    assert cases > 20
    print(f"\n{cases} cases of Ctrl-C at an operation of a flight, 0 defects")
