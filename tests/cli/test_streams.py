"""What happens to the streams, the folder or the paths of a command is told by the promised exit code and one line."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from uavftc.cli.streams import Stream
from uavftc.results.history import read_history

pytestmark = pytest.mark.skipif(os.name == "nt", reason="a shell")

UAVFTC = f"{shlex.quote(sys.executable)} -m uavftc"
FLY = f"{UAVFTC} fly scenario1 --plant analytic --set duration_s=1 --out run"
LOST = f"{FLY} --no-plots --set 'reference.phi_deg=80*t' --set 'envelope={{phi_deg: 30}}'"


def shell(command: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a command by bash; its exit code is that of the first part of a pipe."""
    return subprocess.run(
        ["bash", "-c", f"{command}; exit ${{PIPESTATUS[0]}}"],
        cwd=folder, env=os.environ | environment, capture_output=True, text=True, errors="replace", check=False,
        timeout=120,
    )  # fmt: skip


CASES = {
    "a reader that has seen enough": (f"{FLY} --no-plots | head -1", {}, 0, ""),
    "no reader": (f"{FLY} --no-plots | true", {}, 0, ""),
    "closed standard output": (f"{FLY} --no-plots >&-", {}, 0, ""),
    "all streams closed": (f"{FLY} --no-plots <&- >&- 2>&-", {}, 0, ""),
    "no room for the output": (
        f"{FLY} --no-plots >/dev/full", {}, 1, "error: standard output: No space left on device\n"
    ),
    "no room for the errors": (f"{FLY} --no-plots 2>/dev/full", {}, 0, ""),
    "ASCII": (f"{FLY} --no-plots", {"PYTHONIOENCODING": "ascii"}, 0, ""),
    "an unknown backend": (FLY, {"MPLBACKEND": "junk"}, 0, ""),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_flight_is_written_and_the_exit_code_is_the_promised_one(case: str, tmp_path: Path) -> None:
    if "/dev/full" in CASES[case][0] and not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    command, environment, code, errors = CASES[case]
    done = shell(command, tmp_path, **environment)
    assert (done.returncode, done.stderr) == (code, errors)
    assert len(read_history(tmp_path / "run" / "history.parquet", ["time_s"])["time_s"]) == 201
    assert os.listdir(tmp_path) == ["run"]


@pytest.mark.parametrize("name", ["d\udcff", "\x1b[31md"])
def test_a_path_that_is_no_text_or_colours_the_terminal(name: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "uavftc", "fly", "scenario1", "--plant", "analytic", "--set", "duration_s=1"]
    done = subprocess.run(
        [*command, "--no-plots", "--out", name], cwd=tmp_path, capture_output=True, check=False, timeout=120
    )
    assert (done.returncode, done.stderr) == (0, b"")
    assert os.listdir(tmp_path) == [name]
    assert len(read_history(tmp_path / name / "history.parquet", ["time_s"])["time_s"]) == 201
    assert b"\x1b" not in done.stdout


def test_a_working_folder_that_was_deleted_is_one_message(tmp_path: Path) -> None:
    done = shell(f"mkdir gone; cd gone; rmdir ../gone; {FLY}", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: the working folder\n  found:    it was deleted\n")


@pytest.mark.parametrize(
    "arguments", [["\x1b[31mfly"], ["fly", "\x1b[31m"], ["fly", "scenario1", "--set", "\x1b[31m=\x9b3m"]]
)
def test_what_a_terminal_would_obey_is_spelt_out_in_an_error(arguments: list[str], tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "uavftc", *arguments], cwd=tmp_path, capture_output=True, check=False, timeout=120
    )
    assert done.returncode == 2
    assert b"x1b[31m" in done.stderr
    assert not {b"\x1b", b"\xc2\x9b"} & {done.stderr[i : i + n] for i in range(len(done.stderr)) for n in (1, 2)}


def test_control_characters_in_a_name_do_not_reach_the_terminal_by_way_of_a_table() -> None:
    import io

    from rich.text import Text

    from uavftc.report.console import Terminal

    screen = io.StringIO()
    Terminal(file=screen, force_terminal=False).print(Text("a\x1b[31mb\x9b3m"))
    assert screen.getvalue() == "a?[31mb?3m\n"


def test_json_stays_json_when_control_characters_are_spelt_out() -> None:
    import io
    import json

    screen = io.StringIO()
    print(json.dumps({"name": "\x1b\x7f\x9b"}, ensure_ascii=False), file=Stream(screen))  # type: ignore[arg-type]
    assert json.loads(screen.getvalue()) == {"name": "\x1b\x7f\x9b"}
    assert screen.getvalue().isprintable() or screen.getvalue()[:-1].isprintable()


SLOW_IMPORT = """
import sys, time
class Waits:
    def find_spec(self, name, path=None, target=None):
        if name == "typer":
            print("importing", flush=True)
            time.sleep(30)
sys.meta_path.insert(0, Waits())
from uavftc.cli.entry import main
main()
"""


def test_ctrl_c_while_the_command_is_still_imported_is_one_line() -> None:
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", SLOW_IMPORT], stdout=pipe, stderr=pipe, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "importing\n"
        child.send_signal(signal.SIGINT)
        _, errors = child.communicate(timeout=20)
    assert (child.returncode, errors) == (130, "interrupted\n")


@pytest.mark.slow
@pytest.mark.parametrize("after_s", [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
def test_ctrl_c_in_reproduce_is_one_line_whatever_its_workers_do(after_s: float, tmp_path: Path) -> None:
    pipe = subprocess.PIPE
    command = [sys.executable, "-m", "uavftc", "reproduce", "--plant", "analytic", "--no-plots", "--quiet"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=pipe, stderr=pipe, text=True, start_new_session=True) as child:
        time.sleep(after_s)
        os.killpg(child.pid, signal.SIGINT)  # to the workers too, as a terminal does
        _, errors = child.communicate(timeout=60)
    assert (child.returncode, errors) == (130, "interrupted\n")
    assert not list(tmp_path.glob("results/*"))
    assert not list(tmp_path.glob("results/.*"))
