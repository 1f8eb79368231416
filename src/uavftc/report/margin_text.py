"""The limits that `uavftc margin` found, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

Entry = Mapping[str, Any]
"""One limit, as `--json` prints it, with `curve`: [[value, margin], ...] of every flight."""


def print_limits(console: Console, title: str, entries: Sequence[Entry]) -> None:
    """Print the table of limits, and what it does not show of each."""
    console.print(Text(title, style="bold"))
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name, justify in (("quantity", "left"), ("controller", "left"), ("holds to", "right"), ("fails at", "right")):
        table.add_column(name, justify=justify)  # type: ignore[arg-type]
    table.add_column("by")
    table.add_column("linear", justify="right")
    last = None
    for entry in entries:
        name = name_of(entry)
        if last not in (None, name):
            table.add_section()
        held, broke = entry["bracket"]
        row = (
            _number(held),
            "-" if broke is None else _number(broke),
            entry["criterion"] or "-",
            _number(entry["linear"]),
        )
        table.add_row(Text(name if name != last else ""), Text(entry["controller"]), *(Text(cell) for cell in row))
        last = name
    console.print(table)
    for line in remarks(entries):
        console.print(Text(line))


def name_of(entry: Entry) -> str:
    """Return the quantity with what it is of, and its unit."""
    of = f" of {entry['of']}" if entry["of"] else ""
    return f"{entry['quantity']}{of}" + (f" [{entry['unit']}]" if entry["unit"] else "")


def remarks(entries: Sequence[Entry]) -> list[str]:
    """Return a line where a limit is not what it seems: none found, none at the start, or not the only one."""
    lines = []
    for entry in entries:
        held, broke = entry["bracket"]
        who = f"{entry['controller']}, {name_of(entry)}"
        if held is None:
            lines.append(f"{who}: {entry['criterion']} at {_number(broke)} already, so there is no limit to find")
        elif broke is None:
            lines.append(f"{who}: survived up to {_number(held)}, the end of the range")
        elif not entry["monotone"]:
            beyond = [v for v, m in entry["curve"] if m >= 0.0 and (v - broke) * (broke - held) > 0.0]
            lines.append(f"{who}: not monotone, survived at {', '.join(map(_number, beyond))} again")
    return lines


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
