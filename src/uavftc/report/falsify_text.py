"""What a search for failures found, on the terminal: each controller in a line, the fault, and what was not found."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

AS_GOOD = 0.005
"""Distance of a key from nominal, in ranges, below which it is not listed."""


def print_falsify(console: Console, summary: Mapping[str, Any], folder: Path) -> None:
    """Print the document of `summary.json`."""
    searches = summary["searches"]
    title = f"{summary['campaign']}: {summary['objective']}, {summary['budget']} flights, seed {summary['seed']}"
    console.print(Text(title, style="bold"))
    console.print(_table(searches))
    for one in searches:
        console.print()
        for text in lines_of(one):
            console.print(Text(text))
    console.print()
    files = ", ".join(dict.fromkeys(one["file"] for one in searches if one["file"] is not None))
    if summary["found"] is not None:
        console.print(Text(f"fly it: uavftc-fly {folder / summary['found']['file']}"), soft_wrap=True)
    console.print(Text(f"results: {folder}{f' ({files})' if files else ''}"), soft_wrap=True)


def _table(searches: list[Mapping[str, Any]]) -> Table:
    table = Table(box=box.HORIZONTALS, show_edge=False)
    table.add_column("controller")
    for name in ("flights", "failures", "first at", "lowest margin", "nearest failure"):
        table.add_column(name, justify="right")
    for one in searches:
        table.add_row(
            name_of(one, searches),
            str(one["flights"]),
            str(one["failures"]),
            "none" if one["first_failure"] is None else str(one["first_failure"]),
            _number(one["lowest"], "margin"),
            _number(one["nearest"], "distance"),
        )
    return table


def name_of(one: Mapping[str, Any], searches: list[Mapping[str, Any]]) -> str:
    """Return the controller of a search, with plant and aircraft where there are several."""
    parts = [one["controller"]]
    for key in ("plant", "aircraft"):
        if len({other[key] for other in searches}) > 1:
            parts.append(Path(one[key]).name)
    return ", ".join(parts)


def lines_of(one: Mapping[str, Any]) -> Iterator[str]:
    """Yield what one search found, or that it found nothing, and how much was searched."""
    found, nominal = one["found"], one["nominal"]
    name = f"{one['controller']} on {Path(one['aircraft']).name}, {one['plant']}"
    if nominal is not None and nominal["outcome"] not in ("survived", "error"):
        yield f"{name}: fails at nominal already: {nominal['outcome']}, margin {nominal['margin']:.3g}"
    if found is not None:
        what = f"{found['outcome']}, margin {found['margin']:.4g} ({found['limiting']})"
        yield f"{name}: {what}, {found['distance']:.3g} from nominal, at flight {found['flight'] + 1}"
        yield from _fault(one, found)
    else:
        yield f"{name}: nothing was found that breaks it in {searched(one)}"
        if one["lowest"] is not None:
            lowest = one["lowest"]
            yield f"  lowest margin {lowest['margin']:.4g} ({lowest['limiting']}), {lowest['outcome']}: {one['file']}"
        if one["whole_space"]:
            yield "  that was every combination there is"
        elif (share := one["uniform_share_below"]) is not None:
            points = f"{one['start_points']} points alone"
            yield f"  this is no proof: by the {points} up to {100 * share:.2g} % of the ranges may fail"
    if one["errors"]:
        yield f"  {one['errors']} flights could not be flown; search.parquet has the reason"


def _fault(one: Mapping[str, Any], found: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of a fault, the furthest from nominal first; those that are as good as there in one line."""
    away = [key for key, part in found["parts"].items() if abs(part) >= AS_GOOD]
    width = max(map(len, away), default=0)
    for key in sorted(away, key=lambda key: -abs(found["parts"][key])):
        base = one["base"]["values"][key]
        yield f"  {key.ljust(width)}  {short(found['values'][key])}  (nominal {short(base)})"
    if rest := len(found["parts"]) - len(away):
        others = f"the other {rest}" if away else "all of them"
        yield f"  {others} within {100 * AS_GOOD:g} % of the range from nominal"


def searched(one: Mapping[str, Any]) -> str:
    """Return how much was searched."""
    runs = f"{one['runs']} run{'' if one['runs'] == 1 else 's'} of CMA-ES"
    return f"{one['flights']} flights: {one['start_points']} over the whole ranges, the rest in {runs}"


def short(value: Any) -> str:
    """Return a value in short."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _number(entry: Mapping[str, Any] | None, key: str) -> str:
    return "none" if entry is None else f"{entry[key]:.3f}"
