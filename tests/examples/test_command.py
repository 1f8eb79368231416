"""A command is one file and one entry of `cli.app.COMMANDS`: listed, run, and its exit codes kept."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from typer.testing import CliRunner

from uavftc.cli.app import COMMANDS, umbrella_of


@pytest.fixture
def uavftc():
    """The command line with the example as one more command."""
    spec = importlib.util.spec_from_file_location("hello", Path(__file__).with_name("hello.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return umbrella_of((*COMMANDS, module.hello))


def test_it_is_listed_with_the_others_and_runs(uavftc):
    # the help lists commands in the order of the tuple, with the first line of each
    listed = CliRunner().invoke(uavftc, ["--help"]).output
    assert listed.index("fly") < listed.index("bench") < listed.index("hello")
    assert "Greet NAME." in listed
    done = CliRunner().invoke(uavftc, ["hello", "Ada"])
    assert (done.exit_code, done.output) == (0, "hello Ada\n")


def test_wrong_input_of_it_ends_with_2_and_a_message(uavftc):
    # the exit codes are those of every command, without a line in its file
    done = CliRunner().invoke(uavftc, ["hello", "4da"])
    assert done.exit_code == 2
    for part in ("found:    '4da'", "expected: letters", "remedy:   leave out everything else"):
        assert part in done.stderr
