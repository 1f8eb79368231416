"""A progress bar on standard error, if that is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress(total_rows: int, *, label: str = "flying", quiet: bool = False) -> Iterator[Callable[[int], None]]:
    """Show how far a flight has come; yields `advance(rows_done)`, to be called with the rows done so far in all.

    Nothing is shown, and rich is not imported, when `quiet` or when standard error is not a terminal. The bar
    disappears at the end, so that only results stay on the screen.
    """
    with stages(quiet=quiet) as show:
        show(0, total_rows, label)
        yield lambda rows_done: show(rows_done, total_rows, label)


@contextmanager
def stages(*, quiet: bool = False) -> Iterator[Callable[[int, int, str], None]]:
    """Show a job of several stages; yields `advance(done, total, label)`. Shown where `progress` is shown."""
    if quiet or not sys.stderr.isatty():
        yield _ignore
        return

    from rich.console import Console  # noqa: PLC0415
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn  # noqa: PLC0415

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
    )
    # Refreshed by the job itself, a few times a second: a drawing thread would wait for compiled code anyway.
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task("", total=1)
        last = bar.get_time() - 1.0

        def advance(done: int, total: int, label: str) -> None:
            nonlocal last
            now = bar.get_time()
            if now - last >= 0.1 or done >= total:
                bar.update(task, completed=done, total=max(total, 1), description=label, refresh=True)
                last = now

        yield advance


def _ignore(done: int, total: int, label: str) -> None:
    pass
