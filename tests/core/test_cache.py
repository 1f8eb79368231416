"""The home of the caches, and what is used where it is not safe or cannot be written."""

from __future__ import annotations

import os

import pytest

from uavftc.core import cache
from uavftc.core.cache import cache_folder, cache_home


@pytest.fixture
def home(tmp_path, monkeypatch):
    """The home of the caches, not made yet; the system's temporary folder is tmp_path/temporary."""
    monkeypatch.setenv("UAVFTC_CACHE_DIR", str(tmp_path / "home"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(cache.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path / "temporary"))
    cache._of_this_process.cache_clear()
    yield tmp_path / "home"
    cache._of_this_process.cache_clear()


def test_one_variable_moves_every_cache(home, monkeypatch):
    # without it, or where it is empty, the system's place for caches is used
    assert cache_home() == home
    for unset in (lambda: monkeypatch.setenv("UAVFTC_CACHE_DIR", ""), lambda: monkeypatch.delenv("UAVFTC_CACHE_DIR")):
        unset()
        assert cache_home() == cache.platformdirs.user_cache_path("uavftc")


def test_laws_models_copies_and_fleet_lie_in_the_one_home(home, monkeypatch):
    # the four that there are, each in its own folder of it
    from uavftc.aircraft.definition import load_aircraft
    from uavftc.core.compile_cache import compile_cache_dir
    from uavftc.jobs.design import fleet
    from uavftc.plants.jsbsim import copy, model

    monkeypatch.setattr(model, "cache_folder", cache_folder)
    monkeypatch.setattr(copy, "cache_folder", cache_folder)
    assert compile_cache_dir.__wrapped__().parent == home
    assert model.cache_dir().parent == home / "models"
    assert home / "aircraft" in copy.copy_of(load_aircraft("jsbsim:c172p")).parents
    assert home / "fleet" in fleet._file("hale").parents


@pytest.mark.skipif(os.name != "posix", reason="the system has other permissions")
def test_a_folder_is_made_for_this_user_alone(home):
    # also where the mask of new files lets a group write: what is there is run
    before = os.umask(0o002)
    try:
        folder = cache_folder("models", "abc")
    finally:
        os.umask(before)
    assert folder == home / "models" / "abc"
    for made in (home, home / "models", folder):
        assert made.stat().st_mode & 0o777 == 0o700


@pytest.mark.skipif(os.name != "posix", reason="the system has other permissions")
@pytest.mark.parametrize("unsafe", ["", "models", "models/abc"])
def test_a_folder_that_others_can_write_to_is_not_used(unsafe, home, tmp_path):
    # at any level: who can write to a folder can replace what is below it
    cache_folder("models", "abc")
    (home / unsafe).chmod(0o777)
    folder = cache_folder("models", "abc")
    assert folder == tmp_path / "temporary" / f"uavftc-{os.getuid()}" / "models" / "abc"
    assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(os.name != "posix", reason="the system has other permissions")
def test_a_folder_of_another_user_is_not_used(home, tmp_path, monkeypatch):
    # the temporary folder that another user has made in advance does not serve either
    cache_folder("models")
    stranger = os.getuid() + 1
    monkeypatch.setattr(cache.os, "getuid", lambda: stranger)
    folder = cache_folder("models")
    assert folder.parent.parent == tmp_path / "temporary"
    assert folder.parent.name != f"uavftc-{stranger}"


def test_a_home_that_cannot_be_made_falls_back_to_a_private_folder(home, tmp_path):
    # a read-only home or cache costs time, not the flight
    home.write_text("a file")
    folder = cache_folder("models")
    assert (tmp_path / "temporary") in folder.parents
    assert os.access(folder, os.W_OK)


def test_a_home_that_is_read_only_is_not_used(home, tmp_path, monkeypatch):
    # the folder exists and may be entered, but not written
    access = os.access
    monkeypatch.setattr(cache.os, "access", lambda p, mode: "temporary" in str(p) and access(p, mode))
    assert (tmp_path / "temporary") in cache_folder("models").parents


def test_without_any_writable_place_a_fresh_temporary_folder_serves(home, tmp_path, monkeypatch):
    # the last resort is never shared with another process, and is one for all of this one
    monkeypatch.setattr(cache.os, "access", lambda *_: False)
    folder = cache_folder("models")
    assert folder.is_dir()
    assert folder.parent.parent == tmp_path / "temporary"
    assert folder.parent.name.startswith("uavftc-")
    assert cache_folder("models") == folder
    assert cache_folder("fleet").parent == folder.parent


def test_another_home_can_be_named(home, tmp_path):
    # compiled laws have a separate variable
    assert cache_folder("abc", home=tmp_path / "other") == tmp_path / "other" / "abc"
    assert not home.exists()
