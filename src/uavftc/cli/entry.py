"""Entry points of the scripts. Before all else they see to Ctrl-C: the imports take longer than some flights."""

from __future__ import annotations

from typing import NoReturn

from uavftc.cli import interrupt

interrupt.end_at_once()


def main() -> NoReturn:
    """Entry point of `uavftc`."""
    from uavftc.cli.app import main as run  # noqa: PLC0415

    run()


def main_fly() -> NoReturn:
    """Entry point of `uavftc-fly`."""
    from uavftc.cli.app import main_fly as run  # noqa: PLC0415

    run()
