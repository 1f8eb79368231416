"""The tables of a comparison: on the terminal, as Markdown, and as CSV. Its document is `uavftc.jobs.compare`'s."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.analysis import metrics
from uavftc.analysis.metrics import Metric
from uavftc.core.signals import AXES
from uavftc.report.table import cell, number, outcome_line
from uavftc.report.verdict import COLOURS, margin_text

WIDTH = 80
_LEAST = 11  # characters of a flight's column
_SIZES = (
    ("attitude, rms [deg]", "attitude_deg", "rms"),
    ("attitude, largest [deg]", "attitude_deg", "largest"),
    ("body rates, rms [deg/s]", "rates_degps", "rms"),
    ("body rates, largest [deg/s]", "rates_degps", "largest"),
)
PLACES = (*AXES, "all")


def print_comparison(
    console: Console, document: dict[str, Any], folder: Path | None, *, aside: Console | None = None
) -> None:
    """Print the tables, how each flight that did not reach its end was lost, warnings, and where the results are.

    Warnings are printed on `aside`, where there is one.
    """
    console.print(Text(title_of(document), style="bold"))
    for table in [*metric_tables(document), *distance_tables(document)]:
        console.print()
        console.print(table)
    console.print()
    for line in variant_lines(document):
        console.print(Text(line))
    for flight in document["combinations"]:
        if not flight["completed"]:
            console.print(Text.assemble(f"{name_of(flight)}: ", outcome_line(flight)))
    for warning in document["warnings"]:
        (aside or console).print(Text.assemble(("warning: ", "yellow"), warning))
    if folder is not None:
        console.print(Text(f"results: {folder}"), soft_wrap=True)


def title_of(document: dict[str, Any]) -> str:
    """Return the heading of a comparison."""
    return f"{document['scenario']} on {document['aircraft']}"


def name_of(flight: dict[str, Any]) -> str:
    """Return the name of one flight of a comparison."""
    return f"{flight['plant']}, {flight['controller']}"


def variant_lines(document: dict[str, Any]) -> list[str]:
    """Return a line for each variant: of which controller, and what it changes."""
    lines = {
        f["controller"]: f"{f['controller']}: {f['variant']['of']} with {', '.join(f['variant']['changes'])}"
        for f in document["combinations"]
        if "variant" in f
    }
    return list(lines.values())


def metric_tables(document: dict[str, Any]) -> list[Table]:
    """Return the metrics of all flights side by side: one table, or one a plant where one would be too wide."""
    return [_metric_table(block) for block in _blocks(document)]


def _metric_table(flights: Sequence[dict[str, Any]]) -> Table:
    table = _table()
    table.add_column("")
    for flight in flights:
        lost = Text("") if flight["completed"] else Text("\nLOST", style="bold red")
        heading = Text(f"{flight['plant']}\n{flight['controller']}").append_text(lost)
        table.add_column(heading, justify="right", min_width=_LEAST, overflow="fold")
    for label, judged in _verdict_rows(flights):
        table.add_row(Text(label, style="bold"), *judged)
    for axis in AXES:
        table.add_row(Text(_named(axis, flights), style="bold"))
        for metric in metrics.METRICS:
            cells = (_cell(metric, flight, axis) for flight in flights)
            table.add_row(Text(metric.title), *cells)
    return table


def _verdict_rows(flights: Sequence[dict[str, Any]]) -> list[tuple[str, list[Text]]]:
    """Return outcome, margin and what limits it, of each flight; the best margin in bold."""
    verdicts = [flight["verdict"] for flight in flights]
    best = max((verdict["margin"] for verdict in verdicts if verdict is not None), default=None)
    none = Text("-")
    return [
        ("verdict", [none if v is None else Text(v["outcome"], style=COLOURS[v["outcome"]]) for v in verdicts]),
        ("margin", [none if v is None else _margin(v["margin"], best) for v in verdicts]),
        ("limited by", [none if v is None else Text(v["limiting"] or "-") for v in verdicts]),
    ]


def _margin(margin: float, best: float | None) -> Text:
    return Text(margin_text(margin), style="bold" if margin == best else "")


def _table() -> Table:
    return Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 0, 0, 1), show_edge=False)


def distance_tables(document: dict[str, Any]) -> list[Table]:
    """Return, for each two plants, how far the flights of each controller are apart."""
    tables = []
    for plants, entries in _pairs(document).items():
        table = _table()
        table.add_column(plants)
        for place in PLACES:
            table.add_column(place, justify="right", min_width=10)
        for entry in entries:
            table.add_row(Text(_heading(entry, document), style="bold"))
            for label, *path in _SIZES:
                table.add_row(Text(label), *(Text(_plain(_size(entry, place, *path))) for place in PLACES))
        tables.append(table)
    return tables


def _pairs(document: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    pairs: dict[str, list[dict[str, Any]]] = {}
    for entry in document["distances"]:
        pairs.setdefault(" against ".join(entry["plants"]), []).append(entry)
    return pairs


def _heading(entry: dict[str, Any], document: dict[str, Any]) -> str:
    """Return the controller, and for how long both flew if that was not to the end."""
    flown = (f for f in document["combinations"] if f["controller"] == entry["controller"])
    part = "" if all(f["completed"] for f in flown) else f", until {entry['until_s']:g} s"
    return f"{entry['controller']}{part}"


def markdown(document: dict[str, Any]) -> str:
    """Return the tables as GitHub Markdown."""
    lines = [f"# {title_of(document)}", ""]
    if variants := variant_lines(document):
        lines += ["## Variants", "", *(f"- {line}" for line in variants), ""]
    for block in _blocks(document):
        header = ["", *(name_of(flight) + ("" if flight["completed"] else " (lost)") for flight in block)]
        rows = [
            [label, *(f"**{cell.plain}**" if cell.style == "bold" else cell.plain for cell in cells)]
            for label, cells in _verdict_rows(block)
        ]
        for axis in AXES:
            rows += [
                [f"{_named(axis, block)}: {metric.title}", *(_written(metric, flight, axis) for flight in block)]
                for metric in metrics.METRICS
            ]
        lines += [*_markdown_table(header, rows), ""]
    for plants, rows in distance_rows(document).items():
        lines += [f"## Distance, {plants}", "", *_markdown_table(["", *PLACES], rows), ""]
    lost = [f"- {name_of(f)}: {f['ended_because']}" for f in document["combinations"] if not f["completed"]]
    if lost:
        lines += ["## Lost", "", *lost, ""]
    return "\n".join(lines)


def distance_rows(document: dict[str, Any]) -> dict[str, list[list[str]]]:
    """Return, by two plants, how far the flights are apart: name and size in each of `PLACES`, a line each."""
    return {
        plants: [
            [f"{_heading(entry, document)}: {label}", *(_plain(_size(entry, place, *path)) for place in PLACES)]
            for entry in entries
            for label, *path in _SIZES
        ]
        for plants, entries in _pairs(document).items()
    }


def tidy_csv(document: dict[str, Any]) -> str:
    """Return one line a number: plant, controller, axis, metric, value; a value that does not apply is empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["plant", "controller", "axis", "metric", "value"])
    for flight in document["combinations"]:
        for axis in AXES:
            for metric in metrics.METRICS:
                value = flight["axes"][axis][metric.name]
                written = "" if value is None else repr(value)
                writer.writerow([flight["plant"], flight["controller"], axis, metric.name, written])
    return text.getvalue()


def _blocks(document: dict[str, Any]) -> Iterator[list[dict[str, Any]]]:
    """Yield the flights for each table: all in one, or of each plant as many as fit next to each other."""
    flights = document["combinations"]
    if _width(flights) <= WIDTH:
        yield flights
        return
    for plant in document["plants"]:
        block: list[dict[str, Any]] = []
        for flight in (flight for flight in flights if flight["plant"] == plant):
            if block and _width([*block, flight]) > WIDTH:
                yield block
                block = []
            block.append(flight)
        yield block


def _width(flights: Sequence[dict[str, Any]]) -> int:
    """Return the characters that a table of these flights takes."""
    names = (max(_LEAST, len(flight["plant"]), len(flight["controller"])) for flight in flights)
    return max(len(metric.title) for metric in metrics.METRICS) + 1 + sum(name + 1 for name in names)


def _size(entry: dict[str, Any], place: str, quantity: str, size: str) -> float | None:
    value: float | None = entry[quantity][place][size]
    return value


def _plain(value: float | None) -> str:
    return "-" if value is None else number(value, 4)


def _written(metric: Metric, flight: dict[str, Any], axis: str) -> str:
    return _cell(metric, flight, axis).plain.replace("\n", " ")


def _cell(metric: Metric, flight: dict[str, Any], axis: str) -> Text:
    return cell(metric, flight["axes"][axis][metric.name], flight["completed"] and _controlled(flight, axis))


def _controlled(flight: dict[str, Any], axis: str) -> bool:
    return metrics.controlled_of(flight["axes"])[AXES.index(axis)]


def _named(axis: str, flights: Sequence[dict[str, Any]]) -> str:
    """Return an axis' heading, which says where none of the flights controls it."""
    return axis if any(_controlled(flight, axis) for flight in flights) else f"{axis}, not controlled"


def _markdown_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    ruler = ["---", *["---:"] * (len(header) - 1)]
    return ["| " + " | ".join(text.replace("|", "\\|") for text in line) + " |" for line in (header, ruler, *rows)]
