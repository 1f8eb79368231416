"""The table of metrics and the closing block on the terminal. Plain ASCII of our own, so that it prints anywhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from uavftc.core.signals import AXES

BAND_DEG = 0.02  # deg, the band of the convergence time
_FAR_DEG = 0.2  # deg, ten times the band

ROWS = (
    ("steady-state error [deg]", "steady_state_error_deg"),
    ("convergence time [s]", "convergence_time_s"),
    ("IAE [rad s]", "iae"),
    ("ISE [rad^2 s]", "ise"),
    ("ITAE [rad s^2]", "itae"),
    ("ITSE [rad^2 s^2]", "itse"),
    ("control activity [rad]", "control_activity_rad"),
)
"""Label and name of each metric, in the order shown."""


def metric_table(summary: dict[str, Any]) -> Table:
    """Return the paper's six metrics and the control activity of a `summary.json` document, one column an axis."""
    table = Table(
        title=Text(title_of(summary), style="bold"), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False
    )
    table.add_column("")
    for axis in AXES:
        table.add_column(axis, justify="right", min_width=11)
    for label, metric in ROWS:
        cells = (cell(metric, summary["axes"][axis][metric], summary["completed"]) for axis in AXES)
        table.add_row(Text(label), *cells)  # as Text: "[deg]" would be taken for markup
    return table


def title_of(summary: dict[str, Any]) -> str:
    """Return what was flown, in one line; of an aircraft given as a path its folder's name."""
    return "{scenario}: {controller} on {name}, {plant}".format(**summary, name=Path(summary["aircraft"]).name)


def print_result(console: Console, summary: dict[str, Any], folder: Path | None) -> None:
    """Print the closing block: table, how the flight ended, how long it took, warnings, and where the results are.

    Parameters
    ----------
    console
        Where to; whether there is colour is its affair (NO_COLOR, a pipe).
    summary
        The document of `summary.json`.
    folder
        The result folder, or None if nothing was kept.
    """
    console.print(metric_table(summary))
    console.print(outcome_line(summary))
    for warning in summary.get("warnings", ()):
        console.print(Text.assemble(("warning: ", "yellow"), warning))
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
    if because.startswith("interrupted"):
        return Text.assemble((because, "bold yellow"), pace)
    return Text.assemble(("lost", "bold red"), f": {because}", pace)


def cell(metric: str, value: float | None, completed: bool) -> Text:
    """Return a metric as shown, coloured by how good it is; None is a dash, or words where it means not converged."""
    if value is None:
        if metric == "convergence_time_s" and completed:
            return Text("not within\nthe flight", style="yellow")
        return Text("-", style="dim")
    return Text(number(value, 2 if metric == "convergence_time_s" else 4), style=_style(metric, value))


def _style(metric: str, value: float) -> str:
    if metric == "steady_state_error_deg":
        return "green" if abs(value) <= BAND_DEG else "yellow" if abs(value) <= _FAR_DEG else "red"
    return "green" if metric == "convergence_time_s" else ""


def number(value: float, digits: int) -> str:
    """Return `value` with fixed decimals, or as a power of ten where these would hide or flood it."""
    hidden = value != 0 and abs(value) < 5 * 10.0**-digits
    return f"{value:.1e}" if hidden or abs(value) >= 1e5 else f"{value:.{digits}f}"
