"""Entry points of the scripts. Before all else they see to Ctrl-C: the imports take longer than some flights."""

from __future__ import annotations

from uavftc.cli import early

early.end_at_once()


def main() -> None:
    """Entry point of `uavftc`."""
    from uavftc.cli.app import main as run  # noqa: PLC0415

    run()


def main_fly() -> None:
    """Entry point of `uavftc-fly`."""
    from uavftc.cli.app import main_fly as run  # noqa: PLC0415

    run()
