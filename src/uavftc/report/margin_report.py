"""The limits that `uavftc margin` found: as a table, and as a figure of the margin against each quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
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


def draw_limits(file: Path, title: str, entries: Sequence[Entry]) -> None:
    """Draw the margin against each quantity, one line a controller, the limit where it crosses 0."""
    import matplotlib.pyplot as plt  # noqa: PLC0415 - takes most of a second

    from uavftc.report import palette  # noqa: PLC0415

    names = list(dict.fromkeys(name_of(entry) for entry in entries))
    controllers = list(dict.fromkeys(entry["controller"] for entry in entries))
    looks = palette.controllers(controllers)
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    fig, axes = plt.subplots(rows, columns, figsize=(4.2 * columns + 0.6, 3.0 * rows + 1.0), squeeze=False, sharey=True)
    for ax, name in zip(axes.flat, names, strict=False):
        of_it = [entry for entry in entries if name_of(entry) == name]
        for entry in of_it:
            curve = sorted(entry["curve"])
            x, y = [v for v, _ in curve], [m for _, m in curve]
            label = entry["controller"]
            ax.plot(x, y, **looks[label], markersize=3.5, linewidth=1.2, label=label)
        values = sorted({v for entry in of_it for v, _ in entry["curve"]})
        positive = [v for v in values if v > 0.0]
        if positive and positive[-1] / positive[0] >= 30.0:
            if values[0] <= 0.0:
                ax.set_xscale("symlog", linthresh=positive[0])
            else:
                ax.set_xscale("log")
        ax.axhline(0.0, color="0.3", linewidth=0.8)
        ax.axhspan(-2.05, -1.0, color="0.9", zorder=0)
        ax.set_xlabel(name)
        ax.set_ylim(-2.05, 1.05)
        ax.grid(True, color="0.92")
    for ax in list(axes.flat)[len(names) :]:
        ax.set_visible(False)
    for row in axes:
        row[0].set_ylabel("margin")
    handles, labels = axes[0][0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="lower center", ncols=min(len(labels), 5), frameon=False)
    fig.suptitle(f"{title}: margin of the verdict (below 0 broken, grey: lost)", fontsize=11)
    fig.tight_layout(rect=(0, 0.5 / (3.0 * rows + 1.0), 1, 1))
    fig.savefig(file, dpi=110)
    plt.close(fig)
