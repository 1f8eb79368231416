"""matplotlib, imported whatever MPLBACKEND says: figures go to files, and no backend of the user's is asked."""

from __future__ import annotations

import contextlib
import os


def load_matplotlib() -> None:
    """Import matplotlib; a backend that it does not know, which would end the import, is left aside."""
    name = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib as mpl  # noqa: PLC0415 - takes most of a second
    finally:
        if name is not None:
            os.environ["MPLBACKEND"] = name
    if name is not None:
        with contextlib.suppress(ValueError):
            mpl.rcParams["backend"] = name
