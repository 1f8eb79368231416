"""The report of a campaign on the terminal, in 80 columns."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.report.table import number

BLOCK = 3  # variants side by side where two numbers stand in a cell
NARROW = 5  # and where one does
WIDTH = 80


def print_report(console: Console, document: Mapping[str, Any], folder: Path | None) -> None:
    """Print the document of `uavftc.jobs.sweep_report.document`; `folder` is where it was written, if it was."""
    console.print(Text(headline(document), style="bold"))
    console.print(Text(success_line(document)))
    for note in document["notes"]:
        console.print(Text.assemble(("note: ", "yellow"), note))
    _headed(console, "how often each holds", [success_table(document)])
    if document["pairs"]:
        many = len(document["pairs"])
        title = f"on the same cases; p of McNemar's exact test, times the {many} pairs"
        _headed(console, title, [pair_table(document)])
    tables = [metric_table(document, names) for names in _blocks(document, BLOCK)]
    _headed(console, "metrics: median / 95 % of the flights that have one", tables)
    if any(document["sensitivity"]["variants"].values()):
        tables = [sensitivity_table(document, names) for names in _blocks(document, NARROW)]
        _headed(console, sensitivity_title(document), tables)
    if document["worst"]:
        console.print()
        console.print(Text("the worst cases, and how to fly them again", style="bold"))
        for line in worst_lines(document["worst"]):
            console.print(Text(line), soft_wrap=True)
    if folder is not None:
        console.print(Text(f"results: {folder}"), soft_wrap=True)


def _headed(console: Console, title: str, tables: Sequence[Table]) -> None:
    console.print()
    console.print(Text(title, style="bold"))
    for table in tables:
        console.print(table)


def headline(document: Mapping[str, Any]) -> str:
    """Return what was flown."""
    unfinished = "" if document["finished"] else " so far"
    return f"{document['campaign']}: {document['cases']} cases, {document['flights']} flights{unfinished}"


def success_line(document: Mapping[str, Any]) -> str:
    """Return what counts as a success."""
    success = document["success_is"]
    if isinstance(success, str):
        return "success: the flight meets every requirement (outcome survived)"
    limits = " and ".join(f"{name} at most {limit:g}" for name, limit in success.items())
    return f"success: flown to the end, {limits} on every controlled axis"


def percent(share: float | None) -> str:
    """Return a share in percent: so many digits that what is not all is not shown as all."""
    if share is None:
        return "-"
    text = f"{100.0 * share:.1f}"
    return f"{100.0 * share:.3f}" if text == "100.0" and share < 1.0 else text


def interval_text(ends: Sequence[float]) -> str:
    """Return an interval of shares in percent."""
    return f"{percent(ends[0])} to {percent(ends[1])}"


def short(value: float | None) -> str:
    """Return a number in three digits; a dash for none."""
    return "-" if value is None else f"{value:.3g}"


def success_table(document: Mapping[str, Any]) -> Table:
    """Return a row a variant: success with its interval, the median margin, and what breaks."""
    table = _table()
    table.add_column("controller")
    for title in ("flights", "success\n[%]", "95 % interval\n[%]", "margin,\nmedian"):
        table.add_column(Text(title), justify="right")
    table.add_column(Text("margin below 0\nby"), overflow="fold")
    for one in document["variants"]:
        row = (
            one["name"],
            str(one["flights"]),
            percent(one["success"]),
            interval_text(one["interval"]),
            short(one["margin"]["median"]),
            broken_text(one),
        )
        table.add_row(*map(Text, row))
    return table


def broken_text(variant: Mapping[str, Any]) -> str:
    """Return which requirements were the limiting ones of flights with a margin below 0, the three most frequent."""
    broken = list(variant["broken"].items())
    parts = [f"{name} {count}" for name, count in broken[:3]]
    rest = sum(count for _, count in broken[3:])
    return ", ".join([*parts, *([f"others {rest}"] if rest else [])]) or "none"


def pair_table(document: Mapping[str, Any]) -> Table:
    """Return a row a pair: who succeeds where the other does not, the p-value, and by how much the margins differ."""
    table = _table()
    table.add_column(Text("first\nsecond"))
    for title in ("only\nfirst", "only\nsecond", "p", "margin, first - second\nmean [95 %]", "first\nbetter"):
        table.add_column(Text(title), justify="right")
    for one in document["pairs"]:
        margin = one["margin"]
        ends = margin["mean_interval"]
        mean = "-" if margin["mean"] is None else f"{margin['mean']:+.3f}"
        if ends is not None:
            mean += f" [{ends[0]:+.3f}, {ends[1]:+.3f}]"
        better = "-" if margin["first_better"] is None else f"{100.0 * margin['first_better']:.0f} %"
        row = (
            f"{one['first']}\n{one['second']}",
            str(one["only_first"]),
            str(one["only_second"]),
            p_text(one["p_adjusted"]),
            mean,
            better,
        )
        table.add_row(*map(Text, row))
    return table


def p_text(p: float) -> str:
    """Return a p-value; what is below 1e-4 as a bound."""
    return "< 1e-4" if p < 1e-4 else f"{p:.2g}"


def metric_table(document: Mapping[str, Any], names: Sequence[str]) -> Table:
    """Return a row a metric and axis: median and 95 % quantile over the flights of each variant."""
    table = _table()
    table.add_column("", no_wrap=True)
    for name in names:
        table.add_column(Text(name), justify="right", overflow="fold")
    for one in document["metrics"]:
        cells = [metric_text(one["variants"][name]) for name in names]
        table.add_row(*map(Text, (f"{one['axis']} {one['label']}, {one['unit']}", *cells)))
    return table


def metric_text(spread: Mapping[str, Any]) -> str:
    """Return median and 95 % quantile."""
    return f"{_two(spread['median'])} / {_two(spread['p95'])}" if spread["flights"] else "-"


def _two(value: float) -> str:
    digits = 0 if value == 0 else max(0, 1 - math.floor(math.log10(abs(value))))
    return number(value, min(digits, 4))


def sensitivity_table(document: Mapping[str, Any], names: Sequence[str]) -> Table:
    """Return a row a key, the most influential first: its index on the margin of each variant, and which way."""
    table = _table()
    table.add_column("", no_wrap=True)
    for name in names:
        table.add_column(Text(name), justify="right", overflow="fold")
    said = document["sensitivity"]["variants"]
    for key in document["sensitivity"]["order"]:
        cells = [sensitivity_text((said[name] or {}).get(key)) for name in names]
        table.add_row(*map(Text, (key, *cells)))
    return table


def sensitivity_title(document: Mapping[str, Any]) -> str:
    """Return what the numbers are."""
    if document["sensitivity"]["method"] is None:
        return "what matters: rank correlation of the margin"
    return "what matters to the margin: PAWN index, .. no more than chance; + - which way"


def sensitivity_text(one: Mapping[str, Any] | None) -> str:
    """Return an index with the sign of the rank correlation, or two dots where it is no more than chance gives."""
    if one is None:
        return "-"
    rank = one["rank_correlation"]
    if one["index"] is None:
        return "-" if rank is None else f"{rank:+.2f}"
    if one["index"] <= one["chance"]:
        return ".."
    sign = "" if rank is None or abs(rank) < 0.05 else " +" if rank > 0 else " -"
    return f"{one['index']:.2f}{sign or '  '}"


def worst_lines(worst: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield what became of each flight, and the command that flies it again, folded for a shell."""
    for one in worst:
        because = one["reason"] or f"{one['limiting']} broken" if one["margin"] < 0 else f"limited by {one['limiting']}"
        yield f"case {one['case']}, {one['variant']}: margin {one['margin']:.4f}, {one['outcome']}; {because}"
        if one["command"] is None:
            yield "  (no command: the folder holds no scenarios)"
        else:
            yield from folded(one["command"])


def folded(command: str) -> list[str]:
    """Return the lines of a command, none longer than 80 columns where its words allow it, with line continuations."""
    lines = [""]
    words = " ".join(map(shlex.quote, shlex.split(command))).replace(" --set ", "\0--set ").split("\0")
    for word in words:
        if lines[-1] and len(lines[-1]) + 1 + len(word) > WIDTH - 4:
            lines.append("")
        lines[-1] += f" {word}" if lines[-1] else word
    return [f"  {line} \\" for line in lines[:-1]] + [f"  {lines[-1]}"]


def _blocks(document: Mapping[str, Any], many: int) -> Iterator[list[str]]:
    names = [one["name"] for one in document["variants"]]
    for first in range(0, len(names), many):
        yield names[first : first + many]


def _table() -> Table:
    return Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0), show_edge=False)
