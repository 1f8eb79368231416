"""Aircraft folders in a temporary place, and a probe that leaves the user's cache alone."""

from __future__ import annotations

import shutil
from types import SimpleNamespace

import pytest

from uavftc.aircraft import load_aircraft
from uavftc.plants.jsbsim import probe
from uavftc.resources import aircraft_dir


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Let the probe remember what has loaded in a folder of this session; return it."""
    cache = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(probe, "platformdirs", SimpleNamespace(user_cache_path=lambda _name: cache))
        yield cache


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
