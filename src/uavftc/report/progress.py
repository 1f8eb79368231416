"""A progress bar on standard error, where there is somebody to look at it."""

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
    # Refreshed by the flight itself, a few times a second: a drawing thread would wait for compiled code anyway.
    with Progress(*columns, console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(label, total=max(total_rows, 1))
        bar.refresh()
        last = bar.get_time()

        def advance(rows_done: int) -> None:
            nonlocal last
            now = bar.get_time()
            if now - last >= 0.1 or rows_done >= total_rows:
                bar.update(task, completed=rows_done, refresh=True)
                last = now

        yield advance


def _ignore(rows_done: int) -> None:
    pass
