"""The list of shipped scenarios and campaigns on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.scenario.catalogue import CAMPAIGN, Entry


def print_catalogue(console: Console, entries: Sequence[Entry]) -> None:
    """Print each entry with its first sentence, scenarios and campaigns apart, and how to use them."""
    scenarios = [entry for entry in entries if entry.kind != CAMPAIGN]
    campaigns = [entry for entry in entries if entry.kind == CAMPAIGN]
    for title, some in (("scenarios: uavftc fly NAME", scenarios), ("campaigns: uavftc sweep NAME", campaigns)):
        table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 0, 0, 1), show_edge=False)
        table.add_column(Text(title), no_wrap=True)
        table.add_column("")
        for entry in some:
            table.add_row(Text(entry.name), Text(entry.description.partition(". ")[0].removesuffix(".")))
        console.print(table)
        console.print()
    folder = entries[0].file.rpartition(entries[0].name)[0]
    console.print(Text(f"files: {folder} (copy one to make it yours)"), soft_wrap=True)
