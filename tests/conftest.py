from __future__ import annotations

import functools
import signal
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


# A shell that starts the tests in the background makes them, and their children, deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Keep trimmed models and copies of aircraft in a folder of this session; return it.

    Compiled laws stay in the user's cache: they are the same, and compiling them takes longer than most tests.
    """
    from uavftc.core.cache import cache_folder
    from uavftc.plants.jsbsim import copy, model

    cache = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        for module in (model, copy):
            patch.setattr(module, "cache_folder", functools.partial(cache_folder, home=cache))
        yield cache
