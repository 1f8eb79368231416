"""`uavftc report` and `--report` as a user meets them."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uavftc.cli.app import umbrella
from uavftc.report.page import html
from uavftc.results import manifest

SHORT = ("--set", "duration_s=2", "--no-plots", "--quiet")


def run(*arguments: str):
    return CliRunner().invoke(umbrella, list(arguments))


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Return a folder with a flight and a comparison that have their pages."""
    folder = tmp_path_factory.mktemp("made")
    assert run("fly", "scenario1", "--report", "--out", str(folder / "flight"), *SHORT).exit_code == 0
    compared = ("compare", "scenario1", "--controllers", "nndondi-l1,pid", "--report", "--out", str(folder / "both"))
    assert run(*compared, *SHORT).exit_code == 0
    return folder


@pytest.fixture
def flight(made: Path, tmp_path: Path) -> Path:
    """Return the flight's folder, to do with as one likes."""
    return Path(shutil.copytree(made / "flight", tmp_path / "flight"))


def page(folder: Path) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["flight", "both"])
def test_the_page_written_with_the_results_is_the_one_that_is_made_of_them(made, tmp_path, name):
    folder = shutil.copytree(made / name, tmp_path / name)
    before = page(folder)
    assert len(before.encode()) < html.MAX_BYTES
    (folder / "report.html").unlink()  # listed and not there is no fault of a folder
    done = run("report", str(folder))
    assert (done.exit_code, done.stdout) == (0, f"page: {folder / 'report.html'}\n")
    assert page(folder) == before


def test_a_folder_with_a_page_is_still_ours_and_is_replaced(flight):
    assert run("report", str(flight), "--quiet").output == ""
    document = manifest.read_summary(flight)
    assert document["files"]["report.html"] == manifest.checksum(flight / "report.html")
    assert manifest.changed(flight, document) is None
    assert sorted(path.name for path in flight.parent.iterdir()) == ["flight"]  # nothing next to it
    assert run("fly", "scenario1", "--out", str(flight), *SHORT).exit_code == 0
    assert not (flight / "report.html").exists()


def refused(folder: Path, *said: str) -> None:
    """Check that no page is written, with this said, and nothing changed."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} if folder.is_dir() else {}
    done = run("report", str(folder))
    assert done.exit_code == 2, done.output
    for text in said:
        assert text in done.stderr, done.stderr
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_what_is_no_result_folder_is_refused(tmp_path):
    refused(tmp_path / "nowhere", "no such folder")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("of mine")
    refused(tmp_path / "mine", "no summary.json of uavftc")
    (tmp_path / "mine" / "campaign.json").write_text("{}")
    refused(tmp_path / "mine", "an unfinished campaign", "--resume")


def test_a_folder_with_something_of_the_users_is_refused(flight):
    (flight / "notes.txt").write_text("of mine")
    refused(flight, "notes.txt, which uavftc did not write")
    (flight / "notes.txt").unlink()
    (flight / "report.html").write_text("edited")
    refused(flight, "report.html, which was changed after uavftc wrote it")


def test_a_torn_history_and_one_that_is_gone_are_refused(flight):
    whole = (flight / "history.parquet").read_bytes()
    (flight / "history.parquet").write_bytes(whole[: len(whole) // 2])
    refused(flight, "history.parquet, which was changed after uavftc wrote it")
    (flight / "history.parquet").unlink()
    refused(flight, "no history.parquet in it")


def relisted(folder: Path) -> None:
    """Write the checksums anew, as if a file had been so from the start."""
    document = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    document["files"] = manifest.checksums(folder)
    document[manifest.OWN_CHECKSUM] = manifest.own_checksum(document)
    (folder / "summary.json").write_text(manifest.text_of(document), encoding="utf-8")


def test_a_history_that_is_no_parquet_is_refused_in_plain_words(flight):
    (flight / "history.parquet").write_bytes(b"PAR1 and then nothing")
    relisted(flight)
    refused(flight, "a history.parquet written by uavftc-fly")


def test_results_of_another_command_are_refused(flight):
    document = json.loads((flight / "summary.json").read_text(encoding="utf-8"))
    del document["axes"]
    (flight / "summary.json").write_text(json.dumps(document), encoding="utf-8")
    relisted(flight)
    refused(flight, "the results of another command", "a flight, a comparison, a reproduction or a campaign")


def test_without_the_extra_nothing_is_flown(flight, monkeypatch):
    monkeypatch.setattr(html.util, "find_spec", lambda name: None)
    refused(flight, "pip install 'uavftc[report]'")
    for command in ("fly", "compare"):
        out = flight.parent / "new"
        done = run(command, "scenario1", "--report", "--out", str(out), *SHORT)
        assert done.exit_code == 2
        assert "pip install 'uavftc[report]'" in done.stderr
        assert not out.exists()


def test_a_flight_that_cannot_be_built_again_has_a_page_that_says_so(flight):
    text = (flight / "scenario.yaml").read_text(encoding="utf-8")
    (flight / "scenario.yaml").write_text(text.replace("aircraft: hale", "aircraft: gone-since"), encoding="utf-8")
    relisted(flight)
    assert run("report", str(flight)).exit_code == 0
    assert "the flight cannot be built again (key aircraft: gone-since" in page(flight)


def test_the_paper_stands_next_to_a_flight_of_it_and_to_no_other(made, tmp_path):
    assert '<th scope="col">ratio</th>' not in page(made / "flight")  # two seconds are not the paper's twenty
    assert run("fly", "scenario1", "--report", "--out", str(tmp_path / "whole"), "--no-plots", "--quiet").exit_code == 0
    whole = page(tmp_path / "whole")
    assert "<td>0.1684</td><td>1.03</td>" in whole  # Table 2, saturated, roll, IAE, and ours over it


def test_a_full_disk_keeps_the_flight_without_its_page(tmp_path, monkeypatch):
    def full(self: Path, *args: object, **kwargs: object) -> int:
        if self.name == "report.html":
            raise OSError(28, "No space left on device")
        return written(self, *args, **kwargs)

    written = Path.write_text
    monkeypatch.setattr(Path, "write_text", full)
    done = run("fly", "scenario1", "--report", "--out", str(tmp_path / "flight"), "--set", "duration_s=2", "--no-plots")
    assert done.exit_code == 1
    assert "has no report.html: No space left on device" in done.stderr
    summary = json.loads((tmp_path / "flight" / "summary.json").read_text(encoding="utf-8"))
    assert "report.html" not in summary["files"]
    assert summary["warnings"][-1].endswith("the flight is kept, without its page")
