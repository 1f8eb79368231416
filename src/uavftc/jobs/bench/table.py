"""The figures of a benchmark for reading."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

QUIET = 0.5  # load average at the start; above it something else was running


def figures_of(document: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield every figure of the document of `uavftc bench --json` with its full name."""
    for name, entry in document.items():
        if not isinstance(entry, dict) or name == "machine":
            continue
        if "median" in entry:
            yield name, entry
        else:
            yield from ((f"{name}.{part}", figure) for part, figure in entry.items())


def print_figures(console: Console, document: dict[str, Any]) -> None:
    """Print figure, median, spread, bar, and whether it is met."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for header in ("", "median", "least", "most", "bar", "met"):
        table.add_column(header, justify="right" if header else "left", no_wrap=True)
    reasons = []
    for name, entry in figures_of(document):
        if entry["median"] is None:
            table.add_row(Text(name), "-", "-", "-", "", "")
            reasons.append(f"{name}: {entry['reason']}")
            continue
        bar = next(
            (f"{sign} {entry[key]:g}" for key, sign in (("at_most", "<="), ("at_least", ">=")) if key in entry), ""
        )
        met = Text({True: "yes", False: "no"}[entry["met"]], "green" if entry["met"] else "red") if bar else Text("")
        table.add_row(Text(name), *map(_short, (entry["median"], *entry["spread"])), bar, met)
    console.print(table)
    for reason in reasons:
        console.print(Text(reason), soft_wrap=True)
    machine = document["machine"]
    measured_on = (
        f"{document['rounds']} rounds; {machine['system']}, {machine['cores']} cores; python {machine['python']}, "
        f"jsbsim {machine['jsbsim']}, numba {machine['numba']}"
    )
    console.print(Text(measured_on), soft_wrap=True)
    if (machine["load_average"] or 0.0) > QUIET:
        busy = f"the machine was busy (load average {machine['load_average']:.1f}): measure again when it is not"
        console.print(Text(busy, "yellow"), soft_wrap=True)


def _short(value: float) -> str:
    return f"{value:.4g}" if abs(value) < 1000.0 else f"{value:.0f}"
