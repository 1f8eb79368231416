"""The bar is drawn on a terminal, and costs nothing otherwise."""

from __future__ import annotations

import io
import subprocess
import sys

from uavftc.report.progress import progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_bar_on_a_terminal_shows_label_and_share(monkeypatch):
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with progress(1000, label="flying [x]") as advance:
        advance(1000)
    assert "flying [x]" in screen.getvalue()
    assert "100%" in screen.getvalue()


def test_nothing_is_written_when_quiet_or_not_a_terminal(monkeypatch):
    for screen, quiet in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", screen)
        with progress(10, quiet=quiet) as advance:
            advance(10)
        assert screen.getvalue() == ""


def test_rich_is_not_imported_without_a_terminal():
    code = (
        "import sys; from uavftc.report.progress import progress\n"
        "with progress(10) as advance: advance(10)\n"
        "print('rich' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
    assert done.stderr == ""
