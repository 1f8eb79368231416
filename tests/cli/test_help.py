"""What teaches on the command line: help with examples, lists of what is shipped, completion."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uavftc.cli.app import COMMANDS, single, umbrella
from uavftc.config import shipped

RUN = CliRunner()
NAMES = [command.__name__.replace("_", "-") for command in COMMANDS]


@pytest.mark.parametrize("name", NAMES)
def test_each_command_has_two_examples_that_fit_80_columns(name: str) -> None:
    text = RUN.invoke(umbrella, [name, "--help"], terminal_width=80).output
    examples = [line.strip() for line in text.partition("Examples:")[2].splitlines() if line.strip()]
    assert len(examples) >= 2
    for example in examples:
        assert len(example) <= 78
        assert shlex.split(example)[:2] == ["uavftc", name]


@pytest.mark.parametrize("name", NAMES)
def test_the_options_of_each_example_exist(name: str) -> None:
    from typer.main import get_command

    command = get_command(umbrella).commands[name]  # type: ignore[attr-defined]
    options = {option for parameter in command.params for option in parameter.opts}
    for example in (line for line in RUN.invoke(umbrella, [name, "--help"]).output.splitlines() if "  uavftc " in line):
        used = {word.partition("=")[0] for word in shlex.split(example) if word.startswith("--")}
        assert used <= options


def test_the_list_of_commands_cuts_none_off() -> None:
    text = RUN.invoke(umbrella, ["--help"], terminal_width=80).output
    listed = text.partition("Commands:")[2]
    assert "..." not in listed
    assert [line.split()[0] for line in listed.strip().splitlines()] == NAMES


def test_the_single_command_shows_itself_in_its_examples() -> None:
    assert "  uavftc-fly scenario3\n" in RUN.invoke(single, ["--help"]).output


def test_every_shipped_file_is_listed_with_what_it_is_about() -> None:
    listed = json.loads(RUN.invoke(umbrella, ["scenarios", "--json"]).output)
    files = {Path(entry["file"]) for entry in listed}
    assert files == set(shipped.scenario_dir().rglob("*.yaml"))
    assert all(entry["description"] for entry in listed)
    assert {entry["kind"] for entry in listed} == {"scenario", "campaign"}
    shown = RUN.invoke(umbrella, ["scenarios"]).output
    assert all(entry["name"] in shown for entry in listed)


def offered(line: str) -> list[str]:
    words = line.split(" ")
    asked = {"_UAVFTC_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1)}
    code = "import sys; sys.argv[0] = 'uavftc'; from uavftc.cli.app import umbrella; umbrella(prog_name='uavftc')"
    run = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | asked, capture_output=True, text=True, check=False
    )
    return run.stdout.split()


@pytest.mark.parametrize(
    ("line", "some"),
    [
        ("uavftc fly scenario1", ["scenario1", "scenario1-unsaturated"]),
        ("uavftc fly scenario3 --set faults[3].", ["faults[3].effectiveness=", "faults[3].bias_deg="]),
        ("uavftc fly scenario3 --set controller.inner.filter_b", ["controller.inner.filter_bandwidth="]),
        ("uavftc fly scenario1 --aircraft ha", ["hale"]),
        ("uavftc compare scenario1 --controllers pid,ndi", ["pid,ndi-l1"]),
        ("uavftc sweep paper", ["paper-faults"]),
    ],
)
def test_the_shell_is_offered_what_there_is(line: str, some: list[str]) -> None:
    found = offered(line)
    assert set(some) <= set(found)
    assert all(one.startswith(line.rsplit(" ", maxsplit=1)[-1]) for one in found)
