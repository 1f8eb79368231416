"""What came of a campaign, on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_sweep(console: Console, summary: Mapping[str, Any]) -> None:
    """Print how many flights of each controller ended how, from the document of `summary.json`."""
    title = f"{summary['campaign']}: {summary['cases']} cases, {summary['flights']} flights"
    console.print(Text(title, style="bold"))
    if "until_width" in summary:
        known = "ended there: no interval of success is" if summary["narrow"] else "an interval of success is still"
        console.print(Text(f"{known} wider than {summary['until_width']:g}"))
    controllers = summary["controllers"]
    columns = list(next(iter(controllers.values())))
    table = Table(box=box.HORIZONTALS, show_edge=False)
    table.add_column("controller")
    for name in columns:
        table.add_column(name, justify="right")
    for name, counts in controllers.items():
        table.add_row(name, *(str(counts[column]) for column in columns))
    console.print(table)
