"""A single file as output: no file of the user's is replaced, and none is left half written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from uavftc.errors import InputError
from uavftc.results.single import KINDS, check_figure, figure_metadata, write_single


def draw(file: Path, metadata: dict[str, str | None] | None = None) -> None:
    figure = Figure()
    figure.text(0.5, 0.5, "drawn by uavftc")  # a mention in the picture is not the mark
    figure.savefig(file, metadata=metadata)


@pytest.mark.parametrize("kind", KINDS)
def test_a_figure_of_ours_is_replaced_and_one_of_the_users_is_not(tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"figure{kind}"
    check_figure("--figure", file, force=False)
    write_single(file, lambda partial: draw(partial, figure_metadata(kind)))
    check_figure("--figure", file, force=False)
    draw(file)
    before = file.read_bytes()
    with pytest.raises(InputError, match="did not write") as refused:
        check_figure("--figure", file, force=False)
    assert refused.value.remedy.endswith(f"--figure {file} --force")
    check_figure("--figure", file, force=True)
    assert file.read_bytes() == before
    assert os.listdir(tmp_path) == [file.name]


@pytest.mark.parametrize("content", [b"", b"\x89PNG", b"Software\0uavftc 0.1.0"])
def test_what_is_no_figure_is_the_users(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "figure.png").write_bytes(content)
    with pytest.raises(InputError, match="did not write"):
        check_figure("--figure", tmp_path / "figure.png", force=False)


def test_a_link_and_a_pipe_are_the_users_and_nobody_waits(tmp_path: Path) -> None:
    write_single(tmp_path / "ours.png", lambda partial: draw(partial, figure_metadata(".png")))
    (tmp_path / "link.png").symlink_to(tmp_path / "ours.png")
    (tmp_path / "gone.png").symlink_to(tmp_path / "nowhere.png")
    os.mkfifo(tmp_path / "pipe.png")
    for name in ("link.png", "gone.png", "pipe.png"):
        with pytest.raises(InputError, match="did not write"):
            check_figure("--figure", tmp_path / name, force=False)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="a folder in which not even root can write")
def test_a_folder_in_which_nothing_can_be_written_is_refused_before_anything_is_computed() -> None:
    with pytest.raises(InputError, match="/proc cannot be written"):
        check_figure("--figure", Path("/proc/x.png"), force=False)


def test_a_drawing_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    file = tmp_path / "figure.png"
    file.write_text("before")

    def fails(partial: Path) -> None:
        partial.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        write_single(file, fails)
    assert file.read_text() == "before"
    assert os.listdir(tmp_path) == ["figure.png"]
