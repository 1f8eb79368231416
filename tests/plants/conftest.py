"""Aircraft folders in a temporary place, and JSBSim plants of them."""

from __future__ import annotations

import shutil

import pytest

from uavftc.aircraft.definition import load_aircraft
from uavftc.config.shipped import aircraft_dir


@pytest.fixture(scope="session")
def hale():
    """The shipped aircraft."""
    return load_aircraft("hale")


@pytest.fixture
def edited(tmp_path):
    """Copy hale, change one file by (old, new) pairs, and return the copy's folder."""

    def edit(file, *changes):
        folder = tmp_path / "hale"
        shutil.copytree(aircraft_dir() / "hale", folder)
        path = folder / file
        text = path.read_text(encoding="utf-8")
        for old, new in changes:
            assert old in text, f"{file} has no {old!r}: the test changes nothing"
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
        return folder

    return edit
