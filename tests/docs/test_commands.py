"""Every command of the pages exists as it stands there; those that a reader copies are run.

The second half flies for some minutes: `pytest -m slow -n 0 tests/docs/test_commands.py`.
"""

from __future__ import annotations

import functools
import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from pages import PAGES, files_of, inline_commands, lines_of, name_of, shell_blocks, text_of

from uavftc.cli.app import single, umbrella

TREE = typer.main.get_command(umbrella)
FLY = typer.main.get_command(single)
PROGRAMS = ("uavftc", "uavftc-fly")


def calls(line: str) -> Iterator[list[str]]:
    """Yield the calls of this project's programs in a line of a shell, program first."""
    if "uavftc" not in line:
        return
    lexer = shlex.shlex(line, posix=True, punctuation_chars="|&;()<>")
    lexer.whitespace_split = True
    words: list[str] = []
    for word in [*lexer, ";"]:
        if re.fullmatch(r"[|&;()<>]+", word):
            if words and Path(words[0]).name in PROGRAMS:
                yield [Path(words[0]).name, *words[1:]]
            words = []
        else:
            words.append(word)


@functools.cache
def written() -> list[tuple[str, str, bool]]:
    """Return page, call, and whether it must be complete, of every command of the pages."""
    found: dict[tuple[str, str, bool], None] = {}
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        lines = [line for block in shell_blocks(text) for line in lines_of(block)]
        for complete, texts in ((True, lines), (False, inline_commands(text))):
            for line in texts:
                for call in calls(line):
                    found[name_of(page), shlex.join(call), complete] = None
    return list(found)


def parse(call: list[str], complete: bool) -> None:
    """Let the command line read a call, without running it."""
    program, *words = call
    command = TREE
    if program == "uavftc-fly":
        command = FLY
    elif not words[0].startswith("-"):
        command = TREE.get_command(TREE.make_context("uavftc", [], resilient_parsing=True), words.pop(0))
        if command is None:
            pytest.fail(f"{shlex.join(call)}: no such command")
    try:
        if complete:
            command.make_context(program, words)
        else:  # a command that is only named may leave out what it needs
            context = command.make_context(program, [], resilient_parsing=True)
            _, rest, _ = command.make_parser(context).parse_args(words)
            assert not rest, rest
    except Exception as error:
        if type(error).__name__ != "Exit":  # `--help` and `--version` print and end
            pytest.fail(f"{shlex.join(call)}: {error}")


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_and_options_of_a_page_exist(page: Path) -> None:
    of_page = [(call, complete) for name, call, complete in written() if name == name_of(page)]
    for call, complete in of_page:
        parse([word for word in shlex.split(call) if word != "..."], complete)


def test_the_pages_have_commands() -> None:
    assert len(written()) > 200  # the gallery alone has 74


@pytest.mark.parametrize(
    "call", ["uavftc flie scenario1", "uavftc-fly scenario1 --aircrafts hale", "uavftc margin scenario1 scenario2"]
)
def test_a_command_that_does_not_exist_is_found(call: str) -> None:
    with pytest.raises(pytest.fail.Exception):
        parse(shlex.split(call), complete=True)


# What a page shows and a test cannot run, with the reason.
NOT_RUN = {
    r"\bpip install\b|^\. \.venv|pytest": "installs, or is this test suite",
    r"^mkdir -p my-flights": "the test has a folder of its own",
    r"\bDIR\b|path/to/|my/|my-campaign": "names a folder or file of the reader's",
    r"uavftc bench": "measures for minutes; tests/jobs/bench does it in short",
    r"^uavftc reproduce": "tests/jobs/paper flies all of it",
    r"^uavftc falsify": "500 flights; tests/jobs/falsify searches in short",
    r"uavftc-fly \.\.\.": "is no whole command",
    r"uavftc report results/sweep-": "the campaign is flown on another page",
    r"indi\.py": "the controller stands in tests/examples, whose tests fly it",
    r"^\.venv/bin/|tools/": "of the checkout: tools have their own tests",
}
RUN = ["docs/custom-controller.md", "docs/new-aircraft.md", "docs/report.md", "docs/editor.md",
       "docs/margins.md", "docs/damage.md", "docs/requirements.md", "docs/scenarios.md", "docs/survivable.md",
       "docs/theory.md", "docs/uncertainty.md", "docs/aircraft.md"]  # fmt: skip


def is_run(line: str) -> bool:
    return not any(re.search(pattern, line) for pattern in NOT_RUN)


def run(lines: list[str], folder: Path) -> None:
    """Run lines in a shell, with the programs of this interpreter; the first that fails ends it."""
    programs = Path(sys.executable).parent
    env = os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-euxo", "pipefail", "-c", "\n".join(lines)],
        check=False,
        cwd=folder,
        env=env,
        capture_output=True,
        text=True,
    )
    last = [line for line in done.stderr.splitlines() if line.startswith("+ ")][-1:]
    assert done.returncode == 0, f"{last}: exit code {done.returncode}\n{done.stderr[-2000:]}"


def run_page(page: str, folder: Path) -> None:
    """Write the files of a page and run its commands in their order."""
    text = text_of(page)
    for name, content in files_of(text).items():
        (folder / name).write_text(content, encoding="utf-8")
    lines = [line for block in shell_blocks(text) for line in lines_of(block) if is_run(line)]
    assert lines
    run(lines, folder)


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN)
def test_the_commands_of_a_page_run_in_their_order(page: str, tmp_path: Path) -> None:
    run_page(page, tmp_path)


# What the tutorial says of the margin of each flight that it makes.
MARGINS = {"scenario3": 0.92, "mine": 0.48, "worse": -0.81, "trainer-fault": 0.71}


def check_margins(folder: Path) -> None:
    text = text_of("docs/tutorial.md")
    for name, margin in MARGINS.items():
        assert f"{margin}" in text
        summary = json.loads((folder / f"results/{name}-nndondi-l1-jsbsim/summary.json").read_text(encoding="utf-8"))
        assert round(summary["verdict"]["margin"], 2) == margin, name


@pytest.mark.slow
def test_the_tutorial_runs_and_what_it_says_of_its_flights_is_so(tmp_path: Path) -> None:
    run_page("docs/tutorial.md", tmp_path)
    check_margins(tmp_path)
    assert (tmp_path / "results/scenario3-nndondi-l1-jsbsim/report.html").exists()
    assert (tmp_path / "trainer/uavftc.yaml").exists()


@pytest.fixture(scope="module")
def readers_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder in which scenario 3 was flown, with the controller of the page on custom ones."""
    folder = tmp_path_factory.mktemp("reader")
    controller = files_of(text_of("docs/custom-controller.md"))["my_controller.py"]
    (folder / "my_controller.py").write_text(controller, encoding="utf-8")
    run(["uavftc-fly scenario3 --no-plots"], folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("call", inline_commands(text_of("README.md")))
def test_the_commands_of_the_readme_run(call: str, readers_folder: Path) -> None:
    for pattern, reason in NOT_RUN.items():
        if re.search(pattern, call):
            pytest.skip(reason)
    run([call], readers_folder)
