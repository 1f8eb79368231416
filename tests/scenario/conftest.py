"""Scenario files written on the spot."""

from __future__ import annotations

import textwrap

import pytest

from uavftc.errors import InputError
from uavftc.scenario.load import load_scenario

HEAD = "name: test\nduration_s: 20\n"


@pytest.fixture
def write(tmp_path):
    """Write a scenario: two lines of head, then the text; return its path."""

    def _write(text="", head=HEAD):
        path = tmp_path / "test.yaml"
        text = text if isinstance(text, bytes) else (head + textwrap.dedent(text)).encode()
        path.write_bytes(text)
        return path

    return _write


@pytest.fixture
def load(write):
    """Write a scenario and load it."""
    return lambda text="", **options: load_scenario(write(text), **options)


@pytest.fixture
def refused(write):
    """Write a scenario, load it, return the error it must give."""

    def _refused(text="", head=HEAD, **options):
        path = write(text, head)
        with pytest.raises(InputError) as error:
            load_scenario(path, **options)
        return error.value

    return _refused
