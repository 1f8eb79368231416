"""The table of metrics and the closing block on the terminal. Plain ASCII, so that it prints anywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.analysis import metrics
from uavftc.analysis.metrics import Metric
from uavftc.core.signals import AXES
from uavftc.report.verdict import requirement_table, twin_table, verdict_line
from uavftc.results.summary import title_of


def metric_table(summary: dict[str, Any]) -> Table:
    """Return the metrics of a `summary.json` document, one column an axis."""
    table = Table(
        title=Text(title_of(summary), style="bold"), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False
    )
    table.add_column("")
    controlled = metrics.controlled_of(summary["axes"])
    for axis, own in zip(AXES, controlled, strict=True):
        table.add_column(axis if own else f"{axis}\nnot controlled", justify="right", min_width=11)
    for metric in metrics.METRICS:
        cells = (
            cell(metric, summary["axes"][axis][metric.name], summary["completed"] and own)
            for axis, own in zip(AXES, controlled, strict=True)
        )
        table.add_row(Text(metric.title), *cells)  # as Text: "[deg]" would be taken for markup
    return table


def print_result(
    console: Console, summary: dict[str, Any], folder: Path | None, *, aside: Console | None = None
) -> None:
    """Print the closing block: table, how the flight ended, how long it took, warnings, and where the results are.

    Parameters
    ----------
    console
        Where to print; it decides whether there is colour (NO_COLOR, a pipe).
    summary
        The document of `summary.json`.
    folder
        The result folder, or None if nothing was kept.
    aside
        Where to print the warnings, where that is another place.
    """
    console.print(metric_table(summary))
    if (verdict := summary.get("verdict")) is not None:
        if verdict["requirements"]:
            console.print(requirement_table(verdict))
        console.print(verdict_line(verdict))
    if (twin := summary.get("twin")) is not None:
        console.print(twin_table(twin))
        console.print(Text.assemble("the same without faults: ", verdict_line(twin["verdict"])))
    console.print(outcome_line(summary))
    for warning in summary.get("warnings", ()):
        (aside or console).print(Text.assemble(("warning: ", "yellow"), warning))
    if folder is not None:
        # One line whatever its length, so that it can be copied.
        console.print(Text(f"results: {folder}"), soft_wrap=True)


def outcome_line(summary: dict[str, Any]) -> Text:
    """Return how the flight of a `summary.json` document ended, and how long it took."""
    timing = summary["timing"]
    steps, wall = timing["controller_steps"], timing["flight_wall_s"]
    pace = f"; {steps} controller steps in {wall:.2f} s"
    if summary["completed"]:
        return Text.assemble(("completed", "bold green"), pace)
    because = summary["ended_because"] or "for an unknown reason"
    if summary.get("numerical"):
        return Text.assemble(("not flown to its end", "bold magenta"), f": {because}", pace)
    if because.startswith("interrupted"):
        return Text.assemble((because, "bold yellow"), pace)
    return Text.assemble(("lost", "bold red"), f": {because}", pace)


def cell(metric: Metric, value: float | None, applies: bool) -> Text:
    """Return a metric as shown, coloured by how good it is; None is a dash, or what the metric has for it.

    `applies`: whether the flight reached its end and the axis is controlled.
    """
    if value is None:
        missing = metric.missing if applies else "-"
        return Text(missing, style="dim" if missing == "-" else "yellow")
    return Text(number(value, metric.digits), style=_style(metric, value))


def _style(metric: Metric, value: float) -> str:
    if metric.good is None:
        return ""
    return "green" if value <= metric.good else "yellow" if value <= metric.poor else "red"


def number(value: float, digits: int) -> str:
    """Return `value` with fixed decimals, or as a power of ten where these would hide or flood it."""
    hidden = value != 0 and abs(value) < 5 * 10.0**-digits
    return f"{value:.1e}" if hidden or abs(value) >= 1e5 else f"{value:.{digits}f}"
