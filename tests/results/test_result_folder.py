"""A result folder is written whole or not at all, and nothing of the user's is lost."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from uavftc.errors import InputError
from uavftc.results import folder as results
from uavftc.results import manifest
from uavftc.results.exchange import exchange
from uavftc.results.folder import ResultFolder
from uavftc.results.lock import MARK, Lock
from uavftc.results.summary import write_json

OURS: dict[str, Any] = {"provenance": {"uavftc": "0.1.0"}}


def fill(folder: Path, run: int = 1) -> None:
    (folder / "figures").mkdir(parents=True)
    (folder / "history.parquet").write_bytes(b"h")
    (folder / "figures" / "tracking.png").write_bytes(b"p")
    (folder / "scenario.yaml").write_text("name: flown\n")
    write_json(folder / "summary.json", OURS | {"run": run, "files": manifest.checksums(folder)})


def fly(target: Path, run: int = 1) -> None:
    with ResultFolder(target) as folder:
        fill(folder.path, run)


def first_version(folder: Path, *names: str, **summary: Any) -> None:
    """Results as the first versions wrote them: no list of files in the summary."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("result")
    write_json(folder / "summary.json", OURS | summary)


def tree(folder: Path) -> dict[str, bytes | None]:
    """Everything beneath, hidden files too."""
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in sorted(folder.rglob("*"))}


DEAD = "0123456789abcdef"


def killed(target: Path, role: str = "partial", token: str = DEAD) -> Path:
    """Return the folder, not made yet, that a killed job into `target` left beside it, known by what it wrote there."""
    lock = Lock(target).path
    lock.write_text("\n".join([*(lock.read_text().splitlines() if lock.exists() else [MARK]), token, ""]))
    return target.with_name(f".{target.name}.{role}-{token}")


@pytest.fixture
def two_renames(monkeypatch):
    """A system without an exchange of two folders."""
    monkeypatch.setattr(results, "exchange", lambda one, other: False)


def remains(folder: Path) -> list[Path]:
    return sorted(folder.glob(".run.*"))


def test_the_folder_appears_only_when_complete_and_leaves_nothing_else(tmp_path):
    target = tmp_path / "a" / "b" / "run"
    with ResultFolder(target) as folder:
        assert folder.path.parent == tmp_path / "a" / "b"
        assert folder.path.name.startswith(".run.partial-")
        fill(folder.path)
        assert not target.exists()
    assert set(os.listdir(target)) == {"summary.json", "history.parquet", "scenario.yaml", "figures"}
    assert os.listdir(target.parent) == ["run"]


def test_check_writes_nothing(tmp_path):
    ResultFolder(tmp_path / "a" / "b").check()
    assert tree(tmp_path) == {}


def test_an_exception_leaves_no_trace_of_the_flight(tmp_path):
    def broken() -> None:
        with ResultFolder(tmp_path / "new" / "deep" / "run") as folder:
            fill(folder.path)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        broken()
    assert tree(tmp_path) == {}  # the parents made for it are gone too


def test_parents_that_somebody_else_uses_meanwhile_stay(tmp_path):
    folder = ResultFolder(tmp_path / "new" / "run")
    folder.open()
    (tmp_path / "new" / "notes.txt").write_text("mine")
    folder.discard()
    assert tree(tmp_path) == {"new": None, "new/notes.txt": b"mine"}


def test_an_empty_folder_may_be_used(tmp_path):
    (tmp_path / "run").mkdir()
    fly(tmp_path / "run")
    assert (tmp_path / "run" / "summary.json").exists()


def test_old_results_are_replaced_whole(tmp_path):
    with ResultFolder(tmp_path / "run") as folder:
        (folder.path / "flights.parquet").write_bytes(b"f")  # any job's files, whatever they are called
        (folder.path / "a" / "b").mkdir(parents=True)
        (folder.path / "a" / "b" / "c.csv").write_text("c")
        folder.write_summary(OURS)
    fly(tmp_path / "run", run=2)
    assert b'"run": 2' in (tmp_path / "run" / "summary.json").read_bytes()
    assert not (tmp_path / "run" / "flights.parquet").exists()  # no mixture of two jobs
    assert not (tmp_path / "run" / "a").exists()
    assert os.listdir(tmp_path) == ["run"]


def test_the_summary_lists_every_other_file_with_its_checksum(tmp_path):
    with ResultFolder(tmp_path / "run") as folder:
        fill(folder.path)
        (folder.path / "summary.json").unlink()
        document = folder.write_summary(OURS | {"run": 3})
    assert json.loads((tmp_path / "run" / "summary.json").read_bytes()) == document
    assert {name: document[name] for name in ("provenance", "run")} == OURS | {"run": 3}
    assert document["files"] == {
        "figures/tracking.png": hashlib.sha256(b"p").hexdigest(),
        "history.parquet": hashlib.sha256(b"h").hexdigest(),
        "scenario.yaml": hashlib.sha256(b"name: flown\n").hexdigest(),
    }


def test_an_edited_file_is_the_users_and_named(tmp_path):
    # the scenario as flown is the first thing to copy and change, and it is often changed where it is
    fly(tmp_path / "run")
    (tmp_path / "run" / "scenario.yaml").write_text("name: mine\n")
    before = tree(tmp_path)
    with pytest.raises(InputError, match=r"scenario\.yaml, which was changed after uavftc wrote it") as refused:
        fly(tmp_path / "run", run=2)
    assert refused.value.remedy == "move scenario.yaml elsewhere, or name another folder with --out"
    assert tree(tmp_path) == before
    (tmp_path / "run" / "scenario.yaml").write_text("name: flown\n")  # taken back
    fly(tmp_path / "run", run=2)


def test_a_file_that_the_user_deleted_is_no_reason_to_keep_the_rest(tmp_path):
    fly(tmp_path / "run")
    (tmp_path / "run" / "figures" / "tracking.png").unlink()
    fly(tmp_path / "run", run=2)
    assert b'"run": 2' in (tmp_path / "run" / "summary.json").read_bytes()


INTRUSIONS = {"scenario.yaml": "name: mine\n", "notes.txt": "mine", "summary.json": "{}"}


@pytest.mark.parametrize("way", ["exchange", "two renames"])
@pytest.mark.parametrize("name", INTRUSIONS)
def test_what_the_user_writes_at_the_very_last_moment_is_not_removed_and_said(tmp_path, monkeypatch, caplog, way, name):
    fly(tmp_path / "run", run=1)
    refuse = ResultFolder._refuse_what_is_not_ours

    def refuse_then_intrude(self: ResultFolder, folder: Path) -> None:
        refuse(self, folder)
        if folder != self.target:
            (folder / name).write_text(INTRUSIONS[name])

    monkeypatch.setattr(ResultFolder, "_refuse_what_is_not_ours", refuse_then_intrude)
    if way == "two renames":
        monkeypatch.setattr(results, "exchange", lambda one, other: False)
    fly(tmp_path / "run", run=2)
    assert b'"run": 2' in (tmp_path / "run" / "summary.json").read_bytes()
    (left,) = remains(tmp_path)
    kept = tree(left)
    assert kept[name] == INTRUSIONS[name].encode()
    if name != "summary.json":  # which stays with it and tells that it was edited
        assert set(kept) == {name, "summary.json"}
    fly(tmp_path / "run", run=3)
    assert tree(left) == kept
    assert str(left) in caplog.text
    assert name in caplog.text or name == "summary.json"  # without it all files are strangers; three are named


@pytest.mark.parametrize("edit", [b"", b"\n", b'{"a": 1}'])
def test_an_edited_summary_is_the_users(tmp_path, edit):
    with ResultFolder(tmp_path / "run") as folder:
        (folder.path / "history.parquet").write_bytes(b"h")
        folder.write_summary(OURS | {"run": 1, "note": "flown", "timing": {"flight_wall_s": 0.1}})
    summary = tmp_path / "run" / "summary.json"
    before = summary.read_bytes()
    ResultFolder(tmp_path / "run").check()
    summary.write_bytes(before.replace(b"flown", b"good") if edit == b"" else before + edit)
    with pytest.raises(InputError, match=r"summary\.json"):
        ResultFolder(tmp_path / "run").check()
    manifest.remove_ours(tmp_path / "run")
    assert summary.exists()


def test_the_checksum_of_a_summary_leaves_out_what_differs_between_two_runs(tmp_path):
    def written(wall_s: float) -> str:
        with ResultFolder(tmp_path / "run") as folder:
            flights = [{"timing": {"flight_wall_s": wall_s}, "wall_s": wall_s, "iae": 1.0}]
            return str(folder.write_summary(OURS | {"combinations": flights})["summary_sha256"])

    assert written(0.1) == written(0.2)


@pytest.mark.parametrize("inside", ["scenario.yaml", "figures/scenario.yaml"])
def test_a_folder_that_holds_what_is_flown_is_not_replaced(tmp_path, inside):
    with ResultFolder(tmp_path / "run") as folder:
        for name in ("scenario.yaml", inside):
            (folder.path / name).parent.mkdir(exist_ok=True)
            (folder.path / name).write_text("name: flown\n")
        folder.write_summary(OURS)
    before = tree(tmp_path)
    with pytest.raises(InputError, match="which is to be flown, inside it") as refused:
        ResultFolder(tmp_path / "run", [tmp_path / "run" / inside]).check()
    assert "copy the file" in refused.value.remedy
    assert tree(tmp_path) == before
    ResultFolder(tmp_path / "run", [tmp_path / "runner" / "scenario.yaml"]).check()


FIRST_VERSIONS: dict[str, tuple[list[str], dict[str, Any]]] = {
    "flight": (["history.parquet", "scenario.yaml", "figures/air.png", "report.html"], {"axes": {}}),
    "comparison": (
        ["comparison.md", "figures/difference.png", "histories/jsbsim-my-law.parquet"],
        {"combinations": [{"plant": "jsbsim", "controller": "my-law"}]},
    ),
    "reproduction": (["reproduction.md", "tables.csv", "figures/jsbsim-figure-11.pdf"], {"claims": []}),
}


@pytest.mark.parametrize("kind", FIRST_VERSIONS)
def test_results_of_the_first_versions_are_replaced_though_they_list_no_files(tmp_path, kind):
    names, summary = FIRST_VERSIONS[kind]
    first_version(tmp_path / "run", *names, **summary)
    fly(tmp_path / "run", run=2)
    assert os.listdir(tmp_path) == ["run"]
    assert set(os.listdir(tmp_path / "run")) == {"summary.json", "history.parquet", "scenario.yaml", "figures"}


@pytest.mark.parametrize("kind", FIRST_VERSIONS)
@pytest.mark.parametrize("stray", ["notes.txt", "histories/jsbsim-other.parquet", "figures/mine.png"])
def test_a_file_of_the_users_in_results_of_the_first_versions_is_refused(tmp_path, kind, stray):
    names, summary = FIRST_VERSIONS[kind]
    first_version(tmp_path / "run", *names, stray, **summary)
    with pytest.raises(InputError, match=stray.partition("/")[0]):
        ResultFolder(tmp_path / "run").check()


def test_a_mixture_of_two_jobs_of_the_first_versions_is_not_ours(tmp_path):
    first_version(tmp_path / "run", "history.parquet", "comparison.md", axes={})
    with pytest.raises(InputError, match=r"comparison\.md"):
        ResultFolder(tmp_path / "run").check()


def test_old_results_survive_a_flight_that_fails(tmp_path):
    fly(tmp_path / "run")
    before = tree(tmp_path)

    def broken() -> None:
        with ResultFolder(tmp_path / "run") as folder:
            fill(folder.path, run=2)
            raise RuntimeError("boom")

    with pytest.raises(RuntimeError, match="boom"):
        broken()
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    "stray", ["notes.txt", "figures/mine.png", "figures/sub/x", "empty/", ".hidden", "history.csv"]
)
def test_a_folder_with_a_file_of_the_users_is_refused_by_name(tmp_path, stray):
    fly(tmp_path / "run")
    path = tmp_path / "run" / stray
    path.parent.mkdir(exist_ok=True)
    path.mkdir() if stray.endswith("/") else path.write_text("mine")
    before = tree(tmp_path)
    with pytest.raises(InputError, match=stray.split("/x")[0].rstrip("/")):
        ResultFolder(tmp_path / "run").check()
    assert tree(tmp_path) == before


def test_a_link_in_the_folder_is_the_users(tmp_path):
    fly(tmp_path / "run")
    elsewhere = tmp_path / "kept.parquet"
    (tmp_path / "run" / "history.parquet").rename(elsewhere)
    (tmp_path / "run" / "history.parquet").symlink_to(elsewhere)
    with pytest.raises(InputError, match=r"history\.parquet"):
        ResultFolder(tmp_path / "run").check()


NOT_OURS = [None, "{", "[]", '{"provenance": {}}', '{"provenance": "uavftc"}', '{"a": 1}']


@pytest.mark.parametrize(
    "text", [*NOT_OURS, "[" * 200_000, '{"a":' * 200_000, "\xff\x00"], ids=range(len(NOT_OURS) + 3)
)
def test_files_named_like_ours_without_our_summary_are_not_ours(tmp_path, text):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "scenario.yaml").write_text("name: written by hand")
    if text is not None:
        (tmp_path / "run" / "summary.json").write_text(text)
    with pytest.raises(InputError, match=r"no summary\.json of uavftc"):
        ResultFolder(tmp_path / "run").check()
    assert (tmp_path / "run" / "scenario.yaml").read_text() == "name: written by hand"


def test_a_summary_of_great_length_is_not_ours(tmp_path, monkeypatch):
    monkeypatch.setattr(manifest, "MAX_BYTES", 1_000)
    (tmp_path / "run").mkdir()
    write_json(tmp_path / "run" / "summary.json", OURS | {"text": "x" * 1_000})
    with pytest.raises(InputError, match=r"no summary\.json of uavftc"):
        ResultFolder(tmp_path / "run").check()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
@pytest.mark.parametrize("name", ["summary.json", "history.parquet"])
def test_a_pipe_is_the_users_and_nobody_waits_for_it(tmp_path, name):
    fly(tmp_path / "run")
    (tmp_path / "run" / name).unlink()
    os.mkfifo(tmp_path / "run" / name)
    with pytest.raises(InputError, match=name):
        ResultFolder(tmp_path / "run").check()


def test_a_summary_by_a_link_is_not_ours(tmp_path):
    fly(tmp_path / "run")
    (tmp_path / "run" / "summary.json").rename(tmp_path / "elsewhere.json")
    (tmp_path / "run" / "summary.json").symlink_to(tmp_path / "elsewhere.json")
    with pytest.raises(InputError, match=r"summary\.json"):
        ResultFolder(tmp_path / "run").check()


@pytest.mark.parametrize("files", [[], "all", 3, None, {"../thesis.tex": "0"}, {"scenario.yaml": None}])
def test_a_list_of_files_that_is_none_makes_no_file_ours(tmp_path, files):
    (tmp_path / "thesis.tex").write_text("years of work")
    first_version(tmp_path / "run", "scenario.yaml", files=files)
    with pytest.raises(InputError, match=r"scenario\.yaml"):
        ResultFolder(tmp_path / "run").check()
    assert (tmp_path / "thesis.tex").exists()


@pytest.mark.parametrize("target", ["file", "file/run", "file/deep/run"])
def test_a_file_in_the_way_is_refused(tmp_path, target):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match=r"a file|not a folder"):
        ResultFolder(tmp_path / target).check()
    assert tree(tmp_path) == {"file": b"mine"}


def test_a_parent_that_may_not_be_written_is_refused_before_the_flight(tmp_path, monkeypatch):
    monkeypatch.setattr(results.os, "access", lambda path, mode: Path(path) != tmp_path)  # root may write anywhere
    with pytest.raises(InputError, match="may not be written"):
        ResultFolder(tmp_path / "a" / "run").check()


def test_a_place_that_turns_out_unwritable_is_an_input_error_and_leaves_nothing(tmp_path):
    with pytest.raises(InputError, match="too long"):
        ResultFolder(tmp_path / "new" / ("n" * 250)).open()  # the hidden name is longer than a name may be
    assert tree(tmp_path) == {}


def test_the_working_folder_and_those_above_are_refused(tmp_path, monkeypatch):
    (tmp_path / "run" / "figures").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "run" / "figures")
    for target in (".", "..", "/"):
        with pytest.raises(InputError, match="working folder"):
            ResultFolder(Path(target)).check()


def test_a_file_put_in_during_the_flight_is_safe_and_nothing_is_replaced(tmp_path):
    fly(tmp_path / "run", run=1)

    def disturbed() -> None:
        with ResultFolder(tmp_path / "run") as folder:
            fill(folder.path, run=2)
            (tmp_path / "run" / "notes.txt").write_text("mine")

    with pytest.raises(InputError, match=r"notes\.txt"):
        disturbed()
    assert (tmp_path / "run" / "notes.txt").read_text() == "mine"
    assert b'"run": 1' in (tmp_path / "run" / "summary.json").read_bytes()
    assert os.listdir(tmp_path) == ["run"]


def test_a_file_put_in_between_the_look_and_the_move_is_safe(tmp_path, monkeypatch):
    fly(tmp_path / "run", run=1)
    check = ResultFolder.check

    def check_then_intrude(self: ResultFolder) -> None:
        check(self)
        if self.path.exists():
            (tmp_path / "run" / "notes.txt").write_text("mine")

    monkeypatch.setattr(ResultFolder, "check", check_then_intrude)
    with pytest.raises(InputError, match=r"notes\.txt"):
        fly(tmp_path / "run", run=2)
    assert (tmp_path / "run" / "notes.txt").read_text() == "mine"
    assert os.listdir(tmp_path) == ["run"]


def test_a_mount_point_is_refused_because_it_cannot_be_renamed(tmp_path, monkeypatch):
    (tmp_path / "out").mkdir()
    monkeypatch.setattr(os.path, "ismount", lambda path: Path(path) == tmp_path / "out")
    with pytest.raises(InputError, match="mount point"):
        ResultFolder(tmp_path / "out").check()
    ResultFolder(tmp_path / "out" / "run").check()  # the remedy it names


def test_the_old_folder_comes_back_if_the_new_one_cannot_be_moved_in(tmp_path, monkeypatch, two_renames):
    fly(tmp_path / "run", run=1)
    before = tree(tmp_path)
    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        if ".partial-" in self.name:
            raise OSError("disk trouble")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(InputError, match="disk trouble"):
        fly(tmp_path / "run", run=2)
    assert tree(tmp_path) == before


def test_what_a_killed_flight_left_is_removed_but_not_what_others_need(tmp_path):
    fill(killed(tmp_path / "run"))
    other = killed(tmp_path / "run2")
    fill(other)
    fly(tmp_path / "run")
    assert sorted(os.listdir(tmp_path)) == sorted(["run", other.name, ".run2.uavftc"])
    assert (other / "summary.json").exists()


def test_a_foreign_file_in_what_a_killed_flight_left_is_safe_and_said(tmp_path, caplog):
    stale = killed(tmp_path / "run")
    fill(stale)
    (stale / "notes.txt").write_text("mine")
    fly(tmp_path / "run")
    assert set(tree(stale)) == {"notes.txt", "summary.json"}
    assert f"{stale} stays, with notes.txt" in caplog.text


NAMED_LIKE_OURS = [
    ".run.partial-99999", ".run.old-99998", ".run.partial-fedcba9876543210", ".run.old-fedcba9876543210", ".run.lock"
]  # fmt: skip


@pytest.mark.parametrize("name", NAMED_LIKE_OURS)
@pytest.mark.parametrize("kind", ["empty folder", "results", "file"])
def test_what_is_only_named_like_ours_is_not_touched(tmp_path, name, kind):
    # nothing says that a job made it: the number of a dead process, or a token that no lock holds
    fly(tmp_path / "run")
    path = tmp_path / name
    if kind == "results":
        fill(path)
    elif kind == "file":
        path.write_text("mine")
    else:
        path.mkdir()
    before = tree(path), path.is_file() and path.read_text()
    fly(tmp_path / "run", run=2)
    assert (tree(path), path.is_file() and path.read_text()) == before


def test_a_file_of_the_users_with_the_name_of_the_lock_is_refused_and_stays(tmp_path):
    (tmp_path / ".run.uavftc").write_text("mine")
    with pytest.raises(InputError, match=r"\.run\.uavftc, which uavftc did not write"):
        fly(tmp_path / "run")
    assert tree(tmp_path) == {".run.uavftc": b"mine"}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
def test_a_pipe_with_the_name_of_the_lock_is_refused_and_nobody_waits_for_it(tmp_path):
    os.mkfifo(tmp_path / ".run.uavftc")
    with pytest.raises(InputError, match="did not write"):
        fly(tmp_path / "run")


def test_two_jobs_do_not_write_to_one_folder_at_a_time(tmp_path):
    with ResultFolder(tmp_path / "run") as folder:
        before = tree(tmp_path)
        with pytest.raises(InputError, match="another uavftc that is writing to it") as refused:
            ResultFolder(tmp_path / "run").open()
        assert "wait" in refused.value.remedy
        assert tree(tmp_path) == before
        fill(folder.path)
    assert (tmp_path / "run" / "summary.json").exists()
    fly(tmp_path / "run", run=2)


WAITS = (
    "import sys; from pathlib import Path; from uavftc.results.folder import ResultFolder\n"
    "ResultFolder(Path(sys.argv[1])).open(); print('open', flush=True); sys.stdin.read()"
)


def in_a_container(*command: str) -> list[str]:
    """Return a command that runs with process numbers of its own; skip where that is not permitted."""
    unshare = ["unshare", "--pid", "--fork", "--mount-proc"]
    if (
        shutil.which("unshare") is None
        or subprocess.run([*unshare, "true"], check=False, capture_output=True).returncode
    ):
        pytest.skip("no process namespaces here")
    return [*unshare, *command]


def test_a_job_in_another_container_is_not_taken_for_dead(tmp_path):
    command = in_a_container(sys.executable, "-c", WAITS, str(tmp_path / "run"))
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"open\n"
        before = tree(tmp_path)
        with pytest.raises(InputError, match="another uavftc"):
            fly(tmp_path / "run")
        assert tree(tmp_path) == before
        other.communicate()
    fly(tmp_path / "run", run=2)  # it ended without a word, and its folder is cleared away
    assert os.listdir(tmp_path) == ["run"]


def test_old_files_that_cannot_be_removed_are_said(tmp_path, monkeypatch, caplog):
    fly(tmp_path / "run", run=1)
    unlink = Path.unlink

    def immutable(self: Path, missing_ok: bool = False) -> None:  # as after chattr +i
        if self.name == "history.parquet":
            raise PermissionError(1, "Operation not permitted", str(self))
        unlink(self, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", immutable)
    fly(tmp_path / "run", run=2)
    assert b'"run": 2' in (tmp_path / "run" / "summary.json").read_bytes()
    (left,) = remains(tmp_path)
    assert f"{left} stays, with history.parquet" in caplog.text


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("way", ["exchange", "two renames"])
def test_ctrl_c_within_the_commit_waits_for_its_end(tmp_path, monkeypatch, way):
    fly(tmp_path / "run", run=1)
    seen = []

    def interrupted(one: Path, other: Path) -> bool:
        os.kill(os.getpid(), signal.SIGINT)
        seen.append((tmp_path / "run" / "summary.json").exists())
        done = way == "exchange" and exchange(one, other)
        os.kill(os.getpid(), signal.SIGINT)
        return done

    monkeypatch.setattr(results, "exchange", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fly(tmp_path / "run", run=2)
    assert seen == [True]
    assert b'"run": 2' in (tmp_path / "run" / "summary.json").read_bytes()
    assert os.listdir(tmp_path) == ["run"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="renameat2")
def test_the_target_is_there_at_every_moment_of_the_commit(tmp_path):
    # looked at from a thread while the folder is replaced again and again: one exchange, so never a gap
    fly(tmp_path / "run", run=0)
    (tmp_path / "other").mkdir()
    if not exchange(tmp_path / "run", tmp_path / "other"):
        pytest.skip("no exchange on this file system")
    exchange(tmp_path / "run", tmp_path / "other")
    gaps, over = [], threading.Event()

    def watch() -> None:
        while not over.is_set():
            try:
                os.stat(tmp_path / "run" / "summary.json")
            except FileNotFoundError:
                gaps.append(1)

    watcher = threading.Thread(target=watch)
    watcher.start()
    for run in range(50):
        fly(tmp_path / "run", run=run)
    over.set()
    watcher.join()
    assert gaps == []


def test_a_link_in_place_of_what_a_killed_flight_left_is_not_followed(tmp_path):
    fly(tmp_path / "kept")
    before = tree(tmp_path / "kept")
    killed(tmp_path / "run").symlink_to(tmp_path / "kept")
    killed(tmp_path / "run", "old", "1" * 16).symlink_to(tmp_path / "kept")
    fly(tmp_path / "run")
    assert tree(tmp_path / "kept") == before


def test_what_a_killed_job_left_without_a_summary_is_removed(tmp_path):
    stale = killed(tmp_path / "run")
    (stale / "histories").mkdir(parents=True)
    for name in ("history.parquet", "comparison.csv", "histories/analytic-mine.parquet"):
        (stale / name).write_bytes(b"half")
    fly(tmp_path / "run")
    assert os.listdir(tmp_path) == ["run"]


def test_a_kill_between_the_two_moves_is_put_right_by_the_next_flight(tmp_path):
    fill(killed(tmp_path / "run", "old"), run=1)
    folder = ResultFolder(tmp_path / "run")
    folder.open()
    assert b'"run": 1' in (tmp_path / "run" / "summary.json").read_bytes()  # back, even if this flight fails
    folder.discard()
    fly(tmp_path / "run", run=2)
    assert b'"run": 2' in (tmp_path / "run" / "summary.json").read_bytes()
    assert os.listdir(tmp_path) == ["run"]


def test_a_kill_during_the_flight_leaves_the_old_results(tmp_path):
    fly(tmp_path / "run", run=1)
    code = (
        "import os, signal, sys; from pathlib import Path; from uavftc.results.folder import ResultFolder\n"
        "with ResultFolder(Path(sys.argv[1])) as f:\n"
        "    (f.path / 'history.parquet').write_bytes(b'half'); os.kill(os.getpid(), signal.SIGKILL)"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path / "run")], check=False)
    assert done.returncode != 0
    assert len(remains(tmp_path)) == 2  # what it had written, and the lock that says whose it is
    assert b'"run": 1' in (tmp_path / "run" / "summary.json").read_bytes()
    fly(tmp_path / "run", run=2)
    assert os.listdir(tmp_path) == ["run"]


def test_a_link_to_the_target_is_followed_and_stays(tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "disk" / "run")  # dangling at first
    fly(tmp_path / "link", run=1)
    fly(tmp_path / "link", run=2)
    assert (tmp_path / "link").is_symlink()
    assert b'"run": 2' in (tmp_path / "disk" / "run" / "summary.json").read_bytes()
    assert os.listdir(tmp_path / "disk") == ["run"]


def test_committing_twice_and_discarding_afterwards_change_nothing(tmp_path):
    with ResultFolder(tmp_path / "run") as folder:
        fill(folder.path)
        folder.commit()
        folder.commit()
        folder.discard()
    assert (tmp_path / "run" / "history.parquet").exists()


def test_a_file_written_after_the_summary_is_caught_before_the_next_flight_would_refuse_it(tmp_path):
    def careless() -> None:
        with ResultFolder(tmp_path / "run") as folder:
            fill(folder.path)
            (folder.path / "new-feature.csv").write_text("x")

    with pytest.raises(RuntimeError, match=r"its summary does not list new-feature\.csv"):
        careless()
    assert tree(tmp_path) == {}


def test_a_folder_without_summary_is_caught(tmp_path):
    def careless() -> None:
        with ResultFolder(tmp_path / "run") as folder:
            (folder.path / "history.parquet").write_text("x")

    with pytest.raises(RuntimeError, match="no summary"):
        careless()
    assert tree(tmp_path) == {}
