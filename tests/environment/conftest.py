"""A probe that leaves the user's cache alone."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from uavftc.plants.jsbsim import probe


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Let the probe remember what has loaded in a folder of this session."""
    cache = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(probe, "platformdirs", SimpleNamespace(user_cache_path=lambda _name: cache))
        yield cache
